"""When a motor starts, how much time its spin-up costs, and how its frequency drifts.

After the start the turns of the shaft are n(t) = n_0 + f (t - c) + f' (t - c)^2 / 2, c the middle
of that time. Extended back to the first motion at t_0, where the shaft stood at n(t_0), they say
that a shaft which turns at f at once would have started later by

    D = (n(t_0) - n_0 - f (t_0 - c) - f' (t_0 - c)^2 / 2) / f,

the time that the spin-up costs, whatever its form: tau of a first-order motor that starts from
rest, half the duration of a ramp.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from ..data import Float
from .shaft_angle import ShaftMotion

FIRST_MOTION_DEG = 2.0
"""A shaft that has turned by this (or by five deviations of its readings) has started."""
MAX_SPIN_UP_S, MAX_SPIN_UP_SHARE_OF_LOG = 2.0, 0.4
"""A motor has reached its speed this long after its start, or after this share of a short log."""
MIN_REST_S = 0.05
"""Shortest rest of the shaft at the start of a log that is one."""
READING_ERROR_HARMONICS = (1, 2)
"""Multiples of the shaft's angle in the reading error of a potentiometer."""


@dataclass(frozen=True)
class MotorStart:
    """Start of a motor on the log's clock (s), time lost by its spin-up (s), and drift of its
    frequency after that (share per second). NaN where the log does not show them.
    """

    start_s: float
    lost_time_s: float
    drift_per_s: float


def motor_start(shaft: ShaftMotion, last_s: float, direction: float) -> MotorStart:
    """`MotorStart` from a shaft's motion up to `last_s`; direction: sign of its turning."""
    time, turns = shaft.time_s, _unwrapped_turns(shaft, direction)
    threshold = max(FIRST_MOTION_DEG / 360.0, 5.0 * _reading_noise_turns(turns))
    rest = float(np.median(turns[:3]))
    moved = int(np.argmax(turns - rest > threshold))
    begin = spin_up_end_s(float(time[moved]), last_s)
    late = shaft.good & (time > begin) & (time < last_s)
    if late.sum() < 20:
        return MotorStart(float(time[0]), np.nan, np.nan)
    middle = 0.5 * (begin + last_s)
    value = np.linalg.lstsq(
        _regression_columns(time[late] - middle, turns[late]), turns[late], rcond=None
    )[0]
    n_0, hz, change, *waves = value
    at_rest = time[moved] - threshold / hz - time[0] > MIN_REST_S
    start = float(time[moved] - threshold / hz if at_rest else time[0])
    there = rest if at_rest else float(turns[0])
    past = start - middle
    reading = (_regression_columns(np.zeros(1), np.array([there]))[0, 3:] @ np.array(waves)).item()
    lost = (there - reading - n_0 - hz * past - 0.5 * change * past**2) / hz
    return MotorStart(start, float(lost), float(change / hz))


def spin_up_end_s(start_s: float, last_s: float) -> float:
    """Time by which a motor that starts at `start_s` has reached its speed."""
    return start_s + min(MAX_SPIN_UP_S, MAX_SPIN_UP_SHARE_OF_LOG * (last_s - start_s))


def _unwrapped_turns(shaft: ShaftMotion, direction: float) -> Float:
    """Turns of the shaft (samples,), joined from reading to reading: the motion by windows of a
    turn (`ShaftMotion.phase_rad`) may miss one where the shaft starts abruptly. Single wrong
    readings are replaced by their neighbours' median.
    """
    step = float(np.median(np.diff(shaft.time_s)))
    hz = float(np.quantile(np.abs(shaft.hz), 0.9))
    near = 2 * int(0.05 / max(hz * step, 1e-3)) + 1  # readings within a tenth of a turn
    angle = direction * shaft.phase_rad
    x, y = (median_filter(g(angle), size=near, mode="nearest") for g in (np.cos, np.sin))
    return np.asarray(np.unwrap(np.arctan2(y, x)) / (2 * np.pi))


def _regression_columns(time_s: Float, turns: Float) -> Float:
    """Columns (n, 7): 1, t, t^2 / 2 and the reading error's harmonics of the shaft's angle."""
    waves = [g(2 * np.pi * k * turns) for k in READING_ERROR_HARMONICS for g in (np.cos, np.sin)]
    return np.column_stack([np.ones_like(time_s), time_s, 0.5 * time_s**2, *waves])


def _reading_noise_turns(turns: Float) -> float:
    """Deviation of single readings (turns), from how they differ from their neighbours' mean."""
    middle = turns[1:-1] - 0.5 * (turns[2:] + turns[:-2])
    return 1.4826 * float(np.median(np.abs(middle))) / np.sqrt(1.5) if len(middle) else 0.0
