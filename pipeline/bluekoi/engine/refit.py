"""Nonlinear fits of a set of causes, with all their functional forms and their own noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..data import Float
from ..fitting import (
    FilterResults,
    Fit,
    Free,
    Noise,
    filter_all,
    fit,
    fit_noise,
    log_likelihoods,
    normal_equations,
)
from ..fitting.filtering import disturbance_slots
from .candidates import Candidate, parameter_of
from .problem import MAX_SEARCH_TRIALS, Problem

STEP_TOLERANCE_STDS = 0.1
"""A fit ends with a step of this many standard deviations in the mean square."""
SMALL_FORCE_SHARE, SMALL_FORCE_CORRELATION_TIME_S = 0.05, 0.5
"""Second start of the noise estimate, whose likelihood has several maxima, at this share of the
random forces of the first: gains up to 14 in log (`python -m validation noise-starts`, 4 sets)."""
MAX_NOISE_ROUNDS, NOISE_STEPS, MIN_ROUND_GAIN_LOG_LIK = 6, 6, 0.3
"""Limits of the computing time: rounds in which noise and numbers are fitted in turn, quasi-Newton
steps of each, and the log likelihood below which another round is not worth its time."""


@dataclass(frozen=True)
class FittedSet:
    """A set of causes, fitted: names, fit, noise, the filter's pass at the fit, which numbers stand
    at a bound (p,).

    discrepancy: residual term -> strength of what the formulas of its causes leave, fitted with its
    numbers. deviations: residual term -> prior standard deviation of that.
    """

    causes: tuple[str, ...]
    fit: Fit
    noise: Noise
    passes: FilterResults
    at_bound: np.ndarray
    discrepancy: Mapping[str, float] = field(default_factory=dict)
    deviations: Mapping[str, float] = field(default_factory=dict)

    @property
    def usable(self) -> bool:
        """Whether the fit is finite."""
        return self.fit.normal.usable

    @property
    def log_likelihood(self) -> float:
        """Of all trials; forms' priors included."""
        return self.fit.log_likelihood if self.usable else -np.inf

    @property
    def log_joint(self) -> float:
        """Log likelihood with the prior of the discrepancy, less its constant."""
        prior = sum((self.discrepancy.get(k, 0.0) / std) ** 2 for k, std in self.deviations.items())
        return self.log_likelihood - 0.5 * prior

    @property
    def key(self) -> frozenset[str]:
        """The set of causes."""
        return frozenset(self.causes)


def free_parameters(problem: Problem, causes: Sequence[str]) -> tuple[Free, ...]:
    """The numbers of a set: coefficients, then each cause's strengths and forms."""
    have = {name for s in problem.series for name in s.evidence}
    out: list[Free] = list(problem.coefficients)
    for cause in causes:
        candidate = problem.by_name[cause]
        effect = problem.kernel.system.effect(cause.partition(".")[0])
        blind = {f"{effect.name}.{p}" for p, by in effect.nuisance.items() if not by & have}
        out += [f for f in candidate.free if f.name not in blind and f not in out]
    return tuple(out)


def start_values(
    problem: Problem,
    causes: Sequence[str],
    known: Mapping[str, float],
    discrepancy: Mapping[str, float] | None = None,
) -> Float:
    """Base point with the forms of the causes at their leading form, or where they are known."""
    out, system = problem.base.copy(), problem.kernel.system
    for label, value in (discrepancy or {}).items():
        out[system.slot[label]] = value
    for cause in causes:
        for free in problem.by_name[cause].free:
            slot = system.slot[free.name]
            out[slot] = known.get(free.label, 0.3 * system.parameters[slot].start
                                  if free in problem.by_name[cause].strengths
                                  else system.parameters[slot].start)  # fmt: skip
    return out


