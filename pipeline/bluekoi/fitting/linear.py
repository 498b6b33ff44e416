"""Likelihood of the random part around a filter's own path, many times cheaper than a new pass.

Along the path of one filter pass the model is replaced by its derivatives there,

    x_k - x*_k = F (x_k-1 - x*_k-1) + w,    y_k - h(x*_k) = H (x_k - x*_k) + v,

so that another noise needs no integration: what remains is Kalman's recursion with known matrices.
At the noise of that pass both agree exactly. A random state that forgets within tau acts over a
frame dt by the mean of what is left of it, tau (1 - exp(-dt / tau)) / dt; its column of F goes
with that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import active_effects, map_ranges_in_threads, simulate_batch
from .filtering import (
    STATE_FINITE_DIFFERENCE_STEP,
    FilteredTrial,
    FilterResults,
    filter_all,
    parameters_with_random_effects_on,
    random_state_indices,
    random_state_std_factors,
    state_indices_of_active_effects,
)
from .recursion import fill_log_likelihoods
from .score import log_likelihood_gradients
from .series import Noise, TrialSeries, padded_arrays


@dataclass(frozen=True)
class LinearisedFilter:
    """Trials t (each `counts` of n frames), active states a, the random ones last, observations
    o, along one filter pass.

    times (t, n); F (t, n, a, a), to a frame from the one before; H (t, n, o, a), 0 where missing;
    correction (t, n, a): filtered less predicted state; level (t, n, a): filtered random states, 0
    for others; residual (t, n, o): seen less predicted,
    NaN where missing; noise (t, n, o, o): stated; cov (t, a, a): before the first frame. random:
    places of the random states among the active ones; places: theirs in a `Noise`; sizes (t,
    places): their standard deviations over those of a `Noise`; tau (a,): what F was made with, 0
    for other states.
    """

    counts: np.ndarray
    times: Float
    F: Float
    H: Float
    correction: Float
    level: Float
    residual: Float
    noise: Float
    cov: Float
    random: np.ndarray
    places: np.ndarray
    sizes: Float
    tau: Float


@np.errstate(over="ignore", invalid="ignore")  # a model that diverges has no likelihood
def linearised_filter(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise,
    passes: FilterResults | None = None,
) -> LinearisedFilter:  # fmt: skip
    """`LinearisedFilter` along the filter's pass with this noise, made here unless given."""
    passed = filter_all(kernel, series, values, noise) if passes is None else passes
    on = active_effects(
        kernel.system,
        np.array([parameters_with_random_effects_on(kernel, v, noise) for v in values]),
    )
    used = state_indices_of_active_effects(kernel.system, on)
    slots = np.array(random_state_indices(kernel)[: len(noise.disturbance)], dtype=np.int64)
    places = np.flatnonzero(np.isin(slots, used))
    active = np.concatenate([used[~np.isin(used, slots)], slots[places]])
    random = np.arange(len(active) - len(places), len(active))
    tau = np.zeros(len(active))
    tau[random] = noise.tau[places]
    observed, gradients = _observations_and_slopes(
        kernel, series, values, noise, passed=passed, active=active
    )
    block = np.ix_(active, active)
    return LinearisedFilter(
        np.array([len(s.times) for s in series]),
        padded_arrays([s.times for s in series]),
        padded_arrays([p.transitions[:, block[0], block[1]] for p in passed]),
        gradients,
        padded_arrays([(p.filtered - p.predicted)[:, active] for p in passed]),
        np.where(tau > 0, padded_arrays([p.filtered[:, active] for p in passed]), 0.0),
        padded_arrays([s.seen for s in series]) - observed,
        padded_arrays([s.noise for s in series]),
        np.array([s.cov[block] for s in series]),
        random,
        places,
        random_state_std_factors(kernel, series)[:, places],
        tau,
    )


@dataclass(frozen=True)
class NoiseGradient:
    """Log likelihood of all trials, and its slopes by the numbers of a `Noise`."""

    log_likelihood: float
    disturbance: Float
    tau: Float
    scale: Float


