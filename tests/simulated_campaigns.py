"""Campaigns simulated from known coefficients, measured with lasting errors, recoil and disturbed
water, and taken through smoothing to what the fit sees.

Sixteen campaigns of one plan are simulated at once, a campaign a lane.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from bluekoi.data import FlappingFrequency, Float, Pose
from bluekoi.engine import CauseSearchProblem
from bluekoi.fitting import TrialSeries
from bluekoi.integrate import LANES, compile_system
from bluekoi.integrate.batch import simulate_batch
from bluekoi.mismatch.robot_problem import robot_cause_search_problem
from bluekoi.model import (
    PUBLISHED_FLAP_HZ,
    TABLE_1,
    constants_of_robot_trial,
    two_plate_system,
)
from bluekoi.smoothing import smooth_pose
from bluekoi.study import Trial
from bluekoi.tuning import (
    downsampled,
    downsampled_with_head_angle_changes,
    fit_all_trials,
    trial_series,
)
from paper_robot import PAPER_SETUP

FPS = 30.0
DURATION_S = {50: 6.0, 75: 5.0, 100: 4.0}
HEAD_SETTINGS = (
    (0.0, 0.12),
    (30.0, 0.12),
    (-30.0, 0.12),
    (45.0, 0.12),
    (-45.0, 0.12),
    (45.0, 0.175),
)
COEFFICIENTS = dict(TABLE_1[75])


@dataclass(frozen=True)
class ErrorModel:
    """What is random: standard deviations, and the times [s] within which they are forgotten.

    push: forces (N, N, N m) of the water. white, slow: tracking errors of x, y (m), heading and
    head angle (rad). servo: head angle from trial to trial (rad). sway, swing: the tail beat's
    recoil (m, rad). stated_ratio: stated over true standard deviation of the tracking errors.
    """

    push: tuple[float, float, float] = (2e-3, 2e-3, 2e-4)
    push_s: float = 0.5
    white: tuple[float, ...] = (4e-4, 4e-4, 4e-3, 6e-3)
    slow: tuple[float, ...] = (4e-4, 4e-4, 3e-3, 3e-3)
    slow_s: float = 0.15
    servo: float = 5e-3
    sway: float = 3e-3
    swing: float = np.radians(1.5)
    stated_ratio: float = 1.0


@dataclass(frozen=True)
class TrialPlan:
    """One trial of a campaign."""

    name: str
    power: int
    angle_deg: float
    head_length_m: float
    values: Mapping[str, float] = field(default_factory=lambda: COEFFICIENTS)


def trial_plans(
    powers: Sequence[int] = (50, 75, 100), turns: Sequence[tuple[float, float]] = HEAD_SETTINGS
) -> list[TrialPlan]:
    """A trial for every power and every (head angle, head length)."""
    return [
        TrialPlan(f"P{power}N{i}", power, angle, length)
        for power in powers
        for i, (angle, length) in enumerate(turns)
    ]


def simulate_campaigns(
    wanted: Sequence[TrialPlan], errors: ErrorModel, rng: np.random.Generator, *, count: int = LANES
) -> list[list[TrialSeries]]:
    """Series of `count` (up to 16) campaigns of these plans."""
    paths = _simulated_paths(wanted, errors, rng)
    return [
        [_measured_series(plan, path[:, :, lane], errors, rng)
         for plan, path in zip(wanted, paths, strict=True)]
        for lane in range(count)
    ]  # fmt: skip


def simulated_search_problem(rng: np.random.Generator) -> CauseSearchProblem:
    """The search for causes in six simulated trials that begin at rest, at one motor power."""
    series = simulate_campaigns(trial_plans(powers=(75,)), ErrorModel(), rng, count=1)[0]
    return robot_cause_search_problem(
        compile_system(two_plate_system()), downsampled_with_head_angle_changes(series, 5.0),
        fit_all_trials(downsampled(series)), displaced=(), progress=lambda _: None,
    )  # fmt: skip


def _simulated_paths(
    wanted: Sequence[TrialPlan], errors: ErrorModel, rng: np.random.Generator
) -> list[Float]:
    """True states (frames, 6 + head angle error, 16) of every plan, from rest, pushed about."""
    system, kernel = two_plate_system(), compile_system(two_plate_system())
    memory = dict.fromkeys(("tau_surge", "tau_sway", "tau_yaw"), errors.push_s)
    random = {"disturbance": {"present": 1.0, **memory}}
    count = len(wanted)
    values = np.stack(
        [
            np.repeat(system.parameter_vector(p.values, random)[:, None], LANES, axis=1)
            for p in wanted
        ]
    )
    servo = errors.servo * rng.standard_normal((count, LANES))
    values[:, system.parameter_index["servo_error.angle"]] = servo
    fixed = np.stack(
        [
            np.repeat(
                constants_of_robot_trial(PAPER_SETUP, p.head_length_m)[:, None], LANES, axis=1
            )
            for p in wanted
        ]
    )
    inputs = np.array([[np.radians(p.angle_deg), PUBLISHED_FLAP_HZ[p.power]] for p in wanted])
    state = np.zeros((count, len(system.all_states), LANES))
    state[:, 0], state[:, 1] = 1.3, 0.8
    push = np.array(errors.push)[:, None]
    state[:, 6:9] = push * rng.standard_normal((count, 3, LANES))
    keep = np.exp(-1 / (FPS * errors.push_s))
    frames = [state]
    for _ in range(round(max(DURATION_S.values()) * FPS)):
        _, after = simulate_batch(
            kernel, frames[-1], values, fixed, times=np.tile([0.0, 1 / FPS], (count, 1)),
            inputs=np.repeat(inputs[:, None], 2, axis=1), keep_states=True,
        )  # fmt: skip
        new = after[:, 1].copy()
        new[:, 6:9] += np.sqrt(1 - keep**2) * push * rng.standard_normal((count, 3, LANES))
        frames.append(new)
    every = np.stack(frames, axis=1)
    every[:, :, 6] = servo[:, None]
    return [every[i, : round(DURATION_S[p.power] * FPS) + 1, :7] for i, p in enumerate(wanted)]


def _measured_series(
    plan: TrialPlan, path: Float, errors: ErrorModel, rng: np.random.Generator
) -> TrialSeries:
    """One trial as the fit takes it, from its true path (frames, 7)."""
    n, hz = len(path), PUBLISHED_FLAP_HZ[plan.power]
    times = np.arange(n) / FPS
    beat = 2 * np.pi * (hz * times + rng.random())
    rise = 1 - np.exp(-times / 0.25)
    psi = path[:, 2]
    sway = errors.sway * rise * np.sin(beat)
    angle = np.radians(plan.angle_deg)
    truth = np.column_stack([
        path[:, 0] - sway * np.sin(psi), path[:, 1] + sway * np.cos(psi),
        psi + errors.swing * rise * np.sin(beat - 1.2), angle + path[:, 6],
    ])  # fmt: skip
    seen = truth + np.array(errors.white) * rng.standard_normal((n, 4))
    seen += np.array(errors.slow) * autocorrelated_errors(rng, n, errors.slow_s * FPS)
    stated = errors.stated_ratio**2 * (np.square(errors.white) + np.square(errors.slow))
    pose = Pose(times, seen, np.tile(np.diag(stated), (n, 1, 1)))
    trial = Trial(
        trial_id=plan.name,
        source=f"keypoints/{plan.name}.csv",
        power_pct=plan.power,
        head_angle_deg=plan.angle_deg,
        head_length_m=plan.head_length_m,
        fps=FPS,
    )
    return trial_series(
        trial, PAPER_SETUP, pose, smooth_pose(pose, hz), FlappingFrequency(hz, 0.0, "flap_hz")
    )


def autocorrelated_errors(rng: np.random.Generator, n: int, memory: float) -> Float:
    """Errors (n, 4) of unit size that are forgotten within `memory` frames."""
    keep = np.exp(-1 / memory)
    out = rng.standard_normal((n, 4))
    for k in range(1, n):
        out[k] = keep * out[k - 1] + np.sqrt(1 - keep**2) * out[k]
    return out
