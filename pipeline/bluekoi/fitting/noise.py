"""How strong the random part is, by maximum likelihood at given coefficients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from ..data import Float
from ..integrate import Kernel, Parameter
from .filtering import disturbance_slots, filter_all, random_effects
from .linear import Linear, Slopes, likelihood_slopes, linearised, log_likelihood
from .series import Noise, Series

LEAST = 1e-9
UNLIKELY = -1e12
REACH = 4.0
"""Strengths and memories are sought within a factor of e^4 of where they are begun."""


def fit_noise(
    kernel: Kernel,
    series: Sequence[Series],
    values: Sequence[Float],
    noise: Noise,
    *,
    rounds: int = 2,
    most: int = 12,
    forces_only: bool = False,
    line_searches: bool = True,
) -> Noise:
    """Random forces, lasting tracking errors and white noise that make the errors most likely.

    One strength after the other, each by a parabola through three likelihoods over its logarithm,
    then up to `rounds` quasi-Newton steps in all of them; `values` are full parameter vectors, one
    a trial. While a memory tau is varied, sigma sqrt(tau) stays: slow data tell that product alone.
    Trials are thinned to at most `most`, spread evenly, since few numbers are sought. forces_only:
    only the random parts that push are sought, the measuring noise stays. line_searches: without,
    the quasi-Newton steps begin at once, for a start that is near.
    """
    chosen = np.unique(np.linspace(0, len(series) - 1, min(most, len(series))).round().astype(int))
    some = [series[i] for i in chosen]
    points = [values[i] for i in chosen]
    sought = _sought(kernel, noise, forces_only)
    if not sought:
        return noise

    def noise_of(logs: Float) -> Noise:
        return _with(kernel, noise, sought, np.exp(logs))

    logs, width = np.log([max(_flat(noise)[k], LEAST) for k in sought]), 0.7
    linear = linearised(kernel, some, points, noise_of(logs))
    before = best = _finite(log_likelihood(linear, noise_of(logs)))
    if line_searches:
        for i in range(len(logs)):
            logs, best = _parabolic_step(
                lambda x: _finite(log_likelihood(linear, noise_of(x))), logs, best, i, width
            )
        linear = linearised(kernel, some, points, noise_of(logs))

    def unlikely(logs: Float) -> tuple[float, Float]:
        return _unlikely(kernel, linear, noise_of(logs), sought)

    found = noise_of(_quasi_newton_steps(unlikely, logs, rounds))
    passed = sum(f.log_likelihood for f in filter_all(kernel, some, points, found))
    return found if _finite(passed) > before else noise


def with_forces_of(kernel: Kernel, noise: Noise, other: Noise) -> Noise:
    """The measuring part of one noise with the random forces of another of the same states."""
    if len(noise.disturbance) != len(other.disturbance):
        raise ValueError("the noises have other random states")
    acting = set(disturbance_slots(kernel, acting=True))
    count = len(noise.disturbance)
    theirs = [k for k, slot in enumerate(disturbance_slots(kernel)[:count]) if slot in acting]
    disturbance, tau = noise.disturbance.copy(), noise.tau.copy()
    disturbance[theirs], tau[theirs] = other.disturbance[theirs], other.tau[theirs]
    return replace(noise, disturbance=disturbance, tau=tau)


def _unlikely(
    kernel: Kernel, linear: Linear, noise: Noise, sought: Sequence[int]
) -> tuple[float, Float]:
    """Log likelihood and its slopes by the logarithms of what is sought, both times -1."""
    told = likelihood_slopes(linear, noise)
    by_logs = _by_logs(kernel, noise, told)[list(sought)]
    if not np.isfinite([told.log_likelihood, *by_logs]).all():
        return -UNLIKELY, np.zeros(len(by_logs))
    return -told.log_likelihood, -by_logs


def _quasi_newton_steps(
    unlikely: Callable[[Float], tuple[float, Float]], logs: Float, rounds: int
) -> Float:
    """Quasi-Newton steps from `logs`: ridges of the likelihood are not parallel to the axes."""
    bounds = [(x - REACH, x + REACH) for x in logs]
    found = minimize(unlikely, logs, jac=True, method="L-BFGS-B", bounds=bounds,
                     options={"maxiter": rounds, "ftol": 1e-7})  # fmt: skip
    return np.asarray(found.x)


def _finite(likelihood: float) -> float:
    """The likelihood, or the least one if the filter diverged."""
    return likelihood if np.isfinite(likelihood) else UNLIKELY


def _by_logs(kernel: Kernel, noise: Noise, told: Slopes) -> Float:
    """Slopes by the logarithms of `_flat`: sigma goes with 1 / sqrt(tau); 0 out of a bound."""
    count, own = len(noise.disturbance), told.disturbance * noise.disturbance
    tau = np.zeros(count)
    for k, (shared, parameter) in _memories(kernel, count).items():
        states = slice(k, k + shared)
        slope = float(np.sum(told.tau[states] * noise.tau[states] - 0.5 * own[states]))
        below, above = noise.tau[k] < parameter.upper, noise.tau[k] > parameter.lower
        tau[k] = slope if (below or slope < 0) and (above or slope > 0) else 0.0
    scale = np.where(noise.scale > noise.least_scale, told.scale * noise.scale, 0.0)
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


def _flat(noise: Noise) -> Float:
    """Random states' sigma sqrt(tau), then their tau, then the scales of the observations."""
    return np.concatenate([noise.disturbance * np.sqrt(noise.tau), noise.tau, noise.scale])


def _sought(kernel: Kernel, noise: Noise, forces_only: bool) -> list[int]:
    """Places in `_flat`: strengths; and, unless `forces_only`, memories and scales."""
    count = len(noise.disturbance)
    slots = disturbance_slots(kernel)[:count]
    acting = set(disturbance_slots(kernel, acting=True))
    used = [k for k in range(count) if noise.disturbance[k] > 0]
    if forces_only:
        return [k for k in used if slots[k] in acting]
    memories = [count + k for k in _memories(kernel, count) if k in used]
    return [*used, *memories, *(2 * count + k for k in range(min(3, len(noise.scale))))]


def _memories(kernel: Kernel, count: int) -> dict[int, tuple[int, Parameter]]:
    """Random states with a memory of their own -> how many states share it, and its parameter."""
    out: dict[int, tuple[int, Parameter]] = {}
    at = 0
    for effect in random_effects(kernel):
        own = effect.parameters[1:]
        shared = len(effect.states) // len(own)
        out |= {at + i * shared: (shared, p) for i, p in enumerate(own)}
        at += len(effect.states)
    return {k: v for k, v in out.items() if k < count}


def _with(kernel: Kernel, noise: Noise, sought: Sequence[int], found: Float) -> Noise:
    flat, count = _flat(noise), len(noise.disturbance)
    flat[list(sought)] = found
    tau = flat[count : 2 * count].copy()
    for k, (shared, parameter) in _memories(kernel, count).items():
        tau[k : k + shared] = np.clip(tau[k], parameter.lower, parameter.upper)
    scale = np.maximum(flat[2 * count :], noise.least_scale)
    return replace(noise, disturbance=flat[:count] / np.sqrt(tau), tau=tau, scale=scale)
