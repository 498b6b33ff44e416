"""Robots of the fleet: geometry, inertia, coefficients of the published model.

Lengths follow the body length L, masses the displaced volume of an elliptic section, yaw inertias
a radius of gyration, and coefficients the scaling of the published ones (MODEL.md): C_T in m2,
C_Ma in m and C_Md in kg m2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WATER_DENSITY = 1000.0
"""kg/m3."""
COEFFICIENTS = ("C_T", "C_La", "C_D0", "C_Da", "C_Ma", "C_Md")
COEFFICIENT_UNITS = ("m2", "1", "1", "1", "m", "kg m2")
SHORTEST_ARM = 0.12
"""Least distance from the centre of mass to the aerodynamic centre, in body lengths."""


@dataclass(frozen=True)
class Fin:
    """Core and tail as a fin: lifting area (m2), its distance behind the centre of mass (m).

    slope: normal force coefficient per radian. chord: extent along the core (m).
    """

    form: str
    area: float
    arm: float
    slope: float
    chord: float


@dataclass(frozen=True)
class Robot:
    """A robot in SI units.

    coefficients: C_T, C_La, C_D0, C_Da, C_Ma, C_Md. flap: frequency at full power (Hz). speed:
    straight speed at full power (m/s). recoil: amplitude of the heading at the tail beat (rad).
    """

    body_length: float
    head_length: float
    head_span: float
    hinge_to_com: float
    tail_length: float
    width: float
    mass: float
    inertia: float
    keypoint_depth: float
    coefficients: Array
    flap: float
    speed: float
    recoil: float
    tail_swing: float
    fin: Fin | None = None

    @property
    def aft_length(self) -> float:
        """Centre of mass to caudal base (m)."""
        return self.body_length - self.head_length - self.hinge_to_com

    @property
    def head_area(self) -> float:
        """Area of the 1x head plate (m2)."""
        return self.head_length * self.head_span

    @property
    def cruise_drag(self) -> float:
        """Drag of straight swimming at full power (N)."""
        pressure = 0.5 * WATER_DENSITY * self.speed**2
        return float(pressure * self.head_area * self.coefficients[2])

    @property
    def body_time(self) -> float:
        """Time to swim a body length at full power (s)."""
        return self.body_length / self.speed

    def arm(self, head: Array) -> Array:
        """Centre of mass to aerodynamic centre (m) for head lengths (m)."""
        whole = self.body_length + head - self.head_length
        return head + self.hinge_to_com - whole / 4


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot of 0.2 to 1.2 m, slender or bulky, without a fin."""
    length = float(np.exp(rng.uniform(np.log(0.2), np.log(1.2))))
    head, behind = _draw_fore_body(rng)
    span, width, density = _draw_section(rng)
    mass = density * length**3
    gyration = rng.uniform(0.26, 0.36) * length
    speed = length * float(np.exp(rng.uniform(np.log(0.7), np.log(1.5))))
    flap = speed / length * rng.uniform(1.5, 3.2)
    robot = Robot(
        body_length=length, head_length=head * length, head_span=span * length,
        hinge_to_com=behind * length, tail_length=rng.uniform(0.14, 0.3) * length,
        width=width * length, mass=float(mass), inertia=float(mass * gyration**2),
        keypoint_depth=rng.uniform(0.06, 0.2) * length, coefficients=np.zeros(6),
        flap=flap, speed=speed, recoil=float(np.radians(rng.uniform(0.6, 3.2))),
        tail_swing=float(np.radians(rng.uniform(16, 32))),
    )  # fmt: skip
    return _rounded(robot, _draw_coefficients(rng, robot))


def _draw_fore_body(rng: np.random.Generator) -> tuple[float, float]:
    """Head length and hinge to centre of mass in body lengths, with a sufficient arm."""
    while True:
        head, behind = rng.uniform(0.26, 0.44), rng.uniform(0.06, 0.17)
        if head + behind - 0.25 > SHORTEST_ARM:
            return head, behind


def _draw_section(rng: np.random.Generator) -> tuple[float, float, float]:
    """Span and width in body lengths, and mass over the cubed length (kg/m3).

    Bodies lighter than 0.008 rho L^3 are drawn again: they could not hold battery and motors.
    """
    while True:
        span = rng.uniform(0.14, 0.27)
        width = span * rng.uniform(0.5, 0.95)
        mass = WATER_DENSITY * rng.uniform(0.52, 0.7) * np.pi / 4 * span * width
        if mass > 0.008 * WATER_DENSITY:
            return span, width, mass


def _draw_coefficients(rng: np.random.Generator, robot: Robot) -> Array:
    """Coefficients of the published model; C_T gives the drawn speed.

    Lift lies between that of a plate of low aspect ratio with rounded edges, whose span is that of
    the body's fins, and the published value, pi; damping is that of a beam that turns broadside.
    """
    lift = float(np.exp(rng.uniform(np.log(1.1), np.log(3.4))))
    drag = rng.uniform(0.25, 0.65)
    plan = robot.head_span / robot.body_length / 0.21
    damping = WATER_DENSITY * robot.body_length**5 * rng.uniform(0.014, 0.04) * plan
    moment = robot.body_length * rng.uniform(0.03, 0.28)
    thrust = drag * (robot.speed / robot.flap) ** 2
    return np.array([thrust, lift, drag, rng.uniform(0.4, 3.0), moment, damping])


def _rounded(robot: Robot, coefficients: Array) -> Robot:
    """The robot with its lengths, mass and inertia as they are written in study.yaml."""
    lengths = ("body_length", "head_length", "head_span", "hinge_to_com", "tail_length",
               "keypoint_depth")  # fmt: skip
    values = {**robot.__dict__, "coefficients": coefficients}
    values |= {name: round(values[name], 4) for name in lengths}
    values |= {name: float(f"{values[name]:.4g}") for name in ("mass", "inertia")}
    return Robot(**values)
