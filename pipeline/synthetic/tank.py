"""Motion of the robot in a pool that obeys known laws: its own equations, solved finely.

Written apart from the analysis (it shares no code with `pipeline.model`), from the same
published equations, so that an error in either shows as a disagreement.

Complex numbers stand for vectors of the pool plane (x + i y).  The state is
`(x, y, psi, vx, vy, psi_dot, beat)`: centre of mass (m), heading of the core (rad), their rates,
and the phase of the tail beat (rad).  The head points along `theta = psi - phi`.
"""

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import solve_ivp

from pipeline.synthetic.hidden import Drive, Situation, change_drive, extra_current, extra_load
from pipeline.synthetic.water import Eddy, current

__all__ = [
    "Coefficients",
    "Fin",
    "Motion",
    "Recoil",
    "Robot",
    "Run",
    "Tank",
    "aerodynamic_arm",
    "bare_tank",
    "simulate",
    "steady_turn",
]

STATE_SIZE = 7


@dataclass(frozen=True)
class Robot:
    """The robot's geometry and inertia, SI units (paper, Fig. 2; MODEL.md, audit 2)."""

    mass_kg: float = 0.68
    yaw_inertia_kg_m2: float = 0.0095
    body_length_m: float = 0.331
    head_length_m: float = 0.12
    head_span_m: float = 0.069
    hinge_to_com_m: float = 0.04
    tail_length_m: float = 0.066
    keypoint_depth_m: float = 0.04


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of eqs. 1 to 7: `C_T` (m^2), `C_Ma` (m), `C_Md` (kg m^2), others without unit.

    `C_T` and `C_Md` are Table I's numbers times 10^-3 (MODEL.md, audit 1).
    """

    C_T: float = 4.5e-3
    C_D0: float = 0.5
    C_Da: float = 2.5
    C_La: float = 3.14
    C_Ma: float = 0.1
    C_Md: float = 0.130


@dataclass(frozen=True)
class Fin:
    """The second plate (core and tail) as a fin: area, lever arm behind the centre of mass, slope.

    `Y = -1/2 rho S a u_f w_f` with forward speed `u_f` and sideways speed `w_f` at the fin.
    """

    area_m2: float = 0.0125
    arm_m: float = 0.11
    lift_slope: float = 2.0


@dataclass(frozen=True)
class Recoil:
    """Small oscillation that the beating tail forces on the body: sway (m) and heading (rad)."""

    sway_m: float = 0.003
    heading_rad: float = math.radians(1.5)
    lag_rad: float = 1.2
    onset_s: float = 0.25


@dataclass(frozen=True)
class Tank:
    """All laws that hold in one pool: robot, coefficients, fin, water, recoil, hidden effects."""

    robot: Robot = Robot()
    coefficients: Coefficients = Coefficients()
    fin: Fin | None = Fin()
    recoil: Recoil | None = Recoil()
    eddies: tuple[Eddy, ...] = ()
    hidden: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    density_kg_m3: float = 1000.0
    pool_m: tuple[float, float] = (2.6, 1.6)


@dataclass(frozen=True)
class Run:
    """What the operator sets for one trial, and where the robot starts from rest."""

    flap_hz: float
    head_angle_rad: float
    head_length_m: float
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    start_beat_rad: float = 0.0


@dataclass(frozen=True)
class Motion:
    """A solved trial: `mean(t)` gives the state without recoil, `pose(t)` with it.

    `duration_s` is the last time solved for; earlier than 0 the robot lies at its start.
    """

    duration_s: float
    dense: Callable[[np.ndarray], np.ndarray]
    head_angle: Callable[[np.ndarray], np.ndarray]
    recoil: Recoil | None

    def mean(self, time_s: np.ndarray) -> np.ndarray:
        """State without recoil, `(times, 7)`, of times (s)."""
        return self.dense(np.clip(time_s, 0.0, self.duration_s)).T

    def pose(self, time_s: np.ndarray) -> np.ndarray:
        """Pose with recoil, `(times, 5)`: x, y (m), core heading psi, head angle phi, beat (rad)."""
        state = self.mean(time_s)
        sway, turn = recoil_of(self.recoil, time_s, state[:, 6])
        psi = state[:, 2] + turn
        x = state[:, 0] - sway * np.sin(state[:, 2])
        y = state[:, 1] + sway * np.cos(state[:, 2])
        return np.stack([x, y, psi, self.head_angle(time_s), state[:, 6]], axis=1)


def bare_tank(tank: Tank) -> Tank:
    """The paper's model exactly: no fin, no recoil, still water, nothing hidden."""
    return replace(tank, fin=None, recoil=None, eddies=(), hidden={})


def aerodynamic_arm(robot: Robot, head_length_m: float) -> float:
    """Distance (m) from the centre of mass to the aerodynamic centre: `h + d - (B + h - h1)/4`."""
    body = robot.body_length_m + head_length_m - robot.head_length_m
    return head_length_m + robot.hinge_to_com_m - body / 4


