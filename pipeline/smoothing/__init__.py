"""Smoothed motion of the robot with its rates, the tail-beat recoil taken out of it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ..data import Float, Pose, Track
from ..faults import fault
from .channels import Going, angle_chain, moving_cost, planar_chain
from .course import rough_speed
from .grid import Grid, filter_grid
from .reference import filter_and_smooth
from .search import Found
from .speed import speed_and_std
from .twin import smoothed

LEAST_FRAMES = 8
SURELY_RESTS = 12.0
"""Twice the log likelihood by which one start beats the other beyond doubt; in doubt
the body starts from rest, as trials do."""


def smooth(pose: Pose, flap_hz: float) -> Track:
    """Mean motion of the trial by Kalman filter and smoother; see `motion` for the model.

    Velocities and the yaw rate are states of the filter, the derivative of the smoothed position
    without the recoil. Where nothing was seen the motion is bridged and its uncertainty grows.
    Process noise and the true size of the measurement noise are the most likely ones.

    flap_hz: flapping frequency; 0 or NaN for a body that does not beat. Less than one beat in the
    whole recording is no recoil.
    Raises: Fault where fewer than 8 frames show the robot.
    """
    return with_shown(pose, flap_hz)[0]


def with_shown(pose: Pose, flap_hz: float) -> tuple[Track, tuple[float, float]]:
    """As `smooth`, and what share of the stated variance shows, of positions and heading."""
    _check(pose)
    beats = float(flap_hz) * float(np.ptp(pose.time_s))
    hz = float(flap_hz) if np.isfinite(beats) and beats > 1 else 0.0
    grid = filter_grid(pose.time_s, hz)
    values, cov = grid.on_nodes(pose.values), grid.on_nodes(pose.cov)
    heading, plane = _most_likely(values, cov, grid, hz)
    turn = filter_and_smooth(heading.chain, heading.used)
    theta = turn.x[:, 0]
    move = filter_and_smooth(plane.chain, plane.used)
    at = grid.frame
    track = Track(
        time_s=pose.time_s,
        **_position(move.x[at], move.P[at]),
        **_velocity(move.x[at], move.P[at], theta[at]),
        heading_rad=theta[at],
        heading_rad_std=np.sqrt(turn.P[at, 0, 0]),
        yaw_rate_rad_s=turn.x[at, 1],
        yaw_rate_rad_s_std=np.sqrt(turn.P[at, 1, 1]),
        **_head_angle(values[:, 3], cov[:, 3, 3], grid, hz),
        recoil=_recoil(move.x[at], turn.x[at], plane.chain.H[at]) * (hz > 0),
        remarks=_remarks(pose, grid, plane, heading),
    )
    return track, (plane.shown, heading.shown)


def _check(pose: Pose) -> None:
    seen = int(np.isfinite(pose.values[:, :3]).all(axis=1).sum())
    if seen < LEAST_FRAMES:
        cure = "Check the detection of this trial; a longer recording may help."
        raise fault("pose", "", f"{seen} frames with a pose", f"{LEAST_FRAMES} or more", cure)


def _most_likely(values: Float, cov: Float, grid: Grid, hz: float) -> tuple[Found, Found]:
    """Chains of heading and position, both at rest in the first frame or both moving.

    Both are tried with errors that last where either has them: with such errors a line can pass for
    a start from rest, and without them no line would be as likely.
    """
    speed = rough_speed(values[:, :2], cov[:, :2, :2], grid)

    def tried(resting: bool, lasting: Sequence[bool] = (False, False)) -> tuple[Found, Found]:
        angle = partial(angle_chain, flap_hz=hz, resting=resting, lasting=lasting[0])
        place = partial(planar_chain, flap_hz=hz, resting=resting, lasting=lasting[1])
        heading = angle(values[:, 2], cov[:, 2, 2], grid, speed=speed)
        turn = smoothed(heading.chain, heading.used)
        std, rate_std = np.sqrt(turn.P[:, 0, 0]), np.sqrt(turn.P[:, 1, 1])
        going = Going(turn.x[:, 0], std, rate_std, speed)
        return heading, place(values[:, :2], cov[:, :2, :2], grid, going=going)

    rest = tried(True)
    if moving_cost(rest[1]) - rest[1].cost > SURELY_RESTS:
        return rest
    moving = tried(False, _lasts(rest))
    if any(one and not own for one, own in zip(_lasts(moving), _lasts(rest), strict=True)):
        rest = tried(True, _lasts(moving))
    costs = sum(found.cost for found in rest)
    return moving if sum(found.cost for found in moving) < costs - SURELY_RESTS else rest


def _lasts(both: tuple[Found, Found]) -> tuple[bool, bool]:
    return both[0].lasts, both[1].lasts


def _head_angle(angle: Float, variance: Float, grid: Grid, hz: float) -> dict[str, Float]:
    """Head angle by a chain of its own; NaN where it is seen in fewer than 8 frames."""
    n = int(grid.frame.sum())
    value, std = np.full(n, np.nan), np.full(n, np.nan)
    if np.isfinite(angle).sum() >= LEAST_FRAMES:
        found = angle_chain(
            angle, variance, grid, speed=np.ones(len(angle)), flap_hz=hz, resting=True
        )
        state = filter_and_smooth(found.chain, found.used)
        value, std = state.x[grid.frame, 0], np.sqrt(state.P[grid.frame, 0, 0])
    return {"head_angle_rad": value, "head_angle_rad_std": std}


def _position(x: Float, P: Float) -> dict[str, Float]:
    names = {"x_m": x[:, 0], "y_m": x[:, 1]}
    return names | {"x_m_std": np.sqrt(P[:, 0, 0]), "y_m_std": np.sqrt(P[:, 1, 1])}


def _velocity(x: Float, P: Float, theta: Float) -> dict[str, Float]:
    """Surge and sway turned into the pool frame, with speed and standard deviations."""
    c, s = np.cos(theta), np.sin(theta)
    turn = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    v = np.einsum("nij,nj->ni", turn, x[:, 2:4])
    C = np.einsum("nij,njk,nlk->nil", turn, P[:, 2:4, 2:4], turn)
    speed, std = speed_and_std(v, C)
    velocity = {"vx_m_s": v[:, 0], "vy_m_s": v[:, 1], "speed_m_s": speed, "speed_m_s_std": std}
    return velocity | {"vx_m_s_std": np.sqrt(C[:, 0, 0]), "vy_m_s_std": np.sqrt(C[:, 1, 1])}


def _recoil(move: Float, turn: Float, H: Float) -> Float:
    """Recoil (frames, 3): x, y in the pool frame [m] and heading [rad]."""
    xy = np.einsum("npd,nd->np", H[:, :, 6:10], move[:, 6:10])
    return np.column_stack([xy, turn[:, 3] if turn.shape[1] > 3 else np.zeros(len(turn))])


def _remarks(pose: Pose, grid: Grid, plane: Found, heading: Found) -> tuple[str, ...]:
    seen = np.asarray(np.isfinite(pose.values[:, :3]).all(axis=1))
    used = (plane.used & heading.used)[grid.frame]
    notes = list(pose.remarks)
    if (~seen).any():
        notes.append(f"{int((~seen).sum())} of {len(seen)} frames without a pose are bridged")
    if (seen & ~used).any():
        notes.append(f"{int((seen & ~used).sum())} frames set aside as wrong by the smoother")
    return tuple(notes)
