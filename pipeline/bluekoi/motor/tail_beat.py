"""Tail-beat frequency as the camera sees it.

Periodogram by least squares (Lomb 1976; with a slow background instead of a constant): frames need
not be equally spaced, and a beat above half the frame rate is found as long as the guess is near.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from ..data import FlappingFrequency, Float, KeypointPositions, Pose
from ..data.keypoint_quality import correlation_time_samples
from .beat_regression import (
    TAIL_ANGLE_KEYPOINTS,
    beat_signal,
    misfit_spectrum,
    robust_weights,
    slow_trend_basis,
    tail_angle,
)

FRAME_RATE_ERROR_FACTORS = (1 / 8, 1 / 4, 1 / 2, 2.0, 4.0, 8.0)
"""Usual mistakes of a frame rate: slow motion played at another rate, 240 for 29.97, and so on."""
MIN_AMPLITUDE_RATIO_TO_REPLACE_BEAT = 2.0
MAX_BEAT_STD_SHARE = 1e-3
"""Relative deviation of a tail beat that is there: noise alone gives ten times that."""
ALIAS_TOLERANCE = 0.01
"""A beat above half the rate of the frames that show the tail, and off the motor's frequency by
more than this share, may be an alias.
"""
SEARCH_RANGE_SHARE_OF_GUESS = 0.25
"""The beat is looked for within this share of the guess, on both sides."""
MAX_BEATS_PER_FRAME = 2.0
"""With more beats than that between frames, any frequency fits as well as any other."""
MIN_TAIL_FRAMES = 12
"""Frames without which no tail beat is looked for."""
MAX_BEAT_LAG_STD_RAD = 0.5
"""A lag with a larger standard error is not reported."""


def tail_beat_from_video(
    source: KeypointPositions | Pose,
    guess_hz: float = float("nan"),
    *,
    flapping: FlappingFrequency | None = None,
) -> tuple[float, float]:
    """Tail-beat frequency in the video and its standard deviation, Hz; NaN where it is not seen.

    y(t) = background(t) + A cos phi + B sin phi, phi = 2 pi f t. y is the
    tail's angle to the core, or where tail points are missing the heading. With `flapping` phi
    follows the motor's own rate over time (spin-up), scaled by one ratio of the clocks.

    guess_hz: expected frequency; without it all frequencies below half the frame rate are tried.
    More than two beats of it between frames are not seen.
    """
    time_s, signal = beat_signal(source)
    if len(time_s) < MIN_TAIL_FRAMES:
        return float("nan"), float("nan")
    step = float(np.median(np.diff(time_s)))
    guessed = np.isfinite(guess_hz) and guess_hz > 0
    if guessed and guess_hz * step > MAX_BEATS_PER_FRAME:
        return float("nan"), float("nan")
    span = float(np.ptp(time_s))
    near = (
        (1 - SEARCH_RANGE_SHARE_OF_GUESS) * guess_hz,
        (1 + SEARCH_RANGE_SHARE_OF_GUESS) * guess_hz,
    )
    low, high = near if guessed else (2 / span, 0.45 / step)
    reference = guess_hz if guessed else np.sqrt(low * high)
    warp = _time_warped_to_motor_phase(time_s, flapping)
    return _search_beat_frequency(warp, signal, (low, high), slow_trend_basis(time_s, reference))


def tail_beat_lag(
    source: KeypointPositions | Pose, flapping: FlappingFrequency
) -> tuple[float, float]:
    """By how much the tail beat is behind the motor's shaft at the same time, and the standard
    deviation, rad; NaN where either is not seen.

    y(t) = background(t) + R cos(phi(t) - lag), phi the shaft's own phase in the log.
    """
    nothing = float("nan"), float("nan")
    time_s, signal = beat_signal(source)
    if len(flapping.phase_rad) < 3:
        return nothing
    inside = (time_s >= flapping.time_s[0]) & (time_s <= flapping.time_s[-1])
    time_s, signal = time_s[inside], signal[inside]
    if len(time_s) < MIN_TAIL_FRAMES:
        return nothing
    phase = np.interp(time_s, flapping.time_s, flapping.phase_rad)
    waves = np.column_stack([np.cos(phase), np.sin(phase)])
    design = np.column_stack([waves, slow_trend_basis(time_s, flapping.flap_hz)])
    weights = np.ones_like(signal)
    for _ in range(4):
        root = np.sqrt(weights)[:, None]
        value = np.linalg.lstsq(design * root, signal * root[:, 0], rcond=None)[0]
        residual = signal - design @ value
        weights = robust_weights(residual)
    along, across = float(value[0]), float(value[1])
    variance = float(residual @ (weights * residual)) / max(float(weights.sum()) - len(value), 1.0)
    variance *= correlation_time_samples(residual * np.sqrt(weights))
    std = float(np.sqrt(2.0 * variance / len(signal)) / max(np.hypot(along, across), 1e-12))
    return (float(np.arctan2(across, along)), std) if std < MAX_BEAT_LAG_STD_RAD else nothing


def video_to_motor_frequency_ratio(
    source: KeypointPositions | Pose, flapping: FlappingFrequency
) -> tuple[float, float]:
    """Tail-beat frequency in the video over that of the motor, and its standard deviation.

    NaN where no tail beat is clear. A frame rate stated k times too high makes the ratio k. The
    beat is sought around the motor's frequency, around `FRAME_RATE_ERROR_FACTORS` times it with the
    motor's own rate over time, then over all frequencies below half the frame rate. A beat near the
    motor's frequency is replaced only by one `MIN_AMPLITUDE_RATIO_TO_REPLACE_BEAT` times as strong,
    so that no harmonic is taken for the beat. One that may be an alias is not used.
    """
    motor_hz = flapping.flap_hz
    hz, std = tail_beat_from_video(source, motor_hz, flapping=flapping)
    seen_s = beat_signal(source)[0]
    step = float(np.median(np.diff(seen_s))) if len(seen_s) > 1 else np.inf
    alias = hz * step > 0.5 and abs(hz / motor_hz - 1) > ALIAS_TOLERANCE
    known, least = (float("nan"), float("nan")) if alias else (hz, std), 0.0
    if np.isfinite(known[0]):
        least = MIN_AMPLITUDE_RATIO_TO_REPLACE_BEAT * _beat_amplitude_rad(source, hz, flapping)
    for factor in FRAME_RATE_ERROR_FACTORS:
        stretched = replace(source, time_s=source.time_s * factor)
        hz, std = tail_beat_from_video(stretched, motor_hz, flapping=flapping)
        clear = std < MAX_BEAT_STD_SHARE * hz and hz * step * factor < 0.5
        if clear and not _is_alias_of(motor_hz, factor * hz, step):
            size = _beat_amplitude_rad(stretched, hz, flapping)
            if size > least:
                known, least = (factor * hz, factor * std), size
    if not np.isfinite(known[0]):
        hz, std = tail_beat_from_video(source)
        clear = std < MAX_BEAT_STD_SHARE * hz and not _is_alias_of(motor_hz, hz, step)
        known = (hz, std) if clear else known
    ratio, error = known[0] / motor_hz, known[1] / motor_hz
    return ratio, float(np.hypot(error, ratio * flapping.flap_hz_std / motor_hz))


def _is_alias_of(beat_hz: float, seen_hz: float, step_s: float) -> bool:
    """Whether frames at this interval show a beat above half their rate at the frequency seen."""
    if beat_hz * step_s <= 0.5:
        return False
    folded_hz = abs(beat_hz - round(beat_hz * step_s) / step_s)
    return abs(folded_hz - seen_hz) < ALIAS_TOLERANCE * beat_hz


def _beat_amplitude_rad(
    source: KeypointPositions | Pose, hz: float, flapping: FlappingFrequency
) -> float:
    """Amplitude of the beat at this frequency, rad."""
    time_s, signal = beat_signal(source)
    design = _design_matrix(
        hz, _time_warped_to_motor_phase(time_s, flapping), np.ones((len(time_s), 1))
    )
    return float(np.hypot(*np.linalg.lstsq(design, signal, rcond=None)[0][:2]))


def tail_excursion(positions: KeypointPositions) -> float:
    """Peak-to-peak lateral excursion of the tail tip about the core axis, m; NaN where not seen.

    2 sqrt(2) times the standard deviation of (tail tip - tail base) across the core.
    """
    if not set(TAIL_ANGLE_KEYPOINTS) <= set(positions.names):
        return float("nan")
    tail = positions.part("tail_tip") - positions.part("tail_base")
    across = np.linalg.norm(tail, axis=1) * np.sin(tail_angle(positions))
    seen = across[np.isfinite(across)]
    return float(2 * np.sqrt(2) * np.std(seen)) if len(seen) >= MIN_TAIL_FRAMES else float("nan")


def _search_beat_frequency(
    time_s: Float, signal: Float, limits_hz: tuple[float, float], background: Float
) -> tuple[float, float]:
    span = float(np.ptp(time_s))
    grid = np.arange(limits_hz[0], limits_hz[1], 0.1 / span)
    weights = np.ones_like(signal)
    for _ in range(4):
        best = grid[int(np.argmin(misfit_spectrum(grid, time_s, signal, background, weights)))]
        weights = robust_weights(_regression_residual(best, time_s, signal, background, weights))
    found = minimize_scalar(
        lambda f: _weighted_misfit(f, time_s, signal, background, weights),
        bounds=(best - 0.2 / span, best + 0.2 / span),
        method="bounded",
        options={"xatol": 1e-7},
    )
    return _frequency_and_std(float(found.x), time_s, signal, background, weights)


def _time_warped_to_motor_phase(time_s: Float, flapping: FlappingFrequency | None) -> Float:
    """Time that passes evenly in motor phase: integral of hz(t) / flap_hz."""
    if flapping is None or len(flapping.hz) < 3:
        return time_s
    fine = np.linspace(time_s[0], time_s[-1], 20 * len(time_s))
    rate = np.interp(fine, flapping.time_s, flapping.hz) / flapping.flap_hz
    rate = np.where(np.abs(rate - 1) < 0.02, 1.0, rate)
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(fine)
    return np.interp(time_s, fine, np.concatenate([[0.0], np.cumsum(steps)]))


def _design_matrix(hz: float, time_s: Float, background: Float) -> Float:
    phase = 2 * np.pi * hz * (time_s - time_s.mean())
    return np.column_stack([np.cos(phase), np.sin(phase), background])


def _regression_residual(
    hz: float, time_s: Float, signal: Float, background: Float, weights: Float
) -> Float:
    design, root = _design_matrix(hz, time_s, background), np.sqrt(weights)
    value = np.linalg.lstsq(design * root[:, None], signal * root, rcond=None)[0]
    return np.asarray(signal - design @ value)


def _weighted_misfit(
    hz: float, time_s: Float, signal: Float, background: Float, weights: Float
) -> float:
    residual = _regression_residual(hz, time_s, signal, background, weights)
    return float(residual @ (weights * residual))


def _frequency_and_std(
    hz: float, time_s: Float, signal: Float, background: Float, weights: Float
) -> tuple[float, float]:
    """Frequency and deviation from the curve of the misfit; NaN where the line is not there."""
    step = 0.02 / float(np.ptp(time_s))
    low, mid, high = (
        _weighted_misfit(hz + k * step, time_s, signal, background, weights) for k in (-1, 0, 1)
    )
    none = _weighted_misfit(1e-9, time_s, signal, background, weights)
    residual = _regression_residual(hz, time_s, signal, background, weights)
    inflation = correlation_time_samples(residual * np.sqrt(weights))
    variance = mid / max(float(weights.sum()) - background.shape[1] - 3, 1.0) * inflation
    bend = (low - 2 * mid + high) / step**2
    if none - mid < 15 * variance or bend <= 0:
        return float("nan"), float("nan")
    return hz, float(np.sqrt(2 * variance / bend))
