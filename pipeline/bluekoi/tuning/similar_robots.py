"""Trials, noise and model in the units of their robot (`model.similarity`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Float
from ..fitting import Noise, TrialSeries, block_averaged
from ..fitting.block_average import DEFAULT_BLOCK_RATE_HZ, PARABOLA_HALF_WINDOW_S
from ..integrate import CompiledSystem, compile_system
from ..model import RobotScaleRatios, robot_scale_ratios_of_trial, trial_system

HEAD_ANGLE_COLUMN = 3
"""Column of the head angle among the observations."""
RANDOM_STATE_UNITS = ("N", "N", "N m", "m", "m", "rad", "m/s", "m/s")
"""Units of the random forces, the tracking errors and the random current, in the order of
`Noise.disturbance`."""
STATE_UNITS = ("m", "m", "rad", "m/s", "m/s", "rad/s")
"""Units of the states of the motion."""


def robot_units_of_trials(series: Sequence[TrialSeries]) -> RobotScaleRatios:
    """Units of the robot in these trials."""
    return robot_scale_ratios_of_trial(series[0].constants)


def compiled_trial_system(series: Sequence[TrialSeries]) -> CompiledSystem:
    """The model with the starts, bounds and plausible magnitudes of the robot in these trials."""
    return compile_system(trial_system(series[0].constants))


def noise_scaled_to_robot(units: RobotScaleRatios, noise: Noise) -> Noise:
    """The noise of the published robot for a similar one."""
    own = RANDOM_STATE_UNITS[: len(noise.disturbance)]
    size = np.array([units.scale_ratio_for_unit(unit) for unit in own])
    return replace(noise, disturbance=noise.disturbance * size, tau=noise.tau * units.time)


def state_std_scaled_to_robot(units: RobotScaleRatios, std: Float) -> Float:
    """Standard deviations (6,) of the states of the published robot for a similar one."""
    return std * np.array([units.scale_ratio_for_unit(unit) for unit in STATE_UNITS])


def downsampled(
    series: Sequence[TrialSeries], rate_hz: float = DEFAULT_BLOCK_RATE_HZ, *,
    constant: Sequence[int] = (HEAD_ANGLE_COLUMN,),
) -> list[TrialSeries]:  # fmt: skip
    """The trials as fits take them: about `rate_hz` observations in the unit of time of the robot.

    constant: observations that count once a trial (`block_averaged`).
    """
    if not series:
        return []
    unit = robot_units_of_trials(series).time
    return [block_averaged(s, rate_hz / unit, constant=constant,
                           half_window_s=PARABOLA_HALF_WINDOW_S * unit)
            for s in series]  # fmt: skip
