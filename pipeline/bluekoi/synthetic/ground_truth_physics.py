"""The laws of a tank: robot, coefficients, fin, and the forces that eqs. 1 to 8 make of them.

Complex numbers stand for vectors of the pool plane (x + i y).
"""

import cmath
import math
from dataclasses import dataclass, replace

from bluekoi.synthetic.eddies import Eddy


@dataclass(frozen=True)
class Robot:
    """The robot's geometry and inertia, SI units (paper, Fig. 2; docs/paper.md, Audit)."""

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
    """Coefficients of eqs. 1 to 7, with the paper's symbols; three have units.

    `C_T` and `C_Md` are Table I's numbers times 10^-3 (docs/paper.md, Audit: Units).
    """

    C_T: float = 4.5e-3
    """Thrust, m^2."""
    C_D0: float = 0.5
    """Drag at zero angle of attack, 1."""
    C_Da: float = 2.5
    """Drag by the angle of attack, 1."""
    C_La: float = 3.14
    """Lift by the angle of attack, 1."""
    C_Ma: float = 0.1
    """Yaw moment by the angle of attack, m."""
    C_Md: float = 0.130
    """Yaw damping, kg m^2."""


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
class GroundTruthPhysics:
    """All laws that hold in one pool.

    yaw_damping_n_m_s: `N_r` of the moment `-N_r r` (N m s), which the published model lacks.
    """

    robot: Robot = Robot()
    coefficients: Coefficients = Coefficients()
    fin: Fin | None = Fin()
    recoil: Recoil | None = Recoil()
    eddies: tuple[Eddy, ...] = ()
    yaw_damping_n_m_s: float = 0.0
    density_kg_m3: float = 1000.0
    pool_m: tuple[float, float] = (2.6, 1.6)


@dataclass(frozen=True)
class MotionRelativeToWater:
    """What the forces depend on: headings of core and head (rad), velocity relative to the water
    (m/s, x + i y), yaw rate (rad/s).
    """

    psi: float
    theta: float
    velocity: complex
    yaw_rate: float


@dataclass(frozen=True)
class TrialSettings:
    """What the operator sets for one trial, and where the robot starts from rest."""

    flap_hz: float
    head_angle_rad: float
    head_length_m: float
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    start_beat_rad: float = 0.0


def published_model_physics(tank: GroundTruthPhysics) -> GroundTruthPhysics:
    """The paper's model exactly: no fin, no recoil, still water, no damping."""
    return replace(tank, fin=None, recoil=None, eddies=(), yaw_damping_n_m_s=0.0)


def aerodynamic_arm(robot: Robot, head_length_m: float) -> float:
    """Distance (m) from the centre of mass to the aerodynamic centre: `h + d - (B + h - h1)/4`."""
    body = robot.body_length_m + head_length_m - robot.head_length_m
    return head_length_m + robot.hinge_to_com_m - body / 4


def head_plate_area(tank: GroundTruthPhysics, run: TrialSettings) -> float:
    """Area (m^2) of the head plate: length times span."""
    return run.head_length_m * tank.robot.head_span_m


def head_plate_load(
    tank: GroundTruthPhysics, run: TrialSettings, situation: MotionRelativeToWater
) -> tuple[complex, float]:
    """Force (N) and yaw moment (N m) on the head plate: eqs. 2 to 8.

    `L = q C_L i v_hat`, `D = -q C_D v_hat`, moment `q C_M + N l`,
    `N = Re[(L + D) conj(i e^(i theta))]`.
    """
    c, v = tank.coefficients, situation.velocity
    speed = abs(v)
    if speed == 0:
        return 0j, 0.0
    two_alpha = 2 * (situation.theta - cmath.phase(v))
    q = 0.5 * tank.density_kg_m3 * head_plate_area(tank, run) * speed**2
    lift = q * c.C_La * math.sin(two_alpha) * 1j * v / speed
    drag = -q * (c.C_D0 + c.C_Da * (1 - math.cos(two_alpha))) * v / speed
    normal = ((lift + drag) * (1j * cmath.exp(1j * situation.theta)).conjugate()).real
    arm = aerodynamic_arm(tank.robot, run.head_length_m)
    return lift + drag, q * c.C_Ma * math.sin(two_alpha) + normal * arm


def fin_load(tank: GroundTruthPhysics, situation: MotionRelativeToWater) -> tuple[complex, float]:
    """Force (N) and yaw moment (N m) of the second plate: `Y = -1/2 rho S a u_f w_f`, at `-arm`."""
    if tank.fin is None:
        return 0j, 0.0
    axis = cmath.exp(1j * situation.psi)
    along = (situation.velocity * axis.conjugate()).real
    sideways = (situation.velocity * axis.conjugate()).imag - tank.fin.arm_m * situation.yaw_rate
    slope = 0.5 * tank.density_kg_m3 * tank.fin.area_m2 * tank.fin.lift_slope
    side_force = -slope * abs(along) * sideways
    return side_force * 1j * axis, -tank.fin.arm_m * side_force


def thrust(
    tank: GroundTruthPhysics, run: TrialSettings, situation: MotionRelativeToWater
) -> complex:
    """Thrust (N), eq. 1: `C_T 1/2 rho A f^2` along the core, through the centre of mass."""
    size = 0.5 * tank.density_kg_m3 * head_plate_area(tank, run) * run.flap_hz**2
    return tank.coefficients.C_T * size * cmath.exp(1j * situation.psi)
