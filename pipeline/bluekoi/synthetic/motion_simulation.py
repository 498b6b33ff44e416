"""Motion of the robot in a pool that obeys known laws: its own equations, solved finely.

Written apart from the analysis (it shares no code with `bluekoi.model`), from the same
published equations, so that an error in either shows as a disagreement.

The state is `(x, y, psi, vx, vy, psi_dot, beat)`: centre of mass (m), heading of the core (rad),
their rates, and the phase of the tail beat (rad).  The head points along `theta = psi - phi`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp

from bluekoi.synthetic.eddies import water_velocity
from bluekoi.synthetic.ground_truth_physics import (
    GroundTruthPhysics,
    MotionRelativeToWater,
    Recoil,
    TrialSettings,
    fin_load,
    head_plate_load,
    thrust,
)


@dataclass(frozen=True)
class TrialMotion:
    """A solved trial: `mean(t)` gives the state without recoil, `pose(t)` with it.

    `duration_s` is the last time solved for; earlier than 0 the robot lies at its start.
    """

    duration_s: float
    dense: Callable[[np.ndarray], np.ndarray]
    head_angle: Callable[[np.ndarray], np.ndarray]
    recoil: Recoil | None

    def state_without_recoil(self, time_s: np.ndarray) -> np.ndarray:
        """State without recoil, `(times, 7)`, of times (s)."""
        return self.dense(np.clip(time_s, 0.0, self.duration_s)).T

    def pose_with_recoil(self, time_s: np.ndarray) -> np.ndarray:
        """Pose with recoil, `(times, 5)`: x, y (m); core heading, head angle, beat (rad)."""
        state = self.state_without_recoil(time_s)
        sway, turn = recoil_motion(self.recoil, time_s, state[:, 6])
        psi = state[:, 2] + turn
        x = state[:, 0] - sway * np.sin(state[:, 2])
        y = state[:, 1] + sway * np.cos(state[:, 2])
        return np.stack([x, y, psi, self.head_angle(time_s), state[:, 6]], axis=1)


def recoil_motion(
    recoil: Recoil | None, time_s: np.ndarray, beat: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sway (m, to the left of the core) and heading (rad) of the recoil, each `(times,)`."""
    if recoil is None:
        return np.zeros_like(beat), np.zeros_like(beat)
    onset = 1 - np.exp(-np.clip(time_s, 0.0, None) / recoil.onset_s)
    sway = recoil.sway_m * onset * np.sin(beat)
    return sway, recoil.heading_rad * onset * np.sin(beat - recoil.lag_rad)


def motion_relative_to_water(
    tank: GroundTruthPhysics, run: TrialSettings, *, time_s: float, state: np.ndarray
) -> MotionRelativeToWater:
    """What the forces depend on at one instant, water motion taken off the velocity."""
    moving = water_velocity(tank.eddies, time_s, complex(state[0], state[1]))
    psi = float(state[2])
    velocity = complex(state[3], state[4]) - moving
    return MotionRelativeToWater(psi, psi - run.head_angle_rad, velocity, float(state[5]))


def state_derivative(
    tank: GroundTruthPhysics, run: TrialSettings, *, time_s: float, state: np.ndarray
) -> list[float]:
    """Time derivative of the state (eq. 8 with whatever the tank adds)."""
    now = motion_relative_to_water(tank, run, time_s=time_s, state=state)
    plate_force, plate_moment = head_plate_load(tank, run, now)
    fin_force, fin_moment = fin_load(tank, now)
    force = thrust(tank, run, now) + plate_force + fin_force
    quadratic = -tank.coefficients.C_Md * now.yaw_rate * abs(now.yaw_rate)
    linear = -tank.yaw_damping_n_m_s * now.yaw_rate
    moment = plate_moment + quadratic + fin_moment + linear
    a = force / tank.robot.mass_kg
    turn = moment / tank.robot.yaw_inertia_kg_m2
    return [state[3], state[4], state[5], a.real, a.imag, turn, 2 * math.pi * run.flap_hz]


def simulate_true_motion(
    tank: GroundTruthPhysics, run: TrialSettings, duration_s: float, *, rtol: float = 1e-9
) -> TrialMotion:
    """The trial from rest at `run.start`, by DOP853 with dense output."""
    start = [*run.start, 0.0, 0.0, 0.0, run.start_beat_rad]
    solution = solve_ivp(
        lambda t, s: state_derivative(tank, run, time_s=t, state=s),
        (0.0, duration_s),
        start,
        method="DOP853",
        rtol=rtol,
        atol=1e-10,
        max_step=0.05,
        dense_output=True,
    )

    def head_angle(time_s: np.ndarray) -> np.ndarray:
        return np.full(np.shape(np.atleast_1d(time_s)), run.head_angle_rad)

    return TrialMotion(duration_s, solution.sol, head_angle, tank.recoil)


def true_steady_speed_and_radius(
    tank: GroundTruthPhysics, run: TrialSettings, *, settle_s: float = 16.0
) -> tuple[float, float]:
    """Speed (m/s) and radius (m, infinite when straight) that the trial tends to in still water."""
    still = replace(tank, eddies=(), pool_m=(1e3, 1e3))
    away = replace(run, start=(500.0, 500.0, 0.0))
    state = simulate_true_motion(still, away, settle_s, rtol=1e-8).state_without_recoil(
        np.array([settle_s])
    )[0]
    speed = math.hypot(state[3], state[4])
    return speed, speed / abs(state[5]) if abs(state[5]) > 1e-6 else math.inf
