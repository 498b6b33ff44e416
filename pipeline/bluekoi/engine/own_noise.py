"""Fits of a set of causes under its own noise, estimated in turn with its numbers."""

from __future__ import annotations

from dataclasses import replace

from ..data import Float
from ..fitting import FilterResults, Noise, filter_all, fit_noise
from ..fitting.filtering import disturbance_slots
from .problem import MAX_SEARCH_TRIALS, Problem
from .refit import FittedSet, fit_again, start_values, total_log_likelihood

SMALL_FORCE_SHARE, SMALL_FORCE_CORRELATION_TIME_S = 0.05, 0.5
"""Second start of the noise estimate, whose likelihood has several maxima, at this share of the
random forces of the first: gains up to 14 in log (`python -m validation noise-starts`, 4 sets)."""
MAX_NOISE_ROUNDS, NOISE_STEPS, MIN_ROUND_GAIN_LOG_LIK = 6, 6, 0.3
"""Limits of the computing time: rounds in which noise and numbers are fitted in turn, quasi-Newton
steps of each, and the log likelihood below which another round is not worth its time."""


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
        if total_log_likelihood(passes) > total_log_likelihood(model.passes):
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


def without_discrepancy(problem: Problem, model: FittedSet) -> FittedSet:
    """A set fitted to a problem's trials with the formulas of its causes alone, under its own
    noise.
    """
    plain = fit_again(problem, model, model.noise, discrepancy={}, deviations={})
    return fit_own_noise(problem, plain, most=2)


def is_likelier_under(problem: Problem, model: FittedSet, noise: Noise) -> bool:
    """Whether the trials are likelier at a set's numbers under another noise than under its own."""
    passes = filter_all(problem.kernel, problem.series, _evaluation_points(problem, model), noise)
    return total_log_likelihood(passes) > model.log_likelihood


def _fit_under_small_forces(problem: Problem, model: FittedSet) -> FittedSet:
    """A set fitted under small random forces."""
    return fit_again(problem, model, small_force_noise(problem, model.noise))


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
    again = fit_again(problem, model, found.noise, at_start=known)
    return max(model, again, key=lambda m: m.log_joint)


def _evaluation_points(problem: Problem, model: FittedSet) -> list[Float]:
    base = start_values(problem, model.causes, model.fit.by_label(), model.discrepancy)
    return replace(problem, base=base).points(model.fit.free, model.fit.values)


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
