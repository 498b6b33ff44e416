"""Refits of a model with candidate effects, and what is foretold of them.

Knows no fish: a model, candidate effects, trials. A candidate is fitted together with all the
coefficients of the model, since these have absorbed part of what it would explain.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import (
    Fit,
    Free,
    Noise,
    Normal,
    Passes,
    Series,
    filter_all,
    fit,
    log_likelihoods,
    moving,
    normal_equations,
    pseudo_inverse,
    side_log_likelihoods,
    trial_values,
)
from ..integrate import Kernel, Parameter
from .judge import Trialled, candidate_frees, held_out_worth, parameters_of, part_of, trialled

PASSES = 2
"""How often the filter's gains follow a candidate's fit: first those of the model before it."""
TOLERANCE = 0.15
"""A refit ends with a step of this many standard deviations in the mean square."""
MOVED = 0.2
"""Numbers that move less than this, in standard deviations, leave the filter's gains as they are.
"""


def with_starts(kernel: Kernel, base: Float, effects: Sequence[str], share: float = 1.0) -> Float:
    """`base` with the named effects at `share` of their starting strength, shapes at start."""
    out, system = base.copy(), kernel.system
    for name in effects:
        frees, strengths = candidate_frees(system, name)
        for i, free in enumerate(frees):
            slot = system.slot[free.name]
            out[slot] = system.parameters[slot].start * (share if i < strengths else 1.0)
    return out


def try_effects(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    coefficients: Sequence[Free],
    effects: Sequence[str],
    *,
    noise: Noise,
    predictor: Passes | None = None,
    start: Mapping[str, float] | None = None,
    iterations: int = 12,
    passes: int = PASSES,
) -> Trialled:
    """The model with these effects, all its numbers fitted, and its held-out worth.

    Shapes that are known beforehand (`Parameter.spread`) are held there unless `start` names them.
    """
    every = [*coefficients, *(f for e in effects for f in candidate_frees(kernel.system, e)[0])]
    point = with_starts(kernel, base, effects, 0.3)
    known = dict(start or {})
    frees = _not_held(kernel, _told_of(kernel, series, every), known)
    for _ in range(passes):
        found = fit(kernel, series, point, frees, noise, start=known, iterations=iterations,
                    tolerance=TOLERANCE, predictor=predictor)  # fmt: skip
        points = [trial_values(kernel, point, frees, found.values, s.group) for s in series]
        predictor, moved = filter_all(kernel, series, points, noise), _moved(found, known)
        known = found.by_label()
        if not moved:
            break
    normal = normal_equations(kernel, series, point, frees, found.values, noise=noise,
                              predictor=predictor)  # fmt: skip
    found = replace(found, normal=normal)
    if predictor is None or not normal.usable:
        return trialled(kernel, effects, found, noise, series)
    worth = held_out_worth(kernel, series, point, found, noise=noise,
                           predictor=predictor)  # fmt: skip
    side = float(side_log_likelihoods(kernel, series, points).sum())
    return replace(trialled(kernel, effects, found, noise, series, worth=worth), side=side)


def _moved(found: Fit, known: Mapping[str, float]) -> bool:
    """Whether a fit has left its start by more than `MOVED` on average over its numbers."""
    change = found.values - np.array([known.get(f.label, np.inf) for f in found.free])
    if not np.isfinite(change).all():
        return True
    return bool(change @ found.normal.hessian.sum(axis=0) @ change > MOVED**2 * len(change))


def held_shapes(kernel: Kernel, model: Trialled) -> dict[str, float]:
    """Label -> value of the shapes of a model's effects that are held where they are plausible."""
    free = {f.label for f in model.fit.free}
    every = [f for e in model.effects for f in candidate_frees(kernel.system, e)[0]]
    return {f.label: p.start for f, p in zip(every, parameters_of(kernel, every), strict=True)
            if f.label not in free and np.isfinite(p.spread)}  # fmt: skip


def _told_of(kernel: Kernel, series: Sequence[Series], frees: Sequence[Free]) -> list[Free]:
    """The numbers without those that only side measurements tell of which no trial has."""
    have = {name for s in series for name in s.evidence}
    untold = {f"{e.name}.{p}" for e in kernel.system.effects for p, by in e.aside.items()
              if not by & have}  # fmt: skip
    return [f for f in frees if f.name not in untold]


def _not_held(kernel: Kernel, frees: Sequence[Free], known: Mapping[str, float]) -> list[Free]:
    parameters = parameters_of(kernel, frees)
    return [f for f, p in zip(frees, parameters, strict=True)
            if f.label in known or not np.isfinite(p.spread)]  # fmt: skip


@dataclass(frozen=True)
class Foretold:
    """What a refit with a candidate would bring: log likelihood, and where it would begin."""

    gain: float
    start: Mapping[str, float]


