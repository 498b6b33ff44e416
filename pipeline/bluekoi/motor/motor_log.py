"""Flapping frequency from a motor log: `time_s,angle_deg`, the shaft angle every few ms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import chdtri

from ..data import FlappingFrequency, Float, read_columns
from ..data.keypoint_quality import correlation_time_samples
from ..errors import input_error
from .shaft_angle import ShaftMotion, shaft_motion
from .spin_up import motor_start

LOG_COLUMNS = ("time_s", "angle_deg")
"""Columns of a motor log."""
MIN_SHAFT_TURNS = 1.5
"""Turns of the shaft without which a log gives no frequency."""
MAX_TURN_DEG = 400.0
"""A shaft angle that wraps after more than this is not in degrees."""
MAX_GAP_S = 0.5
"""Longest hole in a log over which the turns are still counted."""


MIN_LOGGED_SHARE = 0.5
"""Share of a recording that its motor log covers, below which there is a warning."""
MAX_FREQUENCY_STD_SHARE = 0.2
"""A log whose frequency is known no better than to this share shows no turning shaft."""


def flapping_from_log(path: str | Path) -> FlappingFrequency:
    """Flapping frequency of the constant part, with standard deviation and over time [Hz].

    phi = phi0 + 2 pi f t + A exp(-t / tau) + reading error of the shaft's own harmonics, by least
    squares over the sound readings; the exponential (spin-up) only where the data ask for it. The
    standard deviation counts how long residuals stay correlated. One turn is one tail beat; the
    direction of turning does not matter.

    Raises: InputError with row, found and remedy for columns or units swapped, an empty log, a
    shaft that does not turn.
    """
    time_s, angle_rad, remarks = read_log(path)
    shaft = shaft_motion(time_s, angle_rad)
    first, last = _running_interval_s(shaft)
    inside = shaft.good & (time_s >= first) & (time_s <= last)
    turns = abs(float(np.ptp(shaft.phase_rad[inside]))) / (2 * np.pi) if inside.any() else 0.0
    if turns < MIN_SHAFT_TURNS:
        raise input_error(
            path,
            "angle_deg",
            f"{turns:.2f} turns of the shaft",
            f"at least {MIN_SHAFT_TURNS} turns",
            "Log for longer, or give flap_hz in trials.csv instead of motor_log.",
        )
    fit = _fit_phase(time_s[inside], shaft.phase_rad[inside])
    if not fit.hz_std < MAX_FREQUENCY_STD_SHARE * abs(fit.hz):
        raise input_error(
            path,
            "angle_deg",
            f"a shaft that turns at {abs(fit.hz):.3g} +- {fit.hz_std:.2g} Hz",
            "a shaft that turns steadily",
            "Are these the shaft's angles, in degrees and in their order? Else give flap_hz in "
            "trials.csv instead of motor_log.",
        )
    notes = (*remarks, *_shaft_remarks(fit, shaft))
    begin = motor_start(shaft, last, float(np.sign(fit.hz)))
    return FlappingFrequency(
        flap_hz=abs(fit.hz),
        flap_hz_std=fit.hz_std,
        source="motor_log",
        time_s=shaft.center_s,
        hz=np.abs(shaft.hz),
        phase_rad=np.sign(fit.hz)
        * np.interp(shaft.center_s, shaft.time_s[shaft.good], shaft.phase_rad[shaft.good]),
        start_s=begin.start_s,
        lost_time_s=begin.lost_time_s,
        drift_per_s=begin.drift_per_s,
        remarks=notes,
    )


def motor_log_coverage(
    path: str | Path, flapping: FlappingFrequency, recording_s: tuple[float, float]
) -> float:
    """Share of a recording, from begin to end in seconds, during which its motor was logged.

    Raises: InputError where the log is of another time.
    """
    begin, end = recording_s
    first, last = float(flapping.time_s[0]), float(flapping.time_s[-1])
    if first < end and last > begin:
        return (min(last, end) - max(first, begin)) / (end - begin)
    late = (
        f"The first frame used is at {begin:.4g} s: do frame numbers begin at 0, is start_s right?"
    )
    early = (
        "Time 0 is the first frame of the recording: subtract its time from the column. If the "
        "recording is longer than that, fps is wrong."
    )
    raise input_error(
        path, "time_s", f"times from {first:.10g} to {last:.10g} s",
        f"times of the recording, {begin:.4g} to {end:.4g} s",
        late if last <= begin and begin > 0 else early,
    )  # fmt: skip


def read_log(path: str | Path) -> tuple[Float, Float, tuple[str, ...]]:
    """Times (samples,) s, shaft angles (samples,) rad and remarks from a motor log.

    Raises: InputError as `flapping_from_log`.
    """
    columns = read_columns(path, LOG_COLUMNS)
    known = np.isfinite(columns["time_s"]) & np.isfinite(columns["angle_deg"])
    time_s, angle_deg = columns["time_s"][known], columns["angle_deg"][known]
    if len(time_s) < 20:
        raise input_error(
            path, "", f"{len(time_s)} rows with numbers", "the shaft angle every 5 ms"
        )
    _check_times(path, time_s, angle_deg)
    _check_angles(path, angle_deg)
    remarks = [] if known.all() else [f"{int((~known).sum())} rows of the motor log are empty"]
    keep = _longest_stretch_without_gap(time_s)
    if not keep.all():
        remarks.append(
            f"the motor log has a hole of more than {MAX_GAP_S:g} s; only "
            f"{time_s[keep][0]:.2f} to {time_s[keep][-1]:.2f} s is used"
        )
    return time_s[keep], np.radians(angle_deg[keep]), tuple(remarks)


def _check_times(path: str | Path, time_s: Float, angle_deg: Float) -> None:
    steps = np.diff(time_s)
    step = float(np.median(steps))
    swapped = "The columns look swapped: angle_deg rises like a time. Exchange them."
    if np.any(steps <= 0):
        row = int(np.argmax(steps <= 0)) + 3
        rises = bool(np.all(np.diff(angle_deg) > 0)) and float(np.median(np.diff(angle_deg))) < 0.5
        found = f"time {time_s[row - 2]:g} s after {time_s[row - 3]:g} s"
        remedy = swapped if rises else "Sort the rows by time and remove repeated ones."
        raise input_error(path, f"row {row}, time_s", found, "times that increase", remedy)
    if step > 0.5:
        unit, factor = ("microseconds", "1e6") if step > 500 else ("milliseconds", "1000")
        remedy = f"If these are {unit}, divide the column by {factor}."
        raise input_error(
            path, "time_s", f"a step of {step:g} s", "seconds, a few ms apart", remedy
        )
    if step > 0.08:
        remedy = "Log every 5 ms: slower than that, the turns cannot be counted."
        raise input_error(path, "time_s", f"a step of {step:g} s", "a few ms between rows", remedy)


def _check_angles(path: str | Path, angle_deg: Float) -> None:
    low, high = float(np.min(angle_deg)), float(np.max(angle_deg))
    turns_over = np.sum(np.abs(np.diff(angle_deg)) > 0.5 * (high - low))
    found = f"angles from {low:.4g} to {high:.4g}"
    if 5.0 < high - low < 6.4 and turns_over > 0:
        remedy = "These look like radians: multiply the column by 180/pi."
        raise input_error(path, "angle_deg", found, "degrees from 0 to 360", remedy)
    if 0.5 < high - low <= 1.0 and turns_over > 0:
        remedy = "These look like turns: multiply the column by 360."
        raise input_error(path, "angle_deg", found, "degrees from 0 to 360", remedy)
    if high - low > MAX_TURN_DEG and turns_over > 0:
        remedy = "These look like a sensor's counts: multiply the column by 360 / counts a turn."
        raise input_error(path, "angle_deg", found + ", and then from the start",
                          "degrees from 0 to 360",
                    remedy)  # fmt: skip
    if high - low < 30.0:
        remedy = (
            "The shaft never turned or the sensor is not connected: give flap_hz in trials.csv."
        )
        raise input_error(path, "angle_deg", found, "a shaft that turns", remedy)


def _longest_stretch_without_gap(time_s: Float) -> np.ndarray:
    """Samples (samples,) of the longest stretch without a hole."""
    part = np.concatenate([[0], np.cumsum(np.diff(time_s) > MAX_GAP_S)])
    spans = [np.ptp(time_s[part == i]) for i in range(part[-1] + 1)]
    return np.asarray(part == int(np.argmax(spans)))


def _running_interval_s(shaft: ShaftMotion) -> tuple[float, float]:
    """First and last time at which the motor runs, spin-up included, spin-down left out."""
    rate = np.abs(shaft.hz)
    top = float(np.median(rate[rate > 0.5 * np.quantile(rate, 0.9)]))
    half = np.median(np.diff(shaft.center_s)) if len(rate) > 1 else np.inf
    first = shaft.center_s[np.argmax(rate > 0.2 * top)]
    last = shaft.center_s[len(rate) - 1 - np.argmax(rate[::-1] > 0.95 * top)]
    return float(first - half), float(last + half)


@dataclass(frozen=True)
class _PhaseFit:
    hz: float
    hz_std: float
    tau_s: float
    drift: float


def _fit_phase(time_s: Float, phase_rad: Float) -> _PhaseFit:
    """Frequency of the constant part; tau_s is 0 without spin-up, drift in Hz over the log."""
    span = float(np.ptp(time_s))
    plain = _regress_phase(time_s, phase_rad, 0.0)
    tries = [_regress_phase(time_s, phase_rad, tau) for tau in np.geomspace(0.04, 0.25, 12) * span]
    best = min(tries, key=lambda fit: fit[1])
    gain = len(time_s) / plain[3] * np.log(plain[1] / best[1])
    value, _, std, _, tau = best if gain > chdtri(2, 1e-4) else plain
    drift = _regress_phase(time_s, phase_rad, tau, drift=True)
    sagging = abs(drift[0][-1]) > 5 * drift[2][-1] and abs(drift[0][-1]) > 0.003 * abs(value[0])
    if sagging:
        value, std = drift[0], drift[2]
    return _PhaseFit(value[0], std[0], tau, drift[0][-1] if sagging else 0.0)


def _regress_phase(
    time_s: Float, phase_rad: Float, tau_s: float, *, drift: bool = False
) -> tuple[Float, float, Float, float, float]:
    """Coefficients, residual sum of squares, their deviations, inflation, and tau_s again.

    Columns: 2 pi t, 1, four harmonics of the shaft angle (reading error), exp(-t / tau), and as
    the last a parabola scaled to the change of frequency over the log.
    """
    span, t = float(np.ptp(time_s)), time_s - float(np.mean(time_s))
    waves = [g(k * phase_rad) for k in (1, 2) for g in (np.cos, np.sin)]
    columns = [2 * np.pi * t, np.ones_like(t)]
    if abs(np.ptp(phase_rad)) > 6 * np.pi:
        columns += waves
    if tau_s > 0:
        columns.append(np.exp(-(time_s - time_s[0]) / tau_s))
    if drift:
        columns.append(np.pi * t**2 / span)
    design = np.column_stack(columns)
    inverse = np.linalg.pinv(design.T @ design)
    value = inverse @ (design.T @ phase_rad)
    residual = phase_rad - design @ value
    inflation = correlation_time_samples(residual)
    df = max(len(t) / inflation - design.shape[1], 1.0) * inflation
    total = float(residual @ residual)
    std = np.sqrt(np.diag(inverse) * total / df * inflation)
    return value, total, std, inflation, tau_s


def _shaft_remarks(fit: _PhaseFit, shaft: ShaftMotion) -> list[str]:
    notes = [f"dead zone of the shaft sensor {np.degrees(shaft.dead_zone_rad):.0f} degrees"]
    if fit.tau_s > 0:
        notes.append(f"the motor spins up with a time constant of {fit.tau_s:.2f} s")
    if fit.drift:
        share = 100 * fit.drift / fit.hz
        notes.append(f"the flapping frequency changes by {share:+.1f} % over the log")
    return notes
