"""How the tail beat slows down during a trial, as the camera sees it.

A supply that sags slows the motor. Where no log shows that, the video does: with the time t from
the middle of the frames used, the phase of a beat whose frequency changes by the share d per second
is

    phi = phi_0 + 2 pi f (t + d t^2 / 2).

Least squares in f and d as in `tail_beat`, of which this is the second-order form. The clock of the
camera cancels: d is a share of the frequency itself.
"""

from __future__ import annotations

import numpy as np

from ..data import Float, Positions
from ..data.keypoint_quality import correlation_time_samples
from .beat_regression import beat_signal, misfit_spectrum, robust_weights, slow_background
from .spin_up import spin_up_end_s

MAX_DRIFT_PER_S = 0.05
"""The frequency changes by less than this share per second: a supply that loses half its voltage in
10 s is not one to swim with."""
DRIFT_PHASE_STEP_RAD = 0.8
"""A step of the search for d changes the phase at the ends of the trial by this much, a quarter of
what turns the wave around."""
NEAR_SHARE = 0.1
"""The frequency in the middle is within this share of that of the whole trial."""
MIN_DRIFT_FRAMES = 40
"""Frames after the spin-up without which no drift is looked for."""
REGRESSION_ROUNDS = 8
"""Gauss-Newton steps, each with new robust weights."""
FALSE_ALARM_PROBABILITY = 1e-3
"""Probability that noise alone, searched over all frequencies and drifts, shows a beat."""
NO_DRIFT = (float("nan"), float("nan"))


def tail_beat_drift(positions: Positions, beat_hz: float) -> tuple[float, float]:
    """Relative change of the tail beat's frequency per second (1/s) after the motor's spin-up, and
    its standard deviation; NaN where it is not seen.

    beat_hz: frequency of the beat in the video. More than half a beat of it between frames shows
    no drift.
    """
    time_s, signal = beat_signal(positions)
    if len(time_s) < MIN_DRIFT_FRAMES or not beat_hz > 0:
        return NO_DRIFT
    late = time_s > spin_up_end_s(float(time_s[0]), float(time_s[-1]))
    t, signal = time_s[late] - 0.5 * (time_s[late][0] + time_s[-1]), signal[late]
    if len(t) < MIN_DRIFT_FRAMES or beat_hz * float(np.median(np.diff(t))) > 0.5:
        return NO_DRIFT
    background = slow_background(t, beat_hz)
    start, tried = _coarse_optimum(t, signal, background, beat_hz)
    return _regression(t, signal, background, start, tried)


def _coarse_optimum(
    t: Float, signal: Float, background: Float, beat_hz: float
) -> tuple[tuple[float, float], int]:
    """Frequency (Hz) and drift (1/s) of the least misfit on a grid, and the grid's size."""
    span = float(np.ptp(t))
    step = DRIFT_PHASE_STEP_RAD / (np.pi * beat_hz * (0.5 * span) ** 2)
    count = int(MAX_DRIFT_PER_S / step)
    drifts = step * np.arange(-count, count + 1)
    hz = np.arange((1 - NEAR_SHARE) * beat_hz, (1 + NEAR_SHARE) * beat_hz, 0.2 / span)
    weights = np.ones_like(signal)
    best = (np.inf, beat_hz, 0.0)
    for drift in drifts:
        misfit = misfit_spectrum(hz, t + 0.5 * drift * t**2, signal, background, weights)
        place = int(np.argmin(misfit))
        best = min(best, (float(misfit[place]), float(hz[place]), float(drift)))
    return best[1:], len(hz) * len(drifts)


def _regression(
    t: Float, signal: Float, background: Float, start: tuple[float, float], tried: int
) -> tuple[float, float]:
    """Drift (1/s) and its standard deviation by Gauss-Newton steps from a near start; NaN where the
    beat may be noise, the best of `tried` ones.

    Of normally distributed noise of variance s^2, a beat explains the sum of squares 2 s^2 x with
    the probability e^-x.
    """
    (hz, drift), weights = start, np.ones_like(signal)
    for _ in range(REGRESSION_ROUNDS):
        phase = 2 * np.pi * hz * (t + 0.5 * drift * t**2)
        waves = np.column_stack([np.cos(phase), np.sin(phase), background])
        root = np.sqrt(weights)[:, None]
        value = np.linalg.lstsq(waves * root, signal * root[:, 0], rcond=None)[0]
        residual = signal - waves @ value
        weights = robust_weights(residual)
        slope = 2 * np.pi * (value[1] * waves[:, 0] - value[0] * waves[:, 1])
        design = np.column_stack([slope * t, 0.5 * hz * slope * t**2, waves])
        root = np.sqrt(weights)[:, None]
        step = np.linalg.lstsq(design * root, residual * root[:, 0], rcond=None)[0][:2]
        hz, drift = hz + float(step[0]), drift + float(step[1])
    variance = _noise_variance(design, residual, weights)
    explained = 0.5 * float(weights.sum()) * float(value[0] ** 2 + value[1] ** 2)
    if explained < 2 * variance * np.log(tried / FALSE_ALARM_PROBABILITY):
        return NO_DRIFT
    cov = np.linalg.pinv((design * weights[:, None]).T @ design)
    return drift, float(np.sqrt(variance * cov[1, 1]))


def _noise_variance(design: Float, residual: Float, weights: Float) -> float:
    """Variance of residuals as if they were independent: times their correlation time."""
    variance = float(residual @ (weights * residual)) / max(weights.sum() - design.shape[1], 1.0)
    return variance * correlation_time_samples(residual * np.sqrt(weights))