def screened(
    kernel: Kernel,
    series: Sequence[Series],
    current: Trialled,
    base: Float,
    candidates: Sequence[str],
    *,
    predictor: Passes | None = None,
) -> dict[str, Foretold]:
    """Candidate -> what is expected of it, from one set of normal equations for all.

    At the current fit each candidate's strengths are differenced at zero beside the numbers
    already free; a step of Newton's in these alone foretells the refit. Numbers that stand at a
    bound stay there, and a strength that would leave its bounds foretells nothing. The gain is that
    on the fitted trials: far from the end of a refit, a fold left out is foretold badly.
    """
    shifted = list(current.fit.free)
    both = {c: candidate_frees(kernel.system, c) for c in candidates}
    strengths = {c: frees[:count] for c, (frees, count) in both.items()}
    frees = [*shifted, *(f for c in candidates for f in strengths[c])]
    values = np.concatenate([current.fit.values, np.zeros(len(frees) - len(shifted))])
    normal = normal_equations(kernel, series, base, frees, values, noise=current.noise,
                              predictor=predictor)  # fmt: skip
    own = np.flatnonzero(moving(kernel, current.fit)).tolist()
    if not part_of(normal, own).usable:
        return {c: Foretold(-np.inf, {}) for c in candidates}
    reference = _step_gain(part_of(normal, own))[1]
    told, at = {}, len(shifted)
    for c in candidates:
        columns = [*own, *range(at, at + len(strengths[c]))]
        at += len(strengths[c])
        told[c] = _foretold(kernel, part_of(normal, columns), [frees[k] for k in columns],
                            values[columns], reference)  # fmt: skip
    return told


def other_shapes(kernel: Kernel, name: str) -> list[dict[str, float]]:
    """Shapes at which a candidate is tried beside its start: parameter -> value, by turns.

    One of which nothing is known beforehand has values of its own, or two between the start and
    its bounds, halfway on a logarithmic scale; one that is held has those of another form, and by
    turns its start, where it stays held.
    """
    frees, strengths = candidate_frees(kernel.system, name)
    tried = {p: values for p in parameters_of(kernel, frees[strengths:])
             if (values := p.tries or _between(p))}  # fmt: skip
    most = max((len(values) for values in tried.values()), default=0)
    return [{p.name: values[k] for p, values in tried.items()
             if k < len(values) and values[k] != p.start} for k in range(most)]  # fmt: skip


def _between(parameter: Parameter) -> tuple[float, ...]:
    if np.isfinite(parameter.spread):
        return ()
    bounds = (max(bound, 0.1 * parameter.start) for bound in (parameter.lower, parameter.upper))
    return tuple(float(np.sqrt(parameter.start * bound)) for bound in bounds)


def unlikelihood(kernel: Kernel, shape: Mapping[str, float]) -> float:
    """By how much log likelihood shapes are less plausible beforehand than those at the start."""
    slots, parameters = kernel.system.slot, kernel.system.parameters
    off = [(v - parameters[slots[n]].start) / parameters[slots[n]].spread for n, v in shape.items()]
    return 0.5 * float(np.dot(off, off))


def _step_gain(normal: Normal) -> tuple[Float, float]:
    """Newton's step and the gain in log likelihood that it foretells, g' H^-1 g / 2."""
    g = normal.gradient.sum(axis=0)
    step = pseudo_inverse(normal.hessian.sum(axis=0)) @ g
    return step, 0.5 * float(g @ step)


def _foretold(
    kernel: Kernel, normal: Normal, frees: Sequence[Free], values: Float, reference: float
) -> Foretold:
    if not normal.usable:
        return Foretold(-np.inf, {})
    step, gain = _step_gain(normal)
    parameters = [kernel.system.parameters[kernel.system.slot[f.name]] for f in frees]
    lower, upper = np.array([(p.lower, p.upper) for p in parameters]).T
    end = values + step
    new = np.array(["." in f.name for f in frees]) & (values == 0.0)
    wrong_way = new & (lower >= 0.0) & ((end < lower) | (step <= 0.0))
    start = {f.label: float(v) for f, v in zip(frees, np.clip(end, lower, upper), strict=True)}
    return Foretold(-np.inf if wrong_way.any() else gain - reference, start)


def starts_of(kernel: Kernel, name: str) -> tuple[float, ...]:
    """Strengths from which fits of a candidate begin; none where one start does for it."""
    return () if "." in name else kernel.system.effect(name).starts


def likeliest_start(
    kernel: Kernel,
    points: Sequence[Float],
    name: str,
    *,
    noise: Noise,
    predictor: Passes,
) -> dict[str, float]:
    """Label -> the start of a candidate at which the trials are likeliest, all else as it is.

    points: full parameter vectors of the model before, one a trial.
    """
    starts = starts_of(kernel, name)
    if not starts:
        return {}
    first = kernel.system.slots(name)[0]

    def likelihood(strength: float) -> float:
        moved = [with_starts(kernel, p, [name]) for p in points]
        for point in moved:
            point[first] = strength
        seen = log_likelihoods(kernel, moved, noise=noise, predictor=predictor)
        return float(np.nan_to_num(seen, nan=-np.inf).sum())

    return {kernel.system.parameters[first].name: max(starts, key=likelihood)}
