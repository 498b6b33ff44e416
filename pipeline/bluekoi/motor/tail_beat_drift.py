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

from ..data import Float, KeypointPositions
from ..data.keypoint_quality import correlation_time_samples
from .beat_regression import beat_signal, robust_weights, slow_trend_basis
from .spin_up import spin_up_end_s

MAX_DRIFT_PER_S = 0.05
"""The frequency changes by less than this share per second: a supply that loses half its voltage in
10 s is not one to swim with."""
DRIFT_PHASE_STEP_RAD = 0.8
"""A step of the search for d changes the phase at the ends of the trial by this much, a quarter of
what turns the wave around."""
MID_TRIAL_TO_MEAN_FREQUENCY_TOLERANCE_SHARE = 0.1
"""The frequency in mid-trial is within this share of the mean over the trial."""
MAX_BEATS_FOR_DRIFT = 300
"""Beats after the spin-up of which the drift is measured, to limit the computing time."""
COARSE_SEARCH_FRAMES_PER_BEAT = 16
"""Frames of a beat used to find the neighbourhood of its frequency and drift."""
MIN_FRAMES_FOR_DRIFT = 40
"""Frames after the spin-up without which no drift is looked for."""
REGRESSION_ROUNDS = 8
"""Gauss-Newton steps, each with new robust weights."""
FALSE_ALARM_PROBABILITY = 1e-3
"""Probability that noise alone, searched over all frequencies and drifts, shows a beat."""
UNKNOWN_DRIFT = (float("nan"), float("nan"))


def tail_beat_drift(positions: KeypointPositions, beat_hz: float) -> tuple[float, float]:
    """Relative change of the tail beat's frequency per second (1/s) after the motor's spin-up, and
    its standard deviation; NaN where it is not seen.

    beat_hz: frequency of the beat in the video. More than half a beat of it between frames shows
    no drift.
    """
    time_s, signal = beat_signal(positions)
    if len(time_s) < MIN_FRAMES_FOR_DRIFT or not beat_hz > 0:
        return UNKNOWN_DRIFT
    begin = spin_up_end_s(float(time_s[0]), float(time_s[-1]))
    used = (time_s > begin) & (time_s < begin + MAX_BEATS_FOR_DRIFT / beat_hz)
    t, signal = time_s[used], signal[used]
    t = t - 0.5 * (t[0] + t[-1]) if len(t) else t
    if len(t) < MIN_FRAMES_FOR_DRIFT or beat_hz * float(np.median(np.diff(t))) > 0.5:
        return UNKNOWN_DRIFT
    background = slow_trend_basis(t, beat_hz)
    start, tried = _grid_search_frequency_and_drift(t, signal, background, beat_hz)
    return _drift_regression(t, signal, background, start, tried)


def _grid_search_frequency_and_drift(
    t: Float, signal: Float, background: Float, beat_hz: float
) -> tuple[tuple[float, float], int]:
    """Frequency (Hz) and drift (1/s) of the largest power on a grid, and the grid's size.

    Of a signal s without its background, the power of a beat of frequency f at t = 0 that changes
    by c = f d (Hz/s) is |sum_t s exp(-2 pi i (f t + c t^2 / 2))|^2: one matrix product for all f
    and c. A frequency that changes by more than half up to the ends of the trial is not looked for.
    `COARSE_SEARCH_FRAMES_PER_BEAT` frames a beat are used.
    """
    thin = max(
        1, int(1.0 / (COARSE_SEARCH_FRAMES_PER_BEAT * beat_hz * float(np.median(np.diff(t)))))
    )
    t, signal, background = t[::thin], signal[::thin], background[::thin]
    span = float(np.ptp(t))
    step = DRIFT_PHASE_STEP_RAD / (np.pi * beat_hz * (0.5 * span) ** 2)
    count = int(min(MAX_DRIFT_PER_S, 1.0 / span) / step)
    drifts = step * np.arange(-count, count + 1)
    hz = np.arange(
        (1 - MID_TRIAL_TO_MEAN_FREQUENCY_TOLERANCE_SHARE) * beat_hz,
        (1 + MID_TRIAL_TO_MEAN_FREQUENCY_TOLERANCE_SHARE) * beat_hz,
        0.2 / span,
    )
    beating = signal - background @ np.linalg.lstsq(background, signal, rcond=None)[0]
    steady = np.exp(-2j * np.pi * np.outer(hz, t))
    changing = np.exp(-1j * np.pi * beat_hz * np.outer(t**2, drifts))
    power = np.abs(steady @ (beating[:, None] * changing))
    k, j = np.unravel_index(int(np.argmax(power)), power.shape)
    return (float(hz[k]), float(drifts[j] * beat_hz / hz[k])), power.size


def _drift_regression(
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
        return UNKNOWN_DRIFT
    cov = np.linalg.pinv((design * weights[:, None]).T @ design)
    return drift, float(np.sqrt(variance * cov[1, 1]))


def _noise_variance(design: Float, residual: Float, weights: Float) -> float:
    """Variance of residuals as if they were independent: times their correlation time."""
    variance = float(residual @ (weights * residual)) / max(weights.sum() - design.shape[1], 1.0)
    return variance * correlation_time_samples(residual * np.sqrt(weights))
