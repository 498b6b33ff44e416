"""Simulations of the robot in plain words: a robot, a command, coefficients, and a path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, dataclass
from typing import Protocol

import numpy as np

from ..data import Float
from ..integrate import LANES, compile_system
from ..integrate.batch import MAX_INTEGRATION_STEP_S, repeat_over_lanes, simulate_batch
from ..observation import CameraErrorInputs
from ..study import Pool, Robot, Water
from .similarity import RobotScaleRatios, robot_scale_ratios
from .two_plate_model import DYNAMICS_CONSTANT_NAMES, robot_system, trial_system


@dataclass(frozen=True)
class Simulation:
    """A simulated path.

    - time_s (n,);
    - state (n, 6), as in Eq. 8 of the paper: x, y [m], direction theta of the head [rad], and their
      time derivatives [m/s, rad/s], in pool coordinates;
    - heading_rad (n,): direction of the core.
    """

    time_s: Float
    state: Float
    heading_rad: Float

    @property
    def speed_m_s(self) -> Float:
        """Speed of the centre of mass, (n,)."""
        return np.hypot(self.state[:, 3], self.state[:, 4])


class RobotAndPool(Protocol):
    """What a swim depends on: robot, pool and water. The `StudySettings` of a study is one."""

    @property
    def robot(self) -> Robot:
        """Dimensions and inertia."""

    @property
    def pool(self) -> Pool:
        """Size of the pool."""

    @property
    def water(self) -> Water:
        """Properties of the water."""


def constants_of_robot_trial(
    setup: RobotAndPool, head_length_m: float, *, heading_rad: float = 0.0,
    place_m: tuple[float, float] = (0.0, 0.0), angle_before_rad: float = 0.0, start_s: float = 0.0,
    view: CameraErrorInputs | None = None, units: RobotScaleRatios | None = None,
) -> Float:  # fmt: skip
    """Constants of one trial in the order of `two_plate_system().constants`, (constants,).

    heading_rad, place_m (x and y): at the start. angle_before_rad: head angle of the trial before.
    start_s: when the motor starts. view: how the trial is seen; without, no measurement errors.
    units: of the robot whose effects are simulated, where it is another one.
    """
    robot, pool = setup.robot, setup.pool
    units = units or robot_scale_ratios(robot)
    values = {
        "rho": setup.water.density_kg_m3,
        "A": robot.head_area_m2(head_length_m),
        "A_ref": robot.head_area_m2(robot.head_length_m),
        "l": robot.aerodynamic_arm_m(head_length_m),
        "m": robot.mass_kg,
        "I": robot.yaw_inertia_kg_m2,
        "h": head_length_m,
        "span": robot.head_span_m,
        "length": robot.body_length_m + head_length_m - robot.head_length_m,
        "x_hinge": robot.hinge_to_com_m,
        "x_tail": robot.com_to_tail_base_m,
        "l_tail": robot.tail_length_m,
        "L_pool": pool.length_m,
        "W_pool": pool.width_m,
        "x0": place_m[0],
        "y0": place_m[1],
        "psi0": heading_rad,
        "phi0": angle_before_rad,
        "t_start": start_s,
        "length_unit": units.length,
        "speed_unit": units.speed_ratio,
        "time_unit": units.time,
    }
    return np.array(
        [*(values[name] for name in DYNAMICS_CONSTANT_NAMES), *astuple(view or CameraErrorInputs())]
    )


def simulate(
    coefficients: Mapping[str, float],
    *,
    setup: RobotAndPool,
    head_length_m: float,
    head_angle_rad: float | Float,
    flap_hz: float | Float,
    duration_s: float,
    dt_s: float = MAX_INTEGRATION_STEP_S,
    start: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    effects: Mapping[str, Mapping[str, float]] | None = None,
) -> Simulation:
    """Simulated path of the robot.

    - coefficients: name -> value of the six coefficients, as in `TABLE_1`;
    - setup: the `setup` of a study, with its pool, water and robot;
    - head_angle_rad, flap_hz [Hz]: constants, or arrays with a value for each multiple of `dt_s`;
    - start: x and y in m, heading of the core in rad, surge and sway velocity in m/s, yaw rate in
      rad/s. The result has the heading of the head and velocities in pool coordinates instead;
    - effects: name of a candidate -> parameter -> value ([Candidate causes](effects.md)).

        >>> from bluekoi.model import TABLE_1
        >>> setup = load_study("lab").setup
        >>> path = simulate(
        ...     TABLE_1[100], setup=setup, head_length_m=0.12, head_angle_rad=0.0, flap_hz=5.82,
        ...     duration_s=8.0,
        ... )
        >>> round(float(path.speed_m_s[-1]), 3)
        0.552
    """
    n = round(duration_s / dt_s) + 1
    times: Float = np.arange(n, dtype=np.float64) * dt_s
    inputs: Float = np.column_stack(
        [np.broadcast_to(np.asarray(v, dtype=np.float64), n) for v in (head_angle_rad, flap_hz)]
    )
    return simulate_at_times(
        robot_system(setup.robot).parameter_vector(coefficients, effects),
        times,
        inputs,
        constants_of_robot_trial(
            setup, head_length_m, heading_rad=start[2], place_m=(start[0], start[1])
        ),
        np.array(start, dtype=float),
    )


def simulate_at_times(
    values: Float, times: Float, inputs: Float, trial_constants: Float, start: Float
) -> Simulation:
    """Path at given times for a full parameter vector of the system; start: (6,) or all states."""
    kernel = compile_system(trial_system(trial_constants))
    state = np.zeros((1, len(kernel.system.all_states), LANES))
    state[0, : len(start)] = start[:, None]
    _, states = simulate_batch(
        kernel,
        state,
        repeat_over_lanes(values[None]),
        repeat_over_lanes(trial_constants[None]),
        times=times[None],
        inputs=inputs[None],
        keep_states=True,
    )
    return _in_world_axes(times, states[0, :, :6, 0], inputs[:, 0])


def _in_world_axes(times: Float, body: Float, head_angle: Float) -> Simulation:
    x, y, psi, u, v, r = body.T
    c, s = np.cos(psi), np.sin(psi)
    state = np.column_stack([x, y, psi - head_angle, u * c - v * s, u * s + v * c, r])
    return Simulation(times, state, psi)


def steady_speed_and_radius(
    coefficients: Mapping[str, float],
    *,
    setup: RobotAndPool,
    head_length_m: float,
    head_angle_rad: float,
    flap_hz: float,
    effects: Mapping[str, Mapping[str, float]] | None = None,
    settle_s: float = 40.0,
) -> tuple[float, float]:
    """Speed (m/s) and radius (m, positive; inf for a straight run) after all has settled."""
    run = simulate(
        coefficients,
        setup=setup,
        head_length_m=head_length_m,
        head_angle_rad=head_angle_rad,
        flap_hz=flap_hz,
        duration_s=settle_s,
        effects=effects,
    )
    speed, yaw_rate = float(run.speed_m_s[-1]), abs(float(run.state[-1, 5]))
    return speed, speed / yaw_rate if yaw_rate > 1e-6 else float("inf")