def log_likelihood(linear: LinearisedFilter, noise: Noise) -> float:
    """Of all trials under another noise, to first order around the path of `linear`."""
    out = np.zeros(len(linear.counts))
    given = (*_recursion_arguments(linear), *_noise_arrays(linear, noise))
    map_ranges_in_threads(
        lambda first, last: fill_log_likelihoods(*given, first, last, out), len(out)
    )
    return float(out.sum())


def log_likelihood_gradient(linear: LinearisedFilter, noise: Noise) -> NoiseGradient:
    """`log_likelihood` with its slopes by one recursion back (`score`)."""
    trials, states, size = len(linear.counts), len(linear.tau), len(noise.scale)
    out, by_scales = np.zeros(trials), np.zeros((trials, size, size))
    by_variance, by_memory = np.zeros((2, trials, states))
    given = (*_recursion_arguments(linear), *_noise_arrays(linear, noise))
    slopes = (by_variance, by_memory, by_scales)
    map_ranges_in_threads(
        lambda first, last: log_likelihood_gradients(*given, first, last, out, *slopes), trials
    )
    disturbance, tau = np.zeros((2, len(noise.disturbance)))
    by_strength = np.sum(by_variance[:, linear.random] * linear.sizes**2, axis=0)
    disturbance[linear.places] = 2.0 * noise.disturbance[linear.places] * by_strength
    tau[linear.places] = by_memory.sum(axis=0)[linear.random]
    scale = 2.0 * by_scales.sum(axis=0) @ noise.scale
    return NoiseGradient(float(out.sum()), disturbance, tau, scale)


def _recursion_arguments(linear: LinearisedFilter) -> tuple[np.ndarray, ...]:
    return (linear.counts, linear.times, linear.F, linear.H, linear.correction, linear.level,
            linear.residual, linear.noise, linear.cov, linear.tau)  # fmt: skip


def _noise_arrays(linear: LinearisedFilter, noise: Noise) -> tuple[Float, Float, Float]:
    """Variance (t, a) and memory (a,) of the active states, factors on the stated noise (o, o)."""
    variance, memory = np.zeros((len(linear.counts), len(linear.tau))), np.zeros(len(linear.tau))
    variance[:, linear.random] = (linear.sizes * noise.disturbance[linear.places]) ** 2
    memory[linear.random] = noise.tau[linear.places]
    return variance, memory, np.outer(noise.scale, noise.scale)


def _observations_and_slopes(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise, *,
    passed: Sequence[FilteredTrial], active: np.ndarray,
) -> tuple[Float, Float]:  # fmt: skip
    """What each predicted state shows (t, n, o), and its slopes H (t, n, o, a)."""
    predicted = padded_arrays([p.predicted for p in passed])
    trials, frames, states = predicted.shape
    each = np.repeat(np.arange(trials), frames)
    full = np.array([parameters_with_random_effects_on(kernel, v, noise) for v in values])[each]
    constants = np.array([s.constants for s in series])[each]
    times, inputs = (padded_arrays([getattr(s, k) for s in series]) for k in ("times", "inputs"))
    lanes = [np.repeat(a[:, :, None], LANES, axis=2) for a in (full, constants)]
    gradients = []
    for first in range(0, len(active), LANES - 1):  # lane 0 is the state as it is
        moved = active[first : first + LANES - 1]
        state = np.repeat(predicted.reshape(-1, states, 1), LANES, axis=2)
        state[:, moved, np.arange(1, len(moved) + 1)] += STATE_FINITE_DIFFERENCE_STEP
        seen, _ = simulate_batch(kernel, state, *lanes, times=times.reshape(-1, 1),
                                 inputs=inputs.reshape(len(each), 1, inputs.shape[2]))  # fmt: skip
        flat = seen[:, 0]
        gradients.append(
            (flat[:, :, 1 : len(moved) + 1] - flat[:, :, :1]) / STATE_FINITE_DIFFERENCE_STEP
        )
    known = np.isfinite(padded_arrays([s.seen for s in series]))
    slopes = np.concatenate(gradients, axis=2).reshape(*known.shape, len(active))
    return flat[:, :, 0].reshape(known.shape), np.where(known[..., None], slopes, 0.0)
