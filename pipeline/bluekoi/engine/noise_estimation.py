"""Fits of a set of causes under its own noise, estimated in turn with its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..data import Float
from ..fitting import Noise, estimate_noise_model, filter_all
from ..fitting.filtering import random_state_indices
from ..fitting.trial_effects import parameter_vectors_with_trial_effects
from ..integrate.batch import threaded_map
from .cause_set_fit import (
    FittedCauseSet,
    fit_cause_set,
    refit_from_fitted_values,
    start_values,
    total_log_likelihood,
)
from .problem import MAX_SEARCH_TRIALS, CauseSearchProblem

SMALL_FORCE_SHARE, SMALL_FORCE_CORRELATION_TIME_S = 0.05, 0.5
"""Random forces under which further causes are proposed and first fitted, as a share of a set's,
and their correlation time: what a law explains must not stay random."""
MAX_NOISE_ROUNDS, NOISE_STEPS = 6, 20
"""Limits of the computing time: rounds in which noise and numbers are fitted in turn, and
quasi-Newton steps of each. `python -m validation noise-starts` measures what twice of both gains.
"""
MIN_LOG_LIKELIHOOD_GAIN_PER_ROUND = 0.3
"""A round that gains less is the last one. The derivative of a probability p by its log odds is
p (1 - p), 1/4 at most: 0.3 in the log odds changes a stated probability by less than 0.075."""


def fit_noise_and_parameters(
    problem: CauseSearchProblem,
    model: FittedCauseSet,
    *,
    most: int = MAX_NOISE_ROUNDS,
    steps: int = NOISE_STEPS,
) -> FittedCauseSet:
    """A set under its own noise, estimated in turn with its numbers until neither improves.

    Each estimate begins at the noise of the round before: parameters varied one by one first may
    jump to a poorer maximum (`python -m validation noise-starts`; decision 045).
    """
    best = model
    for _ in range(0 if model.noise_is_final else most):
        again = _update_noise_and_fit(problem, best, steps)
        if again is best:
            return replace(best, noise_is_final=True)
        if again.log_joint - best.log_joint < MIN_LOG_LIKELIHOOD_GAIN_PER_ROUND:
            return again
        best = again
    return best


def fit_without_causes(
    problem: CauseSearchProblem, start: Mapping[str, float], *, most: int = MAX_NOISE_ROUNDS
) -> FittedCauseSet:
    """The model without causes under its own noise, begun at the noise of the problem and at small
    random forces: the likelier fit.

    Random forces in the place of what is missing are a maximum of the likelihood, though not always
    the highest, and the filter may diverge under large ones. most: as in
    `fit_noise_and_parameters`.
    """
    starts = (problem.noise, noise_with_small_random_forces(problem, problem.noise))
    found = threaded_map(
        lambda noise: fit_noise_and_parameters(
            problem, fit_cause_set(problem, (), noise, start), most=most
        ),
        starts,
    )
    return max(found, key=lambda model: model.log_joint)


def refit_without_discrepancy(problem: CauseSearchProblem, model: FittedCauseSet) -> FittedCauseSet:
    """A set fitted to a problem's trials with the formulas of its causes alone, under its own
    noise.
    """
    plain = refit_from_fitted_values(problem, model, model.noise, discrepancy={}, deviations={})
    return fit_noise_and_parameters(problem, plain, most=2)


def log_likelihood_gain_under_noise(
    problem: CauseSearchProblem, model: FittedCauseSet, noise: Noise
) -> float:
    """How much likelier the trials are at a set's numbers under another noise than under its own;
    -inf where the model diverges under the other one.
    """
    points = _trial_parameter_vectors_at_fit(problem, model)
    own, other = (total_log_likelihood(filter_all(problem.kernel, problem.series, points, n))
                  for n in (model.noise, noise))  # fmt: skip
    return other - own if np.isfinite(other) else -np.inf


def _update_noise_and_fit(
    problem: CauseSearchProblem, model: FittedCauseSet, steps: int
) -> FittedCauseSet:
    """Noise estimated at a set's numbers, and the numbers fitted under it; the set as it was where
    that is not likelier.
    """
    if not model.is_finite:
        return model
    points = _trial_parameter_vectors_at_fit(problem, model)
    effects = model.fitted_trial_effects(problem)
    at_fit = effects is not None and effects.size == 0  # the points are those of the fit
    found = estimate_noise_model(problem.kernel, problem.series, points, model.noise, rounds=steps,
                                 line_searches=False, max_trials=MAX_SEARCH_TRIALS,
                                 passes=model.passes if at_fit else None)  # fmt: skip
    whole = at_fit and len(found.passes) == len(problem.series)
    again = refit_from_fitted_values(problem, model, found.noise,
                                     predictor=found.passes if whole else None)  # fmt: skip
    return max(model, again, key=lambda m: m.log_joint)


def _trial_parameter_vectors_at_fit(
    problem: CauseSearchProblem, model: FittedCauseSet
) -> list[Float]:
    """Full parameter vectors of the trials at a set's numbers, with the most probable trial
    effects: an error that is constant in a trial is not to be counted as a random force as well.
    """
    base = start_values(problem, model.causes, model.fit.values_by_label(), model.discrepancy)
    points = replace(problem, base=base).trial_parameter_vectors(model.fit.free, model.fit.values)
    effects = model.fitted_trial_effects(problem)
    if effects is None:
        return points
    return parameter_vectors_with_trial_effects(problem.kernel, points, effects, model.noise)


def noise_with_small_random_forces(
    problem: CauseSearchProblem, noise: Noise, *, share: float = SMALL_FORCE_SHARE,
    time_s: float = SMALL_FORCE_CORRELATION_TIME_S,
) -> Noise:  # fmt: skip
    """The noise with random forces of a share of the problem's, and their correlation time."""
    acting = set(random_state_indices(problem.kernel, acting=True))
    count = len(noise.disturbance)
    disturbance, tau = noise.disturbance.copy(), noise.tau.copy()
    for k, slot in enumerate(random_state_indices(problem.kernel)[:count]):
        if slot in acting:
            disturbance[k] = share * problem.noise.disturbance[k]
            tau[k] = time_s * problem.kernel.system.time_unit_s
    return replace(noise, disturbance=disturbance, tau=tau)
