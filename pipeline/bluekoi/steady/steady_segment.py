"""Steady segment of a trial, with its speed and radius."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from ..data import FlappingFrequency, Float, SteadyState, Track
from .circle_fit import Circle, fit_circle
from .speed_plateau import Plateau, fit_plateau
from .track_error_covariance import (
    error_correlation_time_s,
    residual_covariance,
    smoothed_error_covariance,
)

MAX_STRAIGHT_RUN_ARC_DEG = 20.0
"""A path that bends less than this determines no radius."""
MIN_ARC_DEG = 25.0
"""Arc below which a turn determines no radius."""
SPEED_TOLERANCES = (0.005, 0.01, 0.02)
"""Steady: the speed changes by less than this share over the segment, the turning rate by less than
twice the share."""
YAW_RATE_TOLERANCE_RAD_S = 0.01
"""A change of turning rate, rad/s, that counts as none."""
MAX_EXTRAPOLATED_SPEED_RATIO = 1.2
"""The speed that the start-up tends to (v_inf) is accepted up to this multiple of the last."""
MIN_PATH_EXTENT_M = 0.02
"""Extent of a path below which the robot did not swim."""
MIN_SEGMENT_DURATION_S = 0.7
"""Shortest steady part of a trial."""
MIN_SEGMENT_FRAMES = 8
"""Frames without which no steady part is looked for."""
SUFFICIENT_QUALITIES = ("good", "straight")
"""Qualities with which no further part of the trial is looked at."""
MAX_RADIUS_STD_SHARE = 0.05
"""A radius with a larger relative error counts as too short an arc."""


@dataclass(frozen=True)
class _Segment:
    """Frames of the steady segment, and whether it is steady."""

    frames: slice
    settled: bool


def steady_state(track: Track, flapping: FlappingFrequency, head_angle_rad: float) -> SteadyState:
    """Steady speed, radius and arc of a trial, with quality and what to try next.

    Speed: mean over the steady segment, or v_inf of the start-up where it is not reached. Radius:
    geometric circle through the smoothed positions of the segment, inf for a straight run. The
    strictest tolerance whose segment suffices counts; the strictest where none does.
    """
    if len(track.time_s) < 8 or not np.isfinite(track.speed_m_s).all():
        return _steady_state_without_data(
            flapping, "fewer than 8 frames: film for longer or check the detection"
        )
    if np.hypot(np.ptp(track.x_m), np.ptp(track.y_m)) < MIN_PATH_EXTENT_M:
        return _steady_state_without_data(
            flapping, f"the robot moves less than {MIN_PATH_EXTENT_M:g} m: did it start?"
        )
    plateau = fit_plateau(
        track.time_s, track.speed_m_s, _speed_error_covariance(track, slice(None))
    )
    candidates = (
        _steady_state_of_segment(track, flapping, head_angle_rad, plateau, segment)
        for segment in _steady_segments(track, plateau)
    )
    strictest = next(candidates)
    return next(
        (one for one in chain([strictest], candidates) if one.quality in SUFFICIENT_QUALITIES),
        strictest,
    )


def _steady_state_of_segment(
    track: Track,
    flapping: FlappingFrequency,
    head_angle_rad: float,
    plateau: Plateau,
    segment: _Segment,
) -> SteadyState:
    """Steady state of one segment."""
    at = segment.frames
    speed, speed_std = (
        _mean_speed(track, at) if segment.settled else _extrapolated_speed(track, at, plateau)
    )
    arc = float(track.heading_rad[at][-1] - track.heading_rad[at][0])
    base = SteadyState(
        flap_hz=flapping.flap_hz,
        speed_m_s=speed,
        speed_std_m_s=speed_std,
        radius_m=float("inf"),
        radius_std_m=float("inf"),
        arc_deg=abs(float(np.degrees(arc))),
        steady_from_s=float(track.time_s[at][0]),
        steady_to_s=float(track.time_s[at][-1]),
        quality="",
        reason="",
    )
    if abs(np.degrees(arc)) < MAX_STRAIGHT_RUN_ARC_DEG and abs(head_angle_rad) < np.radians(2.0):
        return _steady_state_of_straight_run(base, segment, plateau)
    return _steady_state_of_turn(base, track, segment, arc)


def _steady_state_without_data(flapping: FlappingFrequency, reason: str) -> SteadyState:
    nan = float("nan")
    return SteadyState(flapping.flap_hz, nan, nan, nan, nan, nan, nan, nan, "no_data", reason)


def _steady_segments(track: Track, plateau: Plateau) -> Iterator[_Segment]:
    """Longest segment up to the end over which speed and turning rate do not change, for each
    tolerance that leaves one, the strictest first; without any, the last part of the trial.
    """
    t = track.time_s
    span = float(t[-1] - t[0])
    latest = max(t[-1] - max(MIN_SEGMENT_DURATION_S, 0.2 * span), t[0])
    starts = np.searchsorted(t, np.linspace(t[0], latest, 40)).tolist()
    parts = [slice(start, len(t)) for start in starts if len(t) - start >= MIN_SEGMENT_FRAMES]
    steady = False
    for tolerance in SPEED_TOLERANCES:
        at = next((part for part in parts if _has_no_trend(track, part, tolerance)), None)
        if at is not None:
            steady = True
            yield _Segment(at, True)
    if not steady:
        first = min(int(np.searchsorted(t, latest)), len(t) - MIN_SEGMENT_FRAMES)
        yield _Segment(slice(first, len(t)), plateau.settled_s < t[-1])


def _has_no_trend(track: Track, at: slice, tolerance: float) -> bool:
    """Whether the trend over the segment is below the tolerance in speed and in turning rate.

    A trend that cannot be distinguished from none passes up to three times the tolerance.
    """
    t = track.time_s[at]
    slope = _slope_regression_weights(t) * float(np.ptp(t))
    speed, rate = track.speed_m_s[at], track.yaw_rate_rad_s[at]
    detectable = 2 * float(np.sqrt(slope @ _speed_error_covariance(track, at) @ slope))
    detectable_bend = 2 * float(np.sqrt(slope @ _yaw_rate_error_covariance(track, at) @ slope))
    fast, turning = abs(float(np.mean(speed))), abs(float(np.mean(rate)))
    limit = max(tolerance * fast, min(detectable, 3 * tolerance * fast))
    bend = max(
        2 * tolerance * turning,
        min(detectable_bend, 6 * tolerance * turning),
        YAW_RATE_TOLERANCE_RAD_S,
    )
    return abs(float(slope @ speed)) < limit and abs(float(slope @ rate)) < bend


def _slope_regression_weights(t: Float) -> Float:
    centred = t - t.mean()
    return np.asarray(centred / (centred @ centred))


def _speed_error_covariance(track: Track, at: slice) -> Float:
    """Errors of the speed: derivative of a smooth process, so they nearly cancel in the mean."""
    t, std = track.time_s[at], track.speed_m_s_std[at]
    length = error_correlation_time_s(
        np.hypot(track.x_m_std, track.y_m_std) / np.sqrt(2), track.speed_m_s_std
    )
    return smoothed_error_covariance(t, std, length)


def _yaw_rate_error_covariance(track: Track, at: slice) -> Float:
    length = error_correlation_time_s(track.heading_rad_std, track.yaw_rate_rad_s_std)
    return smoothed_error_covariance(track.time_s[at], track.yaw_rate_rad_s_std[at], length)


def _mean_speed(track: Track, at: slice) -> tuple[float, float]:
    """Mean speed over the segment and its deviation."""
    speed = track.speed_m_s[at]
    cov = _speed_error_covariance(track, at) + residual_covariance(track.time_s[at], speed, 1)
    return float(speed.mean()), float(np.sqrt(cov.mean()))


def _extrapolated_speed(track: Track, at: slice, plateau: Plateau) -> tuple[float, float]:
    """Steady speed where it is not reached: v_inf of the start-up where that is near.

    Where it is not, the start-up is no tanh, and the last speed stands with its own change.
    """
    speed = track.speed_m_s[at]
    if plateau.speed_m_s < MAX_EXTRAPOLATED_SPEED_RATIO * float(speed[-1]):
        return plateau.speed_m_s, max(plateau.speed_std_m_s, 0.02 * plateau.speed_m_s)
    return float(speed.mean()), float(max(np.ptp(speed), plateau.speed_std_m_s))


def _steady_state_of_straight_run(
    base: SteadyState, segment: _Segment, plateau: Plateau
) -> SteadyState:
    if segment.settled:
        return replace(base, quality="straight")
    reason = "the speed still changes at the end: film for longer or start nearer the wall"
    if plateau.speed_m_s < MAX_EXTRAPOLATED_SPEED_RATIO * base.speed_m_s:
        reason += f"; by its start-up it would be within 1 % at {plateau.settled_s:.1f} s"
    return replace(base, quality="not_steady", reason=reason)


def _steady_state_of_turn(
    base: SteadyState, track: Track, segment: _Segment, arc: float
) -> SteadyState:
    circle = _fit_segment_circle(track, segment.frames)
    quality, reason = _quality_and_reason(base, track, segment, circle)
    return replace(
        base,
        radius_m=circle.radius_m,
        radius_std_m=circle.radius_std_m,
        quality=quality,
        reason=reason,
        turn=int(np.sign(arc)),
        center_m=(float(circle.center_m[0]), float(circle.center_m[1])),
    )


def _fit_segment_circle(track: Track, at: slice) -> Circle:
    """Circle of the segment; its covariance holds smoothing errors, scatter, and slow change.

    Where water moves, the curvature kappa of the path wanders and circles of other parts of the
    same turn differ: R^4 var(mean kappa) is added to the variance of the radius.
    """
    t, xy = track.time_s[at], np.column_stack([track.x_m, track.y_m])[at]
    std = np.hypot(track.x_m_std, track.y_m_std)[at] / np.sqrt(2)
    rate = np.hypot(track.vx_m_s_std, track.vy_m_s_std)[at] / np.sqrt(2)
    own = smoothed_error_covariance(t, std, error_correlation_time_s(std, rate))
    first = fit_circle(xy, own)
    circle = fit_circle(xy, own + residual_covariance(t, first.residual_m, 3))
    direction = np.unwrap(np.arctan2(track.vy_m_s[at], track.vx_m_s[at]))
    kappa = np.gradient(direction, t) / np.maximum(track.speed_m_s[at], 1e-9)
    cov = circle.cov.copy()
    cov[2, 2] += circle.radius_m**4 * float(residual_covariance(t, kappa, 1).mean())
    return replace(circle, cov=cov)


def _quality_and_reason(
    base: SteadyState, track: Track, segment: _Segment, circle: Circle
) -> tuple[str, str]:
    if not segment.settled:
        return "not_steady", "speed or turning rate still change at the end: film for longer"
    if base.arc_deg < MIN_ARC_DEG or circle.radius_std_m > MAX_RADIUS_STD_SHARE * circle.radius_m:
        return "short_arc", (
            f"an arc of {base.arc_deg:.0f} degrees leaves the radius "
            f"uncertain by {circle.radius_std_m:.3f} m: film for longer, or start where the turn "
            "stays in the pool"
        )
    rate = abs(float(np.mean(track.yaw_rate_rad_s[segment.frames])))
    other = base.speed_m_s / rate if rate > 0 else float("inf")
    apart = abs(other - circle.radius_m)
    if apart > max(3 * circle.radius_std_m, 0.05 * circle.radius_m):
        return "good", f"speed / yaw rate gives {other:.3f} m: the water may move"
    return "good", ""
