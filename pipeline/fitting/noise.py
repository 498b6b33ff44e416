"""How strong the random part is, by maximum likelihood at given coefficients."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Float
from ..integrate import Kernel
from .filtering import filter_all
from .series import Noise, Series


def fit_noise(
    kernel: Kernel,
    series: Sequence[Series],
    values: Sequence[Float],
    noise: Noise,
    *,
    rounds: int = 2,
    most: int = 12,
) -> Noise:
    """Disturbance and measuring noise that make the prediction errors most likely.

    One strength after the other, each by a parabola through three likelihoods over its logarithm,
    bounded to a factor of 4 a round; `values` are full parameter vectors, one a trial. Trials are
    thinned to at most `most`, spread evenly, since few numbers are sought.
    """
    chosen = np.unique(np.linspace(0, len(series) - 1, min(most, len(series))).round().astype(int))
    some = [series[i] for i in chosen]
    points = [values[i] for i in chosen]

    def likelihood(logs: Float) -> float:
        found = filter_all(kernel, some, points, _from_logs(logs, noise))
        return float(sum(f.log_likelihood for f in found))

    logs, width = _to_logs(noise), 0.7
    best = likelihood(logs)
    for _ in range(rounds):
        for i in range(len(logs)):
            logs, best = _along(likelihood, logs, best, i, width)
        width *= 0.6
    return _from_logs(logs, noise)


def _along(likelihood, logs: Float, best: float, i: int, width: float) -> tuple[Float, float]:  # type: ignore[no-untyped-def]
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


def _to_logs(noise: Noise) -> Float:
    return np.log(np.concatenate([np.maximum(noise.disturbance, 1e-9), noise.scale[:3]]))


def _from_logs(logs: Float, noise: Noise) -> Noise:
    count = len(noise.disturbance)
    scale = noise.scale.copy()
    scale[: len(logs) - count] = np.exp(logs[count:])
    return Noise(np.exp(logs[:count]), noise.tau, scale)
