"""Steady speeds and turn radii of many conditions and many draws of the coefficients at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, compile_system
from ..integrate.batch import repeat_over_lanes, simulate_batch
from ..model import RobotScaleRatios, constants_of_robot_trial, robot_system
from ..study import StudySettings

SETTLE_S, CHECK_S = 30.0, 25.0
"""End of the simulation, and the time at which it is compared with the end."""
STEADY_INTEGRATION_STEP_S = 1 / 30
STEADY_TOLERANCE = 0.005
"""Between `CHECK_S` and `SETTLE_S` speed and yaw rate may change by this share, no more."""
MIN_TURN_RATE_RAD_S = 1e-6
"""Yaw rate below which a path counts as straight."""
MIN_SPEED_M_S = 1e-4
"""Speed below which a change counts as none."""


@dataclass(frozen=True)
class OperatingCondition:
    """What is set: flapping frequency, head angle (core minus head, rad), head length, robot.

    units: of the robot that was fitted, where this one differs from it.
    """

    flap_hz: float
    head_angle_rad: float
    head_length_m: float
    setup: StudySettings
    units: RobotScaleRatios | None = None


@dataclass(frozen=True)
class SteadyStates:
    """speed_m_s, radius_m: (conditions, draws); radius inf for a straight run.

    Both NaN where nothing settles within half a minute.
    """

    speed_m_s: Float
    radius_m: Float


def steady_states(conditions: Sequence[OperatingCondition], values: Float) -> SteadyStates:
    """Steady states from rest, for every condition and every row of `values`.

    values: (draws, parameters), or (conditions, draws, parameters) where conditions have their own.
    """
    count, draws = len(conditions), values.shape[-2]
    own = np.broadcast_to(values, (count, draws, values.shape[-1]))
    parts = -(-draws // LANES)
    padded = np.concatenate([own, np.repeat(own[:, :1], parts * LANES - draws, axis=1)], axis=1)
    lanes = padded.reshape(count * parts, LANES, -1).transpose(0, 2, 1)
    speed, rate = _steady_motion(conditions, lanes, parts)
    speed, rate = (a.reshape(2, count, parts * LANES)[:, :, :draws] for a in (speed, rate))
    change = np.abs(speed[1] - speed[0]) + np.abs(rate[1] - rate[0]) * speed[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        steady = change <= STEADY_TOLERANCE * np.maximum(np.abs(speed[1]), MIN_SPEED_M_S)
        turning = np.abs(rate[1]) > MIN_TURN_RATE_RAD_S
        radius = np.where(turning, speed[1] / np.abs(rate[1]), np.inf)
    return SteadyStates(np.where(steady, speed[1], np.nan), np.where(steady, radius, np.nan))


def _steady_motion(
    conditions: Sequence[OperatingCondition], lanes: Float, parts: int
) -> tuple[Float, Float]:
    """Speed and yaw rate (2, blocks, 16) at `CHECK_S` and `SETTLE_S`."""
    system = robot_system(conditions[0].setup.robot)
    blocks = len(lanes)
    fixed = np.array(
        [constants_of_robot_trial(c.setup, c.head_length_m, units=c.units) for c in conditions]
    )
    inputs = np.array([[c.head_angle_rad, c.flap_hz] for c in conditions])
    _, states = simulate_batch(
        compile_system(system),
        np.zeros((blocks, len(system.all_states), LANES)),
        lanes,
        repeat_over_lanes(np.repeat(fixed, parts, axis=0)),
        times=np.tile([0.0, CHECK_S, SETTLE_S], (blocks, 1)),
        inputs=np.repeat(np.repeat(inputs, parts, axis=0)[:, None], 3, axis=1),
        keep_states=True,
        step_s=system.longest_step_s(STEADY_INTEGRATION_STEP_S),
    )
    u, v, r = (states[:, 1:, i].transpose(1, 0, 2) for i in (3, 4, 5))
    return np.hypot(u, v), r
