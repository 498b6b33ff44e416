"""Smoothed motion of the robot with its rates, the tail-beat recoil taken out of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..data import MIN_POSE_FRAMES, BoolNDArray, Float, Pose, Track
from ..errors import input_error
from .gaps import with_calibrated_gap_covariance
from .grid import FilterTimeGrid, filter_time_grid
from .kalman_filterpy import filter_and_smooth
from .kalman_numba import compiled_filter_and_smooth
from .linear_gaussian import SmoothedStates
from .noise_fit import FittedMotionModel
from .nominal_motion import rough_speed
from .screening import screen_measurements
from .speed import speed_and_std
from .state_space_fit import (
    MIN_LR_STATISTIC_MOVING_START,
    KnownMotion,
    cost_with_moving_start,
    fit_angle,
    fit_position,
)

FIRST_BEAT_SHARE, MAX_FIRST_SPEED_SHARE = 0.25, 0.5
"""A body that has more than half its speed after a quarter of a tail beat did not start from rest.
At a constant thrust, V tanh(t / T), that would take a time constant T below half a beat. In 1600
simulated trials from rest the speed is then at most 0.4 of that later."""

HeadingAndPositionModels = tuple[FittedMotionModel, FittedMotionModel]


def smooth_pose(pose: Pose, flap_hz: float) -> Track:
    """Mean motion of the trial by Kalman filter and smoother; see `motion` for the model.

    Velocities and the yaw rate are states of the filter, the derivative of the smoothed position
    without the recoil. Over gaps the motion is interpolated and its uncertainty grows (`gaps`).
    Process noise and the true size of the measurement noise are the most likely ones.

    flap_hz: flapping frequency; 0 or NaN for a body that does not beat. Less than one beat in the
    whole recording is no recoil.
    Raises: InputError where fewer than 8 frames show the robot.
    """
    return smoothed_track_and_noise_ratio(pose, flap_hz)[0]


def smoothed_track_and_noise_ratio(pose: Pose, flap_hz: float) -> tuple[Track, tuple[float, float]]:
    """As `smooth_pose`, and the variance of the measurement noise found over that stated, of
    positions and heading.
    """
    _check_enough_frames(pose)
    beats = float(flap_hz) * float(np.ptp(pose.time_s))
    hz = float(flap_hz) if np.isfinite(beats) and beats > 1 else 0.0
    grid = filter_time_grid(pose.time_s, hz)
    values, cov = grid.frame_values_on_nodes(pose.values), grid.frame_values_on_nodes(pose.cov)
    heading, plane = _fitted_models(values, cov, grid, hz)
    turn, move = _smooth_with_calibrated_gaps(heading, 1), _smooth_with_calibrated_gaps(plane, 2)
    theta = turn.x[:, 0]
    at = grid.frame
    track = Track(
        time_s=pose.time_s,
        **_position_track_fields(move.x[at], move.P[at]),
        **_velocity_track_fields(move.x[at], move.P[at], theta[at]),
        heading_rad=theta[at],
        heading_rad_std=np.sqrt(turn.P[at, 0, 0]),
        yaw_rate_rad_s=turn.x[at, 1],
        yaw_rate_rad_s_std=np.sqrt(turn.P[at, 1, 1]),
        **_smooth_head_angle(values[:, 3], cov[:, 3, 3], grid, hz),
        **_recoil_track_fields(move, turn, plane.model.H, at) if hz > 0 else {},
        remarks=_smoothing_remarks(pose, grid, plane, heading),
    )
    return track, (plane.noise_ratio, heading.noise_ratio)


def _speeds_up_too_fast(plane: FittedMotionModel, grid: FilterTimeGrid, hz: float) -> bool:
    """Whether a body that is taken to start from rest swims fast within a part of a tail beat.

    The burst of force at the onset may have any size in the filter. No tail makes one that large.
    """
    if hz <= 0:
        return False
    state = compiled_filter_and_smooth(plane.model, plane.used)
    speed = np.hypot(state.x[:, 2], state.x[:, 3])
    early = int(np.searchsorted(grid.time_s - grid.time_s[0], FIRST_BEAT_SHARE / hz))
    steady = float(np.median(speed[len(speed) // 2 :]))
    return bool(speed[min(early, len(speed) - 1)] > MAX_FIRST_SPEED_SHARE * steady)


def _smooth_with_calibrated_gaps(fitted: FittedMotionModel, coords: int) -> SmoothedStates:
    state = filter_and_smooth(fitted.model, fitted.used)
    return with_calibrated_gap_covariance(fitted.model, fitted.used, state, coords)


def _check_enough_frames(pose: Pose) -> None:
    seen = int(np.isfinite(pose.values[:, :3]).all(axis=1).sum())
    if seen < MIN_POSE_FRAMES:
        remedy = "Check the detection of this trial; a longer recording may help."
        raise input_error(
            "pose", "", f"{seen} frames with a pose", f"{MIN_POSE_FRAMES} or more", remedy
        )


def _fitted_models(
    values: Float, cov: Float, grid: FilterTimeGrid, hz: float
) -> HeadingAndPositionModels:
    """Models of heading and position, both at rest in the first frame or both moving.

    If one of the two shows coloured noise, both are tried with it: a steady line with coloured
    noise can pass for a start from rest. The second search starts at the noise of the first.
    """
    speed = rough_speed(values[:, :2], cov[:, :2, :2], grid)
    onset = screen_measurements(values[:, :2], cov[:, :2, :2], grid).onset

    def fit(
        resting: bool, near: HeadingAndPositionModels | tuple[None, None], coloured: Sequence[bool]
    ) -> HeadingAndPositionModels:
        common: dict[str, Any] = {"flap_hz": hz, "resting": resting}
        one, other = ({**common, "near": n, "coloured": c}
                      for n, c in zip(near, coloured, strict=True))  # fmt: skip
        heading = fit_angle(values[:, 2], cov[:, 2, 2], grid, speed=speed, onset=onset, **one)
        turn = compiled_filter_and_smooth(heading.model, heading.used)
        std, rate_std = np.sqrt(turn.P[:, 0, 0]), np.sqrt(turn.P[:, 1, 1])
        known = KnownMotion(turn.x[:, 0], std, rate_std, speed)
        return heading, fit_position(values[:, :2], cov[:, :2, :2], grid, known=known, **other)

    rest = fit(True, (None, None), (False, False))
    too_fast = _speeds_up_too_fast(rest[1], grid, hz)
    unlikely = cost_with_moving_start(rest[1]) - rest[1].cost > MIN_LR_STATISTIC_MOVING_START
    if unlikely and not too_fast:
        return rest
    moving = fit(False, rest, [any(one.coloured for one in rest)] * 2)
    if too_fast:
        return moving
    if any(m.coloured and not r.coloured for m, r in zip(moving, rest, strict=True)):
        rest = fit(True, rest, [one.coloured for one in moving])
    gain = sum(one.cost for one in rest) - sum(one.cost for one in moving)
    return moving if gain > MIN_LR_STATISTIC_MOVING_START else rest


def _smooth_head_angle(
    angle: Float, variance: Float, grid: FilterTimeGrid, hz: float
) -> dict[str, Float]:
    """Head angle by a model of its own; NaN where it is seen in fewer than 8 frames."""
    n = int(grid.frame.sum())
    value, std = np.full(n, np.nan), np.full(n, np.nan)
    if np.isfinite(angle).sum() >= MIN_POSE_FRAMES:
        found = fit_angle(
            angle, variance, grid, speed=np.ones(len(angle)), flap_hz=hz, resting=True
        )
        state = filter_and_smooth(found.model, found.used)
        value, std = state.x[grid.frame, 0], np.sqrt(state.P[grid.frame, 0, 0])
    return {"head_angle_rad": value, "head_angle_rad_std": std}


def _position_track_fields(x: Float, P: Float) -> dict[str, Float]:
    names = {"x_m": x[:, 0], "y_m": x[:, 1]}
    return names | {"x_m_std": np.sqrt(P[:, 0, 0]), "y_m_std": np.sqrt(P[:, 1, 1])}


def _velocity_track_fields(x: Float, P: Float, theta: Float) -> dict[str, Float]:
    """Surge and sway turned into the pool frame, with speed and standard deviations."""
    c, s = np.cos(theta), np.sin(theta)
    turn = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    v = np.einsum("nij,nj->ni", turn, x[:, 2:4])
    C = np.einsum("nij,njk,nlk->nil", turn, P[:, 2:4, 2:4], turn)
    speed, std = speed_and_std(v, C)
    velocity = {"vx_m_s": v[:, 0], "vy_m_s": v[:, 1], "speed_m_s": speed, "speed_m_s_std": std}
    return velocity | {"vx_m_s_std": np.sqrt(C[:, 0, 0]), "vy_m_s_std": np.sqrt(C[:, 1, 1])}


def _recoil_track_fields(
    move: SmoothedStates, turn: SmoothedStates, H: Float, at: BoolNDArray
) -> dict[str, Float]:
    """Recoil at the frames (frames, 3), x, y in the pool frame [m] and heading [rad], and its
    standard deviation.
    """
    C, states = H[at, :, 6:10], slice(6, 10)
    xy = np.einsum("npd,nd->np", C, move.x[at, states])
    variance = np.einsum("npd,nde,npe->np", C, move.P[at, states, states], C)
    std = np.sqrt(np.maximum(np.column_stack([variance, turn.P[at, 3, 3]]), 0.0))  # rounding
    return {"recoil": np.column_stack([xy, turn.x[at, 3]]), "recoil_std": std}


def _smoothing_remarks(
    pose: Pose, grid: FilterTimeGrid, plane: FittedMotionModel, heading: FittedMotionModel
) -> tuple[str, ...]:
    seen = np.asarray(np.isfinite(pose.values[:, :3]).all(axis=1))
    used = (plane.used & heading.used)[grid.frame]
    notes = list(pose.remarks)
    if (~seen).any():
        notes.append(f"{int((~seen).sum())} of {len(seen)} frames without a pose are interpolated")
    if (seen & ~used).any():
        notes.append(f"{int((seen & ~used).sum())} frames rejected as outliers by the smoother")
    return tuple(notes)
