"""Motion of a shaft whose angle is read, wrapped, by a potentiometer with a dead zone.

The reading is a(t) = phi(t) mod 2 pi + noise outside the dead zone and anything (stuck, noise)
inside. The phase phi is found window by window as the strongest line of exp(i a), which a dead
zone or single wrong readings cannot move far, then fitted over the whole log.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicHermiteSpline

from ..data import BoolNDArray, Float

MIN_READINGS_PER_WINDOW = 5
"""The line of a window takes so many readings."""
SHAFT_BINS_PER_TURN = 72
"""Bins of the shaft's circle in which the dead zone is looked for: 5 degrees each."""


@dataclass(frozen=True)
class ShaftMotion:
    """Unwrapped motion of a shaft.

    time_s, phase_rad, good: (samples,): unwrapped phase read, and which readings are sound (not
    in the dead zone, not wrong). center_s, hz: (windows,): rate over about one turn each; the sign
    is the direction. dead_zone_rad: width of the dead zone.
    """

    time_s: Float
    phase_rad: Float
    good: BoolNDArray
    center_s: Float
    hz: Float
    dead_zone_rad: float


def wrap_angle(angle_rad: Float) -> Float:
    """Angle brought to [-pi, pi)."""
    return (angle_rad + np.pi) % (2 * np.pi) - np.pi


def shaft_motion(time_s: Float, angle_rad: Float) -> ShaftMotion:
    """Unwrapped phase, rate over time and dead zone from wrapped readings, both (samples,)."""
    center, rate, phase = _fit_windows(time_s, angle_rad, 0.25)
    turning = np.abs(rate[np.abs(rate) > 0.25])
    period = 1.0 / np.median(turning) if turning.size else 1.0
    center, rate, phase = _fit_windows(time_s, angle_rad, float(np.clip(period, 0.1, 1.0)))
    guess = _interpolate_phase(time_s, center, rate, phase)
    residual = wrap_angle(angle_rad - guess)
    spread = max(1.4826 * float(np.median(np.abs(residual))), np.radians(0.25))
    sound = np.abs(residual) < 5 * spread
    dead = _dead_zone_bins(guess, sound)
    good = sound & ~dead[_shaft_bin(guess)]
    width = 2 * np.pi * float(dead.mean())
    unwrapped = guess + residual
    hz = _window_rates_hz(time_s[good], unwrapped[good], center, rate)
    return ShaftMotion(time_s, unwrapped, good, center, hz, width)


def _window_rates_hz(time_s: Float, phase_rad: Float, center_s: Float, rate_hz: Float) -> Float:
    """Rate (Hz) in each window from its sound readings; the line's where there are too few."""
    if len(center_s) < 2:
        return rate_hz
    half = float(np.median(np.diff(center_s)))
    out = rate_hz.copy()
    for i, center in enumerate(center_s):
        first, last = np.searchsorted(time_s, [center - half, center + half])
        t = time_s[first:last] - center
        if last - first >= 5 and np.ptp(t) > half:
            centred = t - t.mean()
            slope = centred @ phase_rad[first:last] / (centred @ centred)
            out[i] = slope / (2 * np.pi)
    return out


def _fit_windows(time_s: Float, angle_rad: Float, width_s: float) -> tuple[Float, Float, Float]:
    """Centre (s), rate (Hz) and phase at the centre (rad) of windows that overlap by half.

    Windows are `width_s` long, or longer where readings are sparse.
    """
    span = time_s[-1] - time_s[0]
    width_s = max(width_s, (MIN_READINGS_PER_WINDOW + 1) * float(np.median(np.diff(time_s))))
    count = max(int(2 * span / width_s) - 1, 1)
    starts = time_s[0] + np.linspace(0.0, max(span - width_s, 0.0), count)
    rows = []
    for start in starts:
        inside = (time_s >= start) & (time_s <= start + width_s)
        if inside.sum() >= MIN_READINGS_PER_WINDOW:
            rows.append(
                _strongest_spectral_line(time_s[inside], angle_rad[inside], start + width_s / 2)
            )
    rows = rows or [_strongest_spectral_line(time_s, angle_rad, float(time_s[0] + span / 2))]
    return tuple(np.array(column) for column in zip(*rows, strict=True))  # type: ignore[return-value]


def _strongest_spectral_line(
    time_s: Float, angle_rad: Float, center_s: float
) -> tuple[float, float, float]:
    """Strongest line of exp(i a): argmax_f |sum exp(i (a - 2 pi f (t - centre)))|.

    Looked for around the median step from reading to reading.
    """
    t, z = time_s - center_s, np.exp(1j * angle_rad)
    span = max(float(np.ptp(t)), 1e-3)
    middle = float(np.median(wrap_angle(np.diff(angle_rad)) / np.diff(time_s))) / (2 * np.pi)
    half, sums = 3 / span, np.zeros(0)
    for points in (33, 17, 17):
        trial = middle + np.linspace(-half, half, points)
        sums = np.exp(-2j * np.pi * np.outer(trial, t)) @ z
        middle = float(trial[np.argmax(np.abs(sums))])
        half = 2 * half / (points - 1)
    return center_s, middle, float(np.angle(sums[np.argmax(np.abs(sums))]))


def _interpolate_phase(time_s: Float, center_s: Float, rate_hz: Float, phase_rad: Float) -> Float:
    """Phase at every sample: windows joined by the turns between them, then cubic Hermite."""
    if len(center_s) == 1:
        return phase_rad[0] + 2 * np.pi * rate_hz[0] * (time_s - center_s[0])
    advance = np.pi * (rate_hz[1:] + rate_hz[:-1]) * np.diff(center_s)
    steps = advance + wrap_angle(np.diff(phase_rad) - advance)
    joined = phase_rad[0] + np.concatenate([[0.0], np.cumsum(steps)])
    inside = np.clip(time_s, center_s[0], center_s[-1])
    curve = CubicHermiteSpline(center_s, joined, 2 * np.pi * rate_hz)
    slope = np.where(time_s < center_s[0], rate_hz[0], rate_hz[-1])
    return np.asarray(curve(inside) + 2 * np.pi * slope * (time_s - inside))


def _shaft_bin(phase_rad: Float) -> npt.NDArray[np.int64]:
    return np.minimum(
        (phase_rad % (2 * np.pi)) / (2 * np.pi) * SHAFT_BINS_PER_TURN, SHAFT_BINS_PER_TURN - 1
    ).astype(np.int64)


def _dead_zone_bins(phase_rad: Float, sound: BoolNDArray) -> BoolNDArray:
    """Bins (SHAFT_BINS_PER_TURN,) of the shaft's circle in which most readings are wrong."""
    seen = np.bincount(_shaft_bin(phase_rad), minlength=SHAFT_BINS_PER_TURN)
    right = np.bincount(
        _shaft_bin(phase_rad), weights=sound.astype(float), minlength=SHAFT_BINS_PER_TURN
    )
    return (seen > 2) & (right < 0.6 * seen)
