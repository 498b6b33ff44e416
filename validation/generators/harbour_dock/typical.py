"""Typical sizes of a study without hidden causes, against which laws are measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .engine import Motion
from .plan import Trials
from .robots import HALF_RHO, Robot


@dataclass
class Typical:
    """Medians over the trials of means over their later half; m, s, rad, N, N m.

    Up to `advance` of all trials, up to `high_attack` of those with a turned head, then of the
    fastest trial, then one value for each trial. pressure: q of the equations (N); advance:
    forward speed over frequency (m); high_attack: the 85 % quantile; turned: range of headings.
    """

    robot: Robot
    trials: Trials
    speed: float
    pressure: float
    thrust: float
    advance: float
    yaw_rate: float
    attack: float
    side_force: float
    moment: float
    sin_head_angle: float
    high_attack: float
    top_speed: float
    top_thrust: float
    speeds: np.ndarray
    rates: np.ndarray
    turned: np.ndarray
    path_length: np.ndarray
    lens_model: str = ""

    @property
    def length(self) -> float:
        """Of the body, m."""
        return self.robot.length

    @property
    def area(self) -> float:
        """Of the head plate, m^2."""
        return float(np.median(self.trials.area))


def _later_half(robot: Robot, trials: Trials, motion: Motion, trial: int) -> list[float]:
    """Means of one trial, in the order that `typical` names."""
    duration, time = trials.duration[trial], motion.time
    late = (time > 0.5 * duration) & (time <= duration)
    velocity = motion.velocity_x[late, 0, trial] + 1j * motion.velocity_y[late, 0, trial]
    theta = motion.theta[:, 0, trial]
    attack = np.angle(np.exp(1j * theta[late]) * np.conj(velocity))
    speed, rate = np.abs(velocity), np.abs(motion.rate[late, 0, trial])
    q = HALF_RHO * trials.area[trial] * speed**2
    c = robot.coefficients
    side = q * c["C_La"] * np.abs(np.sin(2 * attack))
    moment = q * c["C_Ma"] * np.abs(np.sin(2 * attack)) + trials.arm[trial] * side
    thrust = c["C_T"] * HALF_RHO * trials.area[trial] * trials.flap[trial] ** 2
    advance = (speed * np.cos(attack + trials.phi[trial])).mean() / trials.flap[trial]
    return [
        speed.mean(), rate.mean(), np.abs(attack).mean(), q.mean(), thrust, side.mean(),
        moment.mean(), np.sin(abs(trials.phi[trial])), max(advance, 1e-3),
        np.ptp(theta[time <= duration]), speed.mean() * duration,
    ]  # fmt: skip


def typical(robot: Robot, trials: Trials, motion: Motion) -> Typical:
    """From the motion without hidden causes."""
    count = len(trials.duration)
    table = np.array([_later_half(robot, trials, motion, trial) for trial in range(count)])
    turning = table[np.abs(trials.phi) > 0.05]
    middle = [float(value) for value in np.median(table, axis=0)]
    turns = [float(value) for value in np.median(turning, axis=0)]
    return Typical(
        robot, trials,
        speed=middle[0], pressure=middle[3], thrust=middle[4], advance=middle[8],
        yaw_rate=turns[1], attack=turns[2], side_force=turns[5], moment=turns[6],
        sin_head_angle=turns[7], high_attack=float(np.quantile(turning[:, 2], 0.85)),
        top_speed=float(table[:, 0].max()), top_thrust=float(table[:, 4].max()),
        speeds=table[:, 0], rates=table[:, 1], turned=table[:, 9], path_length=table[:, 10],
    )  # fmt: skip
