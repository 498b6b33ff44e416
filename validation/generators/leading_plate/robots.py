"""Robots: dimensions, mass, six coefficients and, for half of them, a fin that stabilises yaw."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WATER_DENSITY = 1000.0
COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")
COEFFICIENT_UNITS = ("m2", "1", "1", "1", "m", "kg m2")
FIN_FORMS = ("forward_speed", "total_speed", "vortex", "stalling", "trailing_strip")


@dataclass(frozen=True)
class Fin:
    """Core and tail as a fin. strength: half of density times area times slope (kg/m)."""

    form: str
    strength: float
    arm: float


@dataclass(frozen=True)
class Robot:
    """A robot with the standard head.

    speed: straight speed at full power (m/s); flap: tail beats per second there; recoil: swing of
    the heading with the tail beat (rad). The coefficients are in the order of `COEFFICIENTS`.
    """

    mass: float
    inertia: float
    body_length: float
    head_length: float
    head_span: float
    hinge_to_com: float
    tail_length: float
    coefficients: Array = field(repr=False)
    speed: float
    flap: float
    recoil: float
    fin: Fin | None = None

    @property
    def drag(self) -> float:
        """Drag at `speed`, straight ahead (N)."""
        area = self.head_length * self.head_span
        return 0.5 * WATER_DENSITY * area * float(self.coefficients[1]) * self.speed**2

    @property
    def core_length(self) -> float:
        """From the centre of mass to the base of the tail."""
        return self.body_length - self.head_length - self.hinge_to_com

    def arm(self, head: Array) -> Array:
        """From the centre of mass forward to the aerodynamic centre, along the head plate."""
        body = self.body_length + head - self.head_length
        return head + self.hinge_to_com - body / 4


def draw_robot(rng: np.random.Generator) -> Robot:
    """A relative of the paper's robot, 0.8 to 1.4 times as long."""
    scale = rng.uniform(0.8, 1.4)

    def about(value: float, low: float, high: float, power: int = 0) -> float:
        return float(f"{value * scale**power * rng.uniform(low, high):.4g}")

    drag, flap, speed = about(0.5, 0.8, 1.35), rng.uniform(3.0, 6.0), rng.uniform(0.27, 0.47)
    coefficients = np.array([
        drag * (speed / flap) ** 2, drag, rng.uniform(0.8, 3.6), about(3.14, 0.75, 1.15),
        about(0.1, 0.5, 1.2, 1), about(0.122, 0.8, 1.2, 5),
    ])  # fmt: skip
    return Robot(
        mass=about(0.68, 0.85, 1.2, 3), inertia=about(0.0095, 0.85, 1.2, 5),
        body_length=about(0.331, 0.97, 1.03, 1), head_length=about(0.12, 0.9, 1.1, 1),
        head_span=about(0.069, 0.9, 1.15, 1), hinge_to_com=about(0.04, 0.8, 1.3, 1),
        tail_length=about(0.066, 0.9, 1.15, 1), coefficients=coefficients, speed=speed, flap=flap,
        recoil=np.radians(rng.uniform(0.7, 2.5)),
    )  # fmt: skip


def straight_growth(robot: Robot, fin: Fin | None) -> float:
    """Largest growth rate of a small disturbance of straight swimming at `speed` (1/s).

    The sideways and yaw equations of MODEL.md about alpha = 0, differentiated by hand.
    """
    area = robot.head_length * robot.head_span
    _, drag, _, lift, moment, _ = robot.coefficients
    push = 0.5 * WATER_DENSITY * area * robot.speed
    side = -push * (2 * lift + drag)
    arm = float(robot.arm(np.array(robot.head_length)))
    matrix = np.array([[side, 0.0], [side * arm - 2 * push * moment, 0.0]])
    if fin:
        strength = fin.strength * robot.speed
        matrix += strength * np.array([[-1, fin.arm], [fin.arm, -(fin.arm**2)]])
    matrix /= np.array([[robot.mass], [robot.inertia]])
    matrix[0, 1] -= robot.speed
    return float(np.linalg.eigvals(matrix).real.max())


def draw_fin(rng: np.random.Generator, robot: Robot) -> Fin | None:
    """A fin that damps straight swimming by a drawn margin; None where no likely area does."""
    arm = robot.core_length + rng.uniform(0.1, 0.8) * robot.tail_length
    margin = -np.exp(rng.uniform(*np.log([0.03, 0.6]))) * robot.speed / robot.body_length
    form = str(rng.choice(FIN_FORMS))
    areas = np.geomspace(0.05, 3.0, 60) * robot.head_length * robot.head_span
    for area in areas:
        fin = Fin(form, 0.5 * WATER_DENSITY * area * 3.0, arm)
        if straight_growth(robot, fin) < margin:
            return fin
    return None


def fin_side_force(fin: Fin, strength: Array, along: Array, across: Array) -> Array:
    """Force on the fin to port, from the flow speeds of its centre along and across the core."""
    speed = np.sqrt(along**2 + across**2 + 1e-12)
    if fin.form == "total_speed":
        flow = speed * across
    elif fin.form == "vortex":  # Polhamus: potential and vortex lift of a low aspect ratio
        flow = np.abs(along) * across * np.abs(along) / speed + 0.9 * across * np.abs(across)
    elif fin.form == "stalling":
        flow = np.abs(along) * across / (1 + (across / (0.45 * speed)) ** 4)
    elif fin.form == "trailing_strip":  # slender body: what the trailing edge sheds, forward only
        flow = np.maximum(along, 0.0) * across * (1 + 0.5 * (across / speed) ** 2)
    else:
        flow = np.abs(along) * across
    return -strength * flow