def fit_set(
    problem: Problem,
    causes: Sequence[str],
    noise: Noise,
    known: Mapping[str, float],
    *,
    at_start: FilterResults | None = None,
    passes: int = 4,
    iterations: int = 12,
    free: Sequence[Free] | None = None,
    discrepancy: Mapping[str, float] | None = None,
    deviations: Mapping[str, float] | None = None,
) -> FittedSet:
    """A set fitted under one noise; after the first fit the filter's gains are held, `passes` fits
    in all or until the numbers rest.

    at_start: the filter's pass at the start with this noise, where known. deviations: those of the
    discrepancy, which is fitted with the numbers of the set; without, it is held.
    """
    own = free_parameters(problem, causes) if free is None else tuple(free)
    slot = problem.kernel.system.slot
    left = dict.fromkeys(deviations or {}, 0.0) | dict(discrepancy or {})
    frees = (*own, *map(Free, deviations or {}))
    point = start_values(problem, causes, known, left)
    start = {f.label: left.get(f.label, known.get(f.label, float(point[slot[f.name]])))
             for f in frees}  # fmt: skip

    def filtered(values: Float) -> FilterResults:
        points = replace(problem, base=point).points(frees, values)
        return filter_all(problem.kernel, problem.series, points, noise)

    def fitted(gains: FilterResults | None, begin: Mapping[str, float]) -> Fit:
        return fit(problem.kernel, problem.series, point, frees, noise, start=begin,
                   iterations=iterations, tolerance=STEP_TOLERANCE_STDS, predictor=gains,
                   spreads=deviations)  # fmt: skip

    first, predictor = start, at_start or filtered(np.array([start[f.label] for f in frees]))
    for _ in range(passes):
        found = fitted(predictor, start)
        predictor = filtered(found.values)
        if not (found.normal.usable and np.isfinite(_total_log_likelihood(predictor))):
            found = fitted(None, first)  # held gains do not serve that far from the start
            predictor = filtered(found.values)
        if _squared_distance_to_start(found, start) < 1.0:
            break
        start = found.by_label()
    values = found.values[: len(own)]
    left |= {label: found.by_label()[label] for label in deviations or {}}
    point = start_values(problem, causes, known, left)
    normal = normal_equations(problem.kernel, problem.series, point, own, values, noise=noise,
                              predictor=predictor)  # fmt: skip
    rows = [parameter_of(problem.kernel.system, f) for f in own]
    bound = [not p.lower < v < p.upper for p, v in zip(rows, values, strict=True)]
    return FittedSet(tuple(causes), replace(found, free=own, values=values, normal=normal), noise,
                     predictor, np.array(bound, dtype=bool), left, deviations or {})  # fmt: skip


def strength_starts(problem: Problem, candidate: Candidate) -> tuple[float, ...]:
    """Strengths from which fits of a candidate begin, where one start may mislead; else none."""
    if candidate.is_residual:
        return ()
    return problem.kernel.system.effect(candidate.name).starts


def likeliest_start(problem: Problem, near: FittedSet, cause: str) -> dict[str, float]:
    """Label -> the start of a cause's first strength at which the trials are likeliest, all else as
    fitted; empty where one start serves.
    """
    candidate = problem.by_name[cause]
    starts, label = strength_starts(problem, candidate), candidate.strengths[0].label
    if not starts:
        return {}
    base = start_values(problem, (*near.causes, cause), near.fit.by_label())
    slot = problem.kernel.system.slot[candidate.strengths[0].name]

    def likelihood(start: float) -> float:
        point = base.copy()
        point[slot] = start
        points = replace(problem, base=point).points(near.fit.free, near.fit.values)
        found = log_likelihoods(problem.kernel, points, noise=near.noise, predictor=near.passes)
        return float(np.nan_to_num(found, nan=-np.inf).sum())

    return {label: max(starts, key=likelihood)}


def _squared_distance_to_start(found: Fit, start: Mapping[str, float]) -> float:
    change = found.values - np.array([start.get(f.label, np.inf) for f in found.free])
    if not np.isfinite(change).all() or not found.normal.usable:
        return np.inf
    return float(change @ found.normal.hessian.sum(axis=0) @ change / max(len(change), 1))


def without_discrepancy(problem: Problem, model: FittedSet) -> FittedSet:
    """A set fitted to a problem's trials with the formulas of its causes alone, under its own
    noise.
    """
    plain = fit_set(problem, model.causes, model.noise, model.fit.by_label(),
                   free=model.fit.free)  # fmt: skip
    return fit_own_noise(problem, plain, most=2)


