"""How strong the random part is, by maximum likelihood at given coefficients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize

from ..data import Float
from ..integrate import CompiledSystem, Parameter, System
from .filtering import FilterResults, filter_all
from .linear import (
    LinearisedFilter,
    NoiseGradient,
    linearised_filter,
    log_likelihood,
    log_likelihood_gradient,
)
from .series import Noise, TrialSeries

MIN_NOISE_STRENGTH = 1e-9
LOG_LIKELIHOOD_IF_DIVERGED = -1e12
MAX_LOG_CHANGE = 4.0
"""Strengths and correlation times are estimated within a factor of e^4 of their start."""


@dataclass(frozen=True)
class FittedNoise:
    """A noise of maximum likelihood, and the filter's pass with it over the trials used."""

    noise: Noise
    passes: FilterResults


def estimate_noise_model(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise, *,
    rounds: int = 2, max_trials: int = 12, line_searches: bool = True,
    passes: FilterResults | None = None,
) -> FittedNoise:  # fmt: skip
    """Random forces, correlated tracking errors and white noise of maximum likelihood.

    One strength after the other, each by a parabola through three likelihoods over its logarithm,
    then up to `rounds` quasi-Newton steps in all of them; `values` are full parameter vectors, one
    a trial. While a correlation time tau is varied, sigma sqrt(tau) stays: slow data determine that
    product alone. At most `max_trials` trials are used, evenly spread, since few numbers are
    estimated. line_searches: without, the quasi-Newton steps begin at once, for a near start.
    passes: the filter's, over all trials with `noise`, where known.
    """
    chosen = np.unique(
        np.linspace(0, len(series) - 1, min(max_trials, len(series))).round().astype(int)
    )
    some = [series[i] for i in chosen]
    points = [values[i] for i in chosen]
    if passes is None or len(chosen) < len(series):
        passes = filter_all(kernel, some, points, noise)
    estimated = _estimated_noise_indices(kernel, noise)
    if not estimated:
        return FittedNoise(noise, passes)

    def noise_of(logs: Float) -> Noise:
        return _with_estimates(kernel, noise, estimated, np.exp(logs))

    logs, width = np.log([max(_noise_vector(noise)[k], MIN_NOISE_STRENGTH) for k in estimated]), 0.7
    linear = linearised_filter(kernel, some, points, noise_of(logs), passes)
    before = _log_likelihood_or_diverged(sum(f.log_likelihood for f in passes))
    if line_searches:
        best = _log_likelihood_or_diverged(log_likelihood(linear, noise_of(logs)))
        for i in range(len(logs)):
            logs, best = _parabolic_step(
                lambda x: _log_likelihood_or_diverged(log_likelihood(linear, noise_of(x))),
                logs,
                best,
                i,
                width,
            )
        linear = linearised_filter(kernel, some, points, noise_of(logs))

    def objective(logs: Float) -> tuple[float, Float]:
        return _negative_log_likelihood(kernel, linear, noise_of(logs), estimated)

    found = noise_of(_quasi_newton_steps(objective, logs, rounds))
    again = filter_all(kernel, some, points, found)
    if _log_likelihood_or_diverged(sum(f.log_likelihood for f in again)) > before:
        return FittedNoise(found, again)
    return FittedNoise(noise, passes)


def _negative_log_likelihood(
    kernel: CompiledSystem, linear: LinearisedFilter, noise: Noise, estimated: Sequence[int]
) -> tuple[float, Float]:
    """Negative log likelihood and its gradient in the logarithms of the estimated strengths."""
    slopes = log_likelihood_gradient(linear, noise)
    gradient = _log_gradient(kernel, noise, slopes)[list(estimated)]
    if not np.isfinite([slopes.log_likelihood, *gradient]).all():
        return -LOG_LIKELIHOOD_IF_DIVERGED, np.zeros(len(gradient))
    return -slopes.log_likelihood, -gradient


def _quasi_newton_steps(
    objective: Callable[[Float], tuple[float, Float]], logs: Float, rounds: int
) -> Float:
    """Quasi-Newton steps from `logs`: ridges of the likelihood are not parallel to the axes."""
    bounds = [(x - MAX_LOG_CHANGE, x + MAX_LOG_CHANGE) for x in logs]
    found = minimize(objective, logs, jac=True, method="L-BFGS-B", bounds=bounds,
                     options={"maxiter": rounds, "ftol": 1e-7})  # fmt: skip
    return np.asarray(found.x)


