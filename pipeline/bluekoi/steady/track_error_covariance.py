"""Covariance between the errors of a smoothed track at different times.

A smoother's errors at neighbouring times are alike. They are taken as a smooth stationary process
whose length in time is l = std of position / std of velocity of the track:
    C(t, s) = std(t) std(s) exp(-(t - s)^2 / (2 l^2))
To this the scatter of the path about the fitted curve is added, as far as its own correlation
shows that it is more than smoothing error (water that moves, a wavering tail).
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from ..data.keypoint_quality import correlation_time_samples


def error_correlation_time_s(std: Float, rate_std: Float) -> float:
    """Time over which errors stay alike, s, from deviations of a quantity and its derivative."""
    return float(np.median(std) / max(float(np.median(rate_std)), 1e-300))


def smoothed_error_covariance(time_s: Float, std: Float, length_s: float) -> Float:
    """Covariance (n, n) of smoothed errors with deviation std (n,)."""
    apart = (time_s[:, None] - time_s) / max(length_s, 1e-9)
    return np.outer(std, std) * np.exp(-0.5 * apart**2)


def residual_covariance(time_s: Float, residual: Float, parameters: int) -> Float:
    """Covariance (n, n) of the residual: its variance, alike over its own correlation time."""
    n = len(residual)
    centred = residual - residual.mean()
    samples = correlation_time_samples(residual)
    df = max(n / samples - parameters, 1.0) * samples
    length = samples * float(np.median(np.diff(time_s))) / np.sqrt(2 * np.pi)
    deviation = np.full(n, np.sqrt(float(centred @ centred) / df))
    return smoothed_error_covariance(time_s, deviation, length)
