"""One trial before it is filmed: where it starts, how it moves, and what is true in each frame."""

import math
import zlib
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from bluekoi.synthetic.body import body_point_positions
from bluekoi.synthetic.eddies import random_eddies
from bluekoi.synthetic.encode import GOPRO_FRAME_RATE_HZ
from bluekoi.synthetic.ground_truth_physics import GroundTruthPhysics, TrialSettings
from bluekoi.synthetic.motion_simulation import (
    TrialMotion,
    simulate_true_motion,
    true_steady_speed_and_radius,
)
from bluekoi.synthetic.optics import Camera, displaced_camera, pool_points_to_pixels, resized_camera
from bluekoi.synthetic.synthetic_study_design import StudyDesign, TrialPlan

START_HEADING_COUNT = 72
"""Directions tried for the start of a trial, evenly over the circle."""
WALL_CHECK_STEP_S = 0.05
"""Interval at which a path is checked against the walls."""
STEADY_TRIAL_SHARE = 0.3
"""Last part of a trial, as a share of its duration, over which its true steady state is taken."""
TRUE_PATH_INTERVAL_S = 0.05
"""Interval at which the true path is written."""


@dataclass(frozen=True)
class SolvedTrial:
    """A solved trial: plan, laws, start, motion, and its frame times (s, mid-exposure)."""

    plan: TrialPlan
    tank: GroundTruthPhysics
    run: TrialSettings
    motion: TrialMotion
    time_s: np.ndarray


def trial_rng(design: StudyDesign, trial_id: str, purpose: str) -> np.random.Generator:
    """Random numbers for one purpose in one trial, the same in every run."""
    return np.random.default_rng([design.seed, zlib.crc32(f"{trial_id}/{purpose}".encode())])