def fit_own_noise(
    problem: Problem, model: FittedSet, *, most: int = MAX_NOISE_ROUNDS, two_starts: bool = True
) -> FittedSet:
    """A set under its own noise, estimated in turn with its numbers until neither improves.

    Two starting points, random forces as estimated before and small ones under which the numbers
    are fitted again: what a law explains must not stay random. With a single round, the likelier
    noise alone; two_starts False: of a set whose second start has been tried, the first alone.
    """
    if most == 1:
        small = small_force_noise(problem, model.noise)
        passes = filter_all(
            problem.kernel, problem.series, _evaluation_points(problem, model), small
        )
        if _total_log_likelihood(passes) > _total_log_likelihood(model.passes):
            return _noise_and_fit_round(problem, model, small, passes, near=False)
        return _noise_and_fit_round(problem, model, model.noise, model.passes, near=True)
    best = model
    begins = (model, _fit_under_small_forces(problem, model)) if two_starts else (model,)
    for begin in begins:
        first = _noise_and_fit_round(problem, begin, begin.noise, begin.passes, near=begin is model)
        best = max(best, first, key=lambda m: m.log_joint)
    for _ in range(most - 1):
        again = _noise_and_fit_round(problem, best, best.noise, best.passes, near=True)
        if again.log_joint - best.log_joint < MIN_ROUND_GAIN_LOG_LIK:
            break
        best = again
    return best


def is_likelier_under(problem: Problem, model: FittedSet, noise: Noise) -> bool:
    """Whether the trials are likelier at a set's numbers under another noise than under its own."""
    passes = filter_all(problem.kernel, problem.series, _evaluation_points(problem, model), noise)
    return _total_log_likelihood(passes) > model.log_likelihood


def _fit_under_small_forces(problem: Problem, model: FittedSet) -> FittedSet:
    """A set fitted under small random forces."""
    noise = small_force_noise(problem, model.noise)
    return fit_set(problem, model.causes, noise, model.fit.by_label(),
                   free=model.fit.free, discrepancy=model.discrepancy,
                   deviations=model.deviations)  # fmt: skip


def _noise_and_fit_round(
    problem: Problem, model: FittedSet, start: Noise, passes: FilterResults, *, near: bool
) -> FittedSet:
    """Noise estimated from a start at a set's numbers, and the numbers fitted under it; the set as
    it was where that is not likelier.

    passes: the filter's with the start. near: whether it is near enough for quasi-Newton steps.
    """
    if not model.usable:
        return model
    points = _evaluation_points(problem, model)
    found = fit_noise(problem.kernel, problem.series, points, start, rounds=NOISE_STEPS,
                      line_searches=not near, max_trials=MAX_SEARCH_TRIALS,
                      passes=passes)  # fmt: skip
    known = found.passes if len(found.passes) == len(points) else None
    again = fit_set(problem, model.causes, found.noise, model.fit.by_label(),
                   free=model.fit.free, discrepancy=model.discrepancy, at_start=known,
                   deviations=model.deviations)  # fmt: skip
    return max(model, again, key=lambda m: m.log_joint)


def _evaluation_points(problem: Problem, model: FittedSet) -> list[Float]:
    base = start_values(problem, model.causes, model.fit.by_label(), model.discrepancy)
    return replace(problem, base=base).points(model.fit.free, model.fit.values)


def _total_log_likelihood(passes: FilterResults) -> float:
    """Log likelihood of all trials; -inf where the model diverges."""
    total = sum(f.log_likelihood for f in passes)
    return total if np.isfinite(total) else -np.inf


def small_force_noise(
    problem: Problem, noise: Noise, *, share: float = SMALL_FORCE_SHARE,
    time_s: float = SMALL_FORCE_CORRELATION_TIME_S,
) -> Noise:  # fmt: skip
    """The noise with random forces of a share of the problem's, and their correlation time."""
    acting = set(disturbance_slots(problem.kernel, acting=True))
    count = len(noise.disturbance)
    disturbance, tau = noise.disturbance.copy(), noise.tau.copy()
    for k, slot in enumerate(disturbance_slots(problem.kernel)[:count]):
        if slot in acting:
            disturbance[k] = share * problem.noise.disturbance[k]
            tau[k] = time_s
    return replace(noise, disturbance=disturbance, tau=tau)


def off_bounds_mask(model: FittedSet) -> np.ndarray:
    """Which fitted numbers are off their bounds, (p,)."""
    return ~model.at_bound