def _log_likelihood_or_diverged(likelihood: float) -> float:
    """The likelihood, or `LOG_LIKELIHOOD_IF_DIVERGED`."""
    return likelihood if np.isfinite(likelihood) else LOG_LIKELIHOOD_IF_DIVERGED


def _log_gradient(kernel: CompiledSystem, noise: Noise, slopes: NoiseGradient) -> Float:
    """Slopes by the logs of `_noise_vector`: sigma goes with 1 / sqrt(tau); 0 out of a bound."""
    count, own = len(noise.disturbance), slopes.disturbance * noise.disturbance
    tau = np.zeros(count)
    for k, (shared, parameter) in _correlation_time_parameters(kernel, count).items():
        states = slice(k, k + shared)
        slope = float(np.sum(slopes.tau[states] * noise.tau[states] - 0.5 * own[states]))
        below, above = noise.tau[k] < parameter.upper, noise.tau[k] > parameter.lower
        tau[k] = slope if (below or slope < 0) and (above or slope > 0) else 0.0
    inside = (noise.scale > noise.least_scale) | (slopes.scale > 0)
    scale = np.where(inside, slopes.scale * noise.scale, 0.0)
    return np.concatenate([own, tau, scale])


def _parabolic_step(
    likelihood: Callable[[Float], float], logs: Float, best: float, i: int, width: float
) -> tuple[Float, float]:
    unit = np.eye(len(logs))[i] * width
    low, high = likelihood(logs - unit), likelihood(logs + unit)
    curvature = low + high - 2 * best
    if curvature < 0:
        shift = np.clip(0.5 * (low - high) / curvature, -2.0, 2.0)
    else:
        shift = 2.0 if high > low else -2.0
    candidate = logs + shift * unit
    value = likelihood(candidate)
    options = [(value, candidate), (low, logs - unit), (high, logs + unit), (best, logs)]
    value, chosen = max(options, key=lambda option: option[0])
    return chosen, value


def _noise_vector(noise: Noise) -> Float:
    """Random states' sigma sqrt(tau), then their tau, then the scales of the observations."""
    return np.concatenate([noise.disturbance * np.sqrt(noise.tau), noise.tau, noise.scale])


def _estimated_noise_indices(kernel: CompiledSystem, noise: Noise) -> list[int]:
    """Places in `_noise_vector`: strengths, correlation times and scales."""
    count = len(noise.disturbance)
    used = [k for k in range(count) if noise.disturbance[k] > 0]
    times = [count + k for k in _correlation_time_parameters(kernel, count) if k in used]
    scales = [k for k in range(len(noise.scale)) if k not in noise.fixed_scales]
    return [*used, *times, *(2 * count + k for k in scales)]


def _correlation_time_parameters(
    kernel: CompiledSystem, count: int
) -> dict[int, tuple[int, Parameter]]:
    """Random state with a correlation time -> how many states share it, and its parameter."""
    return {k: v for k, v in _all_correlation_time_parameters(kernel.system).items() if k < count}


@lru_cache(maxsize=64)
def _all_correlation_time_parameters(system: System) -> dict[int, tuple[int, Parameter]]:
    out: dict[int, tuple[int, Parameter]] = {}
    at = 0
    for effect in (e for e in system.effects if e.kind == "disturbance"):
        own = effect.parameters[1:]
        shared = len(effect.states) // len(own)
        out |= {at + i * shared: (shared, p) for i, p in enumerate(own)}
        at += len(effect.states)
    return out


def _with_estimates(
    kernel: CompiledSystem, noise: Noise, estimated: Sequence[int], found: Float
) -> Noise:
    flat, count = _noise_vector(noise), len(noise.disturbance)
    flat[list(estimated)] = found
    tau = flat[count : 2 * count].copy()
    for k, (shared, parameter) in _correlation_time_parameters(kernel, count).items():
        tau[k : k + shared] = np.clip(tau[k], parameter.lower, parameter.upper)
    scale = np.maximum(flat[2 * count :], noise.least_scale)
    return replace(noise, disturbance=flat[:count] / np.sqrt(tau), tau=tau, scale=scale)