def _keypoint_path(
    tank: GroundTruthPhysics, plan: TrialPlan, motion: TrialMotion, until_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """Check times and the keypoints `(times, 5)` at them (x + i y, m)."""
    time_s = np.arange(0, until_s + 1e-9, WALL_CHECK_STEP_S)
    return time_s, body_point_positions(
        tank.robot, plan.head_length_m, motion.pose_with_recoil(time_s)
    )


def _count_leading_frames_inside_rectangle(points: np.ndarray, room: tuple[float, float]) -> int:
    """How many of the first rows of keypoints fit together into a rectangle."""
    wide = np.maximum.accumulate(points.real.max(1)) - np.minimum.accumulate(points.real.min(1))
    high = np.maximum.accumulate(points.imag.max(1)) - np.minimum.accumulate(points.imag.min(1))
    out = np.flatnonzero((wide > room[0]) | (high > room[1]))
    return int(out[0]) if len(out) else len(points)


def _find_start(
    design: StudyDesign, tank: GroundTruthPhysics, plan: TrialPlan, run: TrialSettings
) -> tuple[float, float, float]:
    """A start from which the path stays off the walls for as long as can be."""
    rng = trial_rng(design, plan.trial_id, "start")
    far = replace(tank, eddies=(), pool_m=(1e3, 1e3))
    away = replace(run, start=(500.0, 500.0, 0.0))
    motion = simulate_true_motion(far, away, plan.longest_s, rtol=1e-7)
    points = _keypoint_path(tank, plan, motion, plan.longest_s)[1] - (500 + 500j)
    return start_pose_in_pool(design, tank.pool_m, points, rng)


def start_pose_in_pool(
    design: StudyDesign, pool_m: tuple[float, float], points: np.ndarray, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Start x, y (m), heading (rad) that keeps a path's keypoints `(times, 5)` inside longest."""
    room = tuple(side - 2 * design.wall_margin_m for side in pool_m)
    turns = rng.permutation(np.arange(START_HEADING_COUNT)) * (2 * math.pi / START_HEADING_COUNT)
    fits = [
        _count_leading_frames_inside_rectangle(points * np.exp(1j * turn), (room[0], room[1]))
        for turn in turns
    ]
    best = int(np.argmax(fits))
    kept = (points * np.exp(1j * turns[best]))[: fits[best]]
    place = []
    for side, values in zip(pool_m, (kept.real, kept.imag), strict=True):
        low, high = float(values.min()), float(values.max())
        slack = side - 2 * design.wall_margin_m - (high - low)
        place.append(design.wall_margin_m - low + slack * rng.uniform(0.3, 0.7))
    return place[0], place[1], float(turns[best])


def time_until_wall(
    design: StudyDesign, tank: GroundTruthPhysics, plan: TrialPlan, motion: TrialMotion
) -> float:
    """Time (s) until which every keypoint keeps half the margin to the walls."""
    time_s, points = _keypoint_path(tank, plan, motion, plan.longest_s)
    gap = np.minimum(
        np.minimum(points.real, tank.pool_m[0] - points.real),
        np.minimum(points.imag, tank.pool_m[1] - points.imag),
    ).min(axis=1)
    hit = np.flatnonzero(gap < 0.5 * design.wall_margin_m)
    return float(time_s[hit[0] - 1]) if len(hit) else plan.longest_s


def solve_trial(
    design: StudyDesign, trial_id: str, *, rate: Fraction = GOPRO_FRAME_RATE_HZ
) -> SolvedTrial:
    """The solved trial of a design, from its seed."""
    plan = design.plan_of_trial(trial_id)
    rng = trial_rng(design, trial_id, "motion")
    tank = replace(
        design.tank,
        coefficients=design.coefficients_at.get(plan.power_pct, design.tank.coefficients),
        eddies=random_eddies(rng, design.water_rms_m_s),
    )
    run = TrialSettings(
        flap_hz=design.flap_hz[plan.power_pct] * (1 + design.flap_spread * rng.standard_normal()),
        head_angle_rad=math.radians(plan.head_angle_deg),
        head_length_m=plan.head_length_m,
        start_beat_rad=float(rng.uniform(0, 2 * math.pi)),
    )
    run = replace(run, start=_find_start(design, tank, plan, run))
    motion = simulate_true_motion(tank, run, plan.longest_s)
    frames = int(time_until_wall(design, tank, plan, motion) * rate) + 1
    return SolvedTrial(plan, tank, run, motion, np.arange(frames) / float(rate))


def camera_of_design_at_time(design: StudyDesign, time_s: float) -> Camera:
    """The design's camera at its picture size, before or after it was moved."""
    state = design.conditions
    camera = resized_camera(design.camera, state.size_px)
    if state.view_shift_m:
        x, y, z = camera.centre_m
        camera = replace(camera, centre_m=(x + state.view_shift_m, y, z))
    if state.nudge_at_s is None or time_s < state.nudge_at_s:
        return camera
    turn = (0.6 * state.nudge_deg, -0.5 * state.nudge_deg, 0.6 * state.nudge_deg)
    return displaced_camera(camera, (0.001, -0.0015, 0.0), turn)


def keypoint_pixels(
    design: StudyDesign, trial: SolvedTrial, points: np.ndarray, *, sinking_m_s: float = 0.0
) -> np.ndarray:
    """Pixels `(frames, 5, 2)` of keypoints `(frames, 5)` (x + i y, m) at the keypoint depth."""
    flat = points.ravel()
    deeper = sinking_m_s * np.clip(trial.time_s, 0.0, None)
    depth = trial.tank.robot.keypoint_depth_m + np.repeat(deeper, points.shape[1])
    place = np.column_stack([flat.real, flat.imag, -depth])
    before = pool_points_to_pixels(camera_of_design_at_time(design, -1.0), place).reshape(
        *points.shape, 2
    )
    if design.conditions.nudge_at_s is None:
        return before
    after = pool_points_to_pixels(camera_of_design_at_time(design, math.inf), place).reshape(
        *points.shape, 2
    )
    return np.where((trial.time_s >= design.conditions.nudge_at_s)[:, None, None], after, before)


def frame_truth(design: StudyDesign, trial: SolvedTrial) -> dict[str, np.ndarray]:
    """What is true in each frame: arrays by name, first axis the frames.

    `pose` and `mean` hold x, y (m) and core heading (rad) with and without recoil;
    `velocity` (m/s) and `yaw_rate` (rad/s) are those of the mean motion.
    """
    pose, mean = (
        trial.motion.pose_with_recoil(trial.time_s),
        trial.motion.state_without_recoil(trial.time_s),
    )
    points = body_point_positions(trial.tank.robot, trial.plan.head_length_m, pose)
    return {
        "time_s": trial.time_s,
        "keypoints_px": keypoint_pixels(design, trial, points),
        "keypoints_m": np.stack([points.real, points.imag], axis=-1),
        "pose": pose[:, :3],
        "head_angle_rad": pose[:, 3],
        "beat_rad": pose[:, 4],
        "mean": mean[:, :3],
        "velocity": mean[:, 3:5],
        "yaw_rate": mean[:, 5],
    }


def steady_summary(trial: SolvedTrial) -> dict[str, float | str | None]:
    """Steady figures of a trial: over its last 30 %, and those it tends to in still water.

    Radii (m) are speed over rate of course, None for straight trials.
    """
    end = float(trial.time_s[-1])
    time_s = np.linspace((1 - STEADY_TRIAL_SHARE) * end, end, 400)
    mean = trial.motion.state_without_recoil(time_s)
    speed = np.hypot(mean[:, 3], mean[:, 4])
    course = np.unwrap(np.arctan2(mean[:, 4], mean[:, 3]))
    turn = abs(course[-1] - course[0]) / (time_s[-1] - time_s[0])
    limit_speed, limit_radius = true_steady_speed_and_radius(trial.tank, trial.run)
    turning = trial.plan.head_angle_deg != 0
    return {
        "trial_id": trial.plan.trial_id,
        "duration_s": end,
        "flap_hz": trial.run.flap_hz,
        "steady_from_s": float(time_s[0]),
        "speed_m_s": float(speed.mean()),
        "radius_m": float(speed.mean() / turn) if turning else None,
        "limit_speed_m_s": limit_speed,
        "limit_radius_m": limit_radius if turning and math.isfinite(limit_radius) else None,
    }


def true_path_without_recoil(trial: SolvedTrial) -> dict[str, list[float]]:
    """Mean motion, the tail-beat recoil left out: every 0.05 s place (m) and velocity (m/s)."""
    end = float(trial.time_s[-1])
    time_s = np.append(np.arange(0.0, end, TRUE_PATH_INTERVAL_S), end)
    mean = trial.motion.state_without_recoil(time_s)
    columns = {"x_m": 0, "y_m": 1, "vx_m_s": 3, "vy_m_s": 4}
    values = {name: mean[:, k] for name, k in columns.items()}
    return {k: np.round(v, 6).tolist() for k, v in {"time_s": time_s, **values}.items()}
