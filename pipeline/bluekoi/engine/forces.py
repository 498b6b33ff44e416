"""Forces of a fitted set's causes and of residual terms, along the paths of its trials."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import Float
from ..fitting import FreeParameter, rms_forces_of_parameter_changes
from ..integrate import System
from .candidates import CandidateCause, strength_difference_step
from .cause_set_fit import FittedCauseSet, start_values
from .problem import CauseSearchProblem


def rms_force_by_cause(problem: CauseSearchProblem, model: FittedCauseSet) -> dict[str, Float]:
    """Root mean square force (channels,) of each cause of a set, by name, and of a unit strength
    of each residual term that may stem from their formulas (`CauseSearchProblem.covers`), by label.
    """
    system, causes = problem.kernel.system, [problem.candidate_by_name[c] for c in model.causes]
    terms = [
        f
        for term in problem.candidates
        if term.name not in model.causes
        and any(problem.cause_covers_residual_term(c, term) for c in causes)
        for f in term.strengths
    ]
    if not terms:
        return {}
    base = start_values(problem, model.causes, model.fit.values_by_label(), model.discrepancy)
    points = replace(problem, base=base).trial_parameter_vectors(model.fit.free, model.fit.values)
    steps = [strength_difference_step(system, f) for f in terms]
    changes = [[_values_without_cause(system, v, c) for v in points] for c in causes]
    changes += [[_values_with_strength_step(system, v, f, h) for v in points]
                for f, h in zip(terms, steps, strict=True)]  # fmt: skip
    found = rms_forces_of_parameter_changes(
        problem.kernel, model.passes, points, changes, model.noise
    )
    own = dict(zip((c.name for c in causes), found, strict=False))
    units = found[len(causes) :] / np.array(steps)[:, None]
    return own | dict(zip((f.label for f in terms), units, strict=True))


def _values_without_cause(system: System, values: Float, cause: CandidateCause) -> Float:
    out = values.copy()
    for f in cause.strengths:
        out[system.parameter_index[f.name]] = 0.0
    return out


def _values_with_strength_step(
    system: System, values: Float, free: FreeParameter, step: float
) -> Float:
    out = values.copy()
    out[system.parameter_index[free.name]] += step
    return out
