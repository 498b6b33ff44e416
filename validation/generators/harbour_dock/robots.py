"""Robots of 0.2 to 0.8 m: geometry, mass, coefficients of the flat-plate model, tail fin."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator

UNITS = {"C_T": "m^2", "C_La": "1", "C_D0": "1", "C_Da": "1", "C_Ma": "m", "C_Md": "kg m^2"}
COEFFICIENTS = tuple(UNITS)
HALF_RHO = 500.0
"""Half the density of water, kg/m^3."""


@dataclass
class Robot:
    """Dimensions as in study.yaml (m, kg, kg m^2), the six coefficients and the fin.

    speed: straight ahead at full power (m/s); full_flap: its flapping frequency (Hz), which goes
    with power to the `flap_exponent`; fin_strength: kg/m, 0 without a fin; fin_behind: of the fin
    behind the centre of mass (m); fin_critical: strength that just makes straight swimming stable.
    """

    length: float
    head: float
    span: float
    hinge_to_com: float
    tail: float
    depth: float
    mass: float
    inertia: float
    speed: float
    full_flap: float
    flap_exponent: float
    coefficients: dict[str, float] = field(default_factory=dict)
    fin_strength: float = 0.0
    fin_behind: float = 0.0
    fin_critical: float = 0.0

    def arm(self, head: np.ndarray | float) -> np.ndarray | float:
        """Centre of mass to aerodynamic centre (m) for a head length (STUDY.md, Derived)."""
        return head + self.hinge_to_com - (self.length + head - self.head) / 4

    @property
    def com_to_tail(self) -> float:
        """Centre of mass to caudal base, m."""
        return self.length - self.head - self.hinge_to_com

    def study(self) -> dict[str, float]:
        """The robot block of study.yaml."""
        return {
            "mass_kg": self.mass,
            "yaw_inertia_kg_m2": self.inertia,
            "body_length_m": self.length,
            "head_length_m": self.head,
            "head_span_m": self.span,
            "hinge_to_com_m": self.hinge_to_com,
            "tail_length_m": self.tail,
            "keypoint_depth_m": self.depth,
        }


def straight_growth(robot: Robot, strength: float) -> float:
    """Largest real part of the sway-yaw eigenvalues of straight swimming at full speed, 1/s.

    strength: of the fin at `fin_behind`, kg/m.
    """
    u, x, c = robot.speed, robot.fin_behind, robot.coefficients
    q = HALF_RHO * robot.head * robot.span * u**2
    side = 2 * c["C_La"] + c["C_D0"]
    head_force = q * side / u
    head_moment = q * (2 * c["C_Ma"] + float(robot.arm(robot.head)) * side) / u
    fin = strength * u
    matrix = np.array(
        [
            [-(head_force + fin) / robot.mass, fin * x / robot.mass - u],
            [
                (-head_moment + x * strength * u) / robot.inertia,
                -(x**2) * strength * u / robot.inertia,
            ],
        ]
    )
    return float(np.linalg.eigvals(matrix).real.max())


def _significant(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")


def _critical_strength(robot: Robot) -> float:
    """Strength of a fin (kg/m) that just makes straight swimming stable."""
    low, high = 0.0, 1.0
    while straight_growth(robot, high) > 0 and high < 1e4:
        high *= 2
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if straight_growth(robot, middle) > 0 else (low, middle)
    return high


def draw_robot(rng: Generator, fin: bool) -> Robot:
    """A robot; with `fin`, a fin of 1.08 to 3 times the strength that just makes it stable."""
    length = _significant(float(np.exp(rng.uniform(np.log(0.2), np.log(0.8)))), 3)
    mass = 1000.0 * length**3 * rng.uniform(0.014, 0.024)
    robot = Robot(
        length=length,
        head=_significant(length * rng.uniform(0.30, 0.42), 3),
        span=_significant(length * rng.uniform(0.17, 0.25), 3),
        hinge_to_com=_significant(length * rng.uniform(0.08, 0.16), 3),
        tail=_significant(length * rng.uniform(0.15, 0.25), 3),
        depth=_significant(length * rng.uniform(0.10, 0.25), 2),
        mass=_significant(mass),
        inertia=_significant(mass * length**2 * rng.uniform(0.075, 0.13)),
        speed=min(length * rng.uniform(0.7, 1.5), 0.75),
        full_flap=float(rng.uniform(3.0, 6.0) * (0.33 / length) ** 0.6),
        flap_exponent=float(rng.uniform(0.8, 1.25)),
    )
    straight_drag = rng.uniform(0.35, 0.75)
    drawn = {
        "C_T": straight_drag * (robot.speed / robot.full_flap) ** 2,
        "C_La": rng.uniform(1.8, 3.6),
        "C_D0": straight_drag,
        "C_Da": rng.uniform(0.4, 3.0),
        "C_Ma": rng.uniform(0.12, 0.36) * length,
        "C_Md": rng.uniform(0.022, 0.05) * 1000 * length**5,
    }
    robot.coefficients = {k: _significant(float(v), 5) for k, v in drawn.items()}
    c = robot.coefficients
    robot.speed = robot.full_flap * float(np.sqrt(c["C_T"] / c["C_D0"]))
    if fin:
        robot.fin_behind = (robot.com_to_tail + robot.tail * rng.uniform(0.0, 0.6)) * rng.uniform(
            0.75, 1.0)  # fmt: skip
        robot.fin_critical = _critical_strength(robot)
        over_critical = float(np.exp(rng.uniform(np.log(1.08), np.log(3.0))))
        robot.fin_strength = robot.fin_critical * over_critical
    return robot