def recoil_of(
    recoil: Recoil | None, time_s: np.ndarray, beat: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sway (m, to the left of the core) and heading (rad) of the recoil, each `(times,)`."""
    if recoil is None:
        return np.zeros_like(beat), np.zeros_like(beat)
    onset = 1 - np.exp(-np.clip(time_s, 0.0, None) / recoil.onset_s)
    sway = recoil.sway_m * onset * np.sin(beat)
    return sway, recoil.heading_rad * onset * np.sin(beat - recoil.lag_rad)


def plate_load(tank: Tank, situation: Situation) -> tuple[complex, float]:
    """Force (N) and yaw moment (N m) on the head plate: eqs. 2 to 8.

    `L = q C_L i v_hat`, `D = -q C_D v_hat`, moment `q C_M + N l`, `N = Re[(L + D) conj(i e^i.theta)]`.
    """
    c, v = tank.coefficients, situation.velocity
    speed = abs(v)
    if speed == 0:
        return 0j, 0.0
    two_alpha = 2 * (situation.theta - cmath.phase(v))
    q = 0.5 * tank.density_kg_m3 * situation.plate_area_m2 * speed**2
    lift = q * c.C_La * math.sin(two_alpha) * situation.lift_gain * 1j * v / speed
    drag = -q * (c.C_D0 + c.C_Da * (1 - math.cos(two_alpha))) * v / speed
    normal = ((lift + drag) * (1j * cmath.exp(1j * situation.theta)).conjugate()).real
    return lift + drag, q * c.C_Ma * math.sin(two_alpha) + normal * situation.arm_m


def fin_load(tank: Tank, situation: Situation) -> tuple[complex, float]:
    """Force (N) and yaw moment (N m) of the second plate: `Y = -1/2 rho S a u_f w_f`, at `-arm`."""
    if tank.fin is None:
        return 0j, 0.0
    axis = cmath.exp(1j * situation.psi)
    along = (situation.velocity * axis.conjugate()).real
    sideways = (situation.velocity * axis.conjugate()).imag - tank.fin.arm_m * situation.yaw_rate
    slope = 0.5 * tank.density_kg_m3 * tank.fin.area_m2 * tank.fin.lift_slope
    side_force = -slope * abs(along) * sideways
    return side_force * 1j * axis, -tank.fin.arm_m * side_force


def thrust(tank: Tank, drive: Drive, situation: Situation) -> complex:
    """Thrust (N), eq. 1: `C_T 1/2 rho A f^2` along the core, through the centre of mass."""
    size = 0.5 * tank.density_kg_m3 * situation.plate_area_m2 * drive.flap_hz**2
    return tank.coefficients.C_T * size * drive.thrust_gain * cmath.exp(1j * situation.psi)


def situation_of(tank: Tank, run: Run, *, time_s: float, state: np.ndarray) -> Situation:
    """What the laws of force see at one instant, water motion taken off the velocity."""
    place = complex(state[0], state[1])
    drive = change_drive(tank.hidden, time_s, Drive(run.flap_hz, run.head_angle_rad))
    moving = current(tank.eddies, time_s, place) + extra_current(tank.hidden, time_s, place)
    return Situation(
        time_s=time_s,
        place=place,
        psi=float(state[2]),
        theta=float(state[2]) - drive.head_angle_rad,
        velocity=complex(state[3], state[4]) - moving,
        yaw_rate=float(state[5]),
        plate_area_m2=run.head_length_m * tank.robot.head_span_m,
        arm_m=aerodynamic_arm(tank.robot, run.head_length_m),
        drive=drive,
        pool_m=tank.pool_m,
        density_kg_m3=tank.density_kg_m3,
    )


def rates(tank: Tank, run: Run, *, time_s: float, state: np.ndarray) -> list[float]:
    """Time derivative of the state (eq. 8 with whatever the tank adds)."""
    now = situation_of(tank, run, time_s=time_s, state=state)
    hidden_force, hidden_moment, now = extra_load(tank.hidden, now)
    plate_force, plate_moment = plate_load(tank, now)
    fin_force, fin_moment = fin_load(tank, now)
    force = thrust(tank, now.drive, now) * now.thrust_gain + plate_force + fin_force + hidden_force
    damping = -tank.coefficients.C_Md * now.yaw_rate * abs(now.yaw_rate)
    moment = plate_moment + damping + fin_moment + hidden_moment
    a = force / tank.robot.mass_kg
    turn = moment / tank.robot.yaw_inertia_kg_m2
    beat = 2 * math.pi * now.drive.flap_hz
    return [state[3], state[4], state[5], a.real, a.imag, turn, beat]


def simulate(tank: Tank, run: Run, duration_s: float, *, rtol: float = 1e-9) -> Motion:
    """The trial from rest at `run.start`, by DOP853 with dense output."""
    start = [*run.start, 0.0, 0.0, 0.0, run.start_beat_rad]
    solution = solve_ivp(
        lambda t, s: rates(tank, run, time_s=t, state=s),
        (0.0, duration_s),
        start,
        method="DOP853",
        rtol=rtol,
        atol=1e-10,
        max_step=0.05,
        dense_output=True,
    )

    def head_angle(time_s: np.ndarray) -> np.ndarray:
        rest = Drive(run.flap_hz, run.head_angle_rad)
        at = np.clip(np.atleast_1d(time_s), 0.0, duration_s)
        return np.array([change_drive(tank.hidden, t, rest).head_angle_rad for t in at])

    return Motion(duration_s, solution.sol, head_angle, tank.recoil)


def steady_turn(tank: Tank, run: Run, *, settle_s: float = 25.0) -> tuple[float, float]:
    """Speed (m/s) and radius (m, infinite when straight) that the trial tends to in still water."""
    still = replace(tank, eddies=(), pool_m=(1e3, 1e3))
    away = replace(run, start=(500.0, 500.0, 0.0))
    state = simulate(still, away, settle_s, rtol=1e-8).mean(np.array([settle_s]))[0]
    speed = math.hypot(state[3], state[4])
    return speed, speed / abs(state[5]) if abs(state[5]) > 1e-6 else math.inf
