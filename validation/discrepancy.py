"""How much of a law a model with other functional forms leaves (`PRIOR_RELATIVE_DISCREPANCY_STDS`).

Each functional form of a cause is left out in turn. What the coefficients, the cause's strength and
its remaining forms cannot represent of it, M v, is compared with residual terms of the state in the
cause's channels, scaled to the force of the cause (columns D): if their strengths were independent
with standard deviation kappa, the expected square of M D xi would be kappa^2 tr(D' M D). So

    kappa^2 = v' M v / tr(D' M D)

in the metric of the trials' Fisher information. Verdicts play no part in it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from bluekoi.campaign import load_campaign
from bluekoi.data import Float
from bluekoi.engine.candidates import CandidateCause, strength_difference_step
from bluekoi.engine.cause_set_fit import fit_cause_set
from bluekoi.engine.expansion import LikelihoodExpansion, expand_likelihood_in_all_forms
from bluekoi.engine.problem import CauseSearchProblem
from bluekoi.fitting import rms_forces_of_parameter_changes
from bluekoi.mismatch.robot_problem import robot_cause_search_problem
from bluekoi.stages.tuning import campaign_flapping, campaign_series
from bluekoi.study import load_study
from bluekoi.tuning import (
    compiled_trial_system,
    downsampled,
    downsampled_with_head_angle_changes,
    fit_all_trials,
)

RIDGE = 1e-9
QUARTER_MIDPOINTS = (0.125, 0.375, 0.625, 0.875)
"""Probabilities of the middles of four equally probable parts of a distribution."""


def relative_residuals(study: Path, results: Path) -> dict[str, list[float]]:
    """Cause -> kappa^2 of each of its forms, in the designs of a measured study's trials."""
    campaign = load_campaign(results, load_study(study), measured=True)
    series = campaign_series(campaign, campaign_flapping(campaign))
    kernel, baseline = compiled_trial_system(series), fit_all_trials(downsampled(series))
    fitted = downsampled_with_head_angle_changes(series)
    problem = robot_cause_search_problem(
        kernel, fitted, baseline, displaced=(), progress=lambda _: None
    )
    model = fit_cause_set(problem, (), problem.noise, baseline.fit.values_by_label())
    expansion, _ = expand_likelihood_in_all_forms(
        problem, model
    )  # strengths in their leading forms
    found: dict[str, list[float]] = defaultdict(list)
    for cause, value in _relative_residuals_by_form(problem, expansion):
        found[cause].append(value)
    return dict(found)


def _relative_residuals_by_form(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion
) -> Iterator[tuple[str, float]]:
    H = expansion.hessian.sum(axis=0)
    for candidate in problem.candidates:
        forms = expansion.forms[candidate.name]
        covered = [
            t for t in problem.candidates if problem.cause_covers_residual_term(candidate, t)
        ]
        terms = [c for t in covered for c in expansion.strengths[t.name]]
        strengths = list(expansion.strengths[candidate.name])
        if not (forms and terms):
            continue
        scale = _force_ratios(problem, expansion, candidate, covered) ** 2
        for form in forms if scale.any() else ():
            known = [*expansion.own, *strengths, *(f for f in forms if f != form)]
            left = residual_sum_of_squares(H, known, [form, *terms])
            yield candidate.name, float(left[0] / (left[1:] * scale).sum())


def _force_ratios(
    problem: CauseSearchProblem,
    expansion: LikelihoodExpansion,
    cause: CandidateCause,
    terms: Sequence[CandidateCause],
) -> Float:
    """Force of a unit strength of a cause over that of each term's, in the term's channel; 0 for
    all terms of a cause without force.
    """
    model, system = expansion.model, problem.kernel.system
    points = problem.trial_parameter_vectors(model.fit.free, model.fit.values)
    frees = [cause.strengths[0], *(f for t in terms for f in t.strengths)]
    steps = [strength_difference_step(system, f) for f in frees]
    changes = []
    for free, step in zip(frees, steps, strict=True):
        moved = [v.copy() for v in points]
        for v in moved:
            v[system.parameter_index[free.name]] += step
        changes.append(moved)
    found = rms_forces_of_parameter_changes(
        problem.kernel, model.passes, points, changes, model.noise
    )
    own, *units = found / np.array(steps)[:, None]
    return np.array([own[k] / unit[k] for unit in units for k in [int(np.argmax(unit))]])


def residual_sum_of_squares(H: Float, known: Sequence[int], columns: Sequence[int]) -> Float:
    """Squares (columns,) of what known columns cannot represent of others; H: all products."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(H), 1e-30))
    R = H * np.outer(scale, scale)
    inside = R[np.ix_(known, known)] + RIDGE * np.eye(len(known))
    cross = R[np.ix_(known, columns)]
    left = 1.0 - np.einsum("kc,kc->c", cross, np.linalg.solve(inside, cross))
    return np.maximum(left, 0.0) / scale[list(columns)] ** 2


def weighted_quantiles(values: dict[str, list[float]], probabilities: Sequence[float]) -> Float:
    """Quantiles (n,) of the kappa of all forms, each cause with the same weight."""
    rows = [(np.sqrt(v), 1.0 / len(own)) for own in values.values() for v in own]
    kappa, weight = np.array(sorted(rows)).T
    below = np.cumsum(weight) / weight.sum()
    return np.asarray(kappa[np.minimum(np.searchsorted(below, probabilities), len(kappa) - 1)])


def discrepancy_report(values: dict[str, list[float]]) -> str:
    """Kappa of each cause, and of all causes with equal weight."""
    rows = {c: float(np.sqrt(np.mean(v))) for c, v in values.items()}
    lines = [f"{c:28s} {k:.3f}  ({len(values[c])} forms)" for c, k in sorted(rows.items())]
    whole = np.sqrt(np.mean([k**2 for k in rows.values()]))
    quantiles = weighted_quantiles(values, QUARTER_MIDPOINTS)
    return "\n".join([*lines, f"root mean square of {len(rows)} causes: {whole:.3f}",
                      f"median: {np.median(list(rows.values())):.3f}",
                      "quantiles 1/8, 3/8, 5/8, 7/8 of kappa, each cause with equal weight: "
                      + ", ".join(f"{q:.3f}" for q in quantiles)])  # fmt: skip
