"""Random robots: dimensions, inertia, coefficients of the head plate, and the fin of the tail."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .form import HALF_DENSITY, Quantity

FIN_SHAPES = {
    "whicker_fehlner": (0.2, 0.9),
    "saturating": (0.35, 0.7),
    "trailing_edge": (0.5, 0.8),
    "flapping": (0.01, 0.03),
}
"""Range of the shape parameter of each form of a fin (m for `flapping`, rad for `saturating`)."""
PUBLISHED_SHARE = 0.4
"""Share of robots with the published dimensions."""
SLOWEST_DECAY, FASTEST_DECAY = 0.15, 3.0
"""Range of the decay of a disturbance of straight swimming with a fin, 1/s."""
FULL_POWER_FLAP = 5.8
"""Flapping frequency at full power, Hz."""


@dataclass(frozen=True)
class Fin:
    """Core and tail as a fin. area: m2. arm: behind the centre of mass, m. shape: as its form."""

    form: str
    shape: float
    arm: float
    area: float


@dataclass(frozen=True)
class Robot:
    """A robot in SI units. coefficients: the paper's six, C_T and C_Md already times 10^-3."""

    mass: float
    inertia: float
    body_length: float
    head_length: float
    head_span: float
    hinge_to_com: float
    tail_length: float
    keypoint_depth: float
    coefficients: Mapping[str, float]
    fin: Fin | None = None

    def arm(self, head: Quantity) -> Quantity:
        """From the centre of mass to the aerodynamic centre, m: h + a - (L + h - h_1) / 4."""
        return head + self.hinge_to_com - (self.body_length + head - self.head_length) / 4

    def tail_reach(self) -> float:
        """From the centre of mass back to the tip of the tail, m."""
        return self.body_length - self.head_length - self.hinge_to_com + self.tail_length


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot with the published dimensions or with scaled ones.

    The mass goes as L^3, C_T as L^2, C_Ma as L and C_Md as L^5.
    """
    if rng.random() < PUBLISHED_SHARE:
        length, head, span, offset, tail = 0.331, 0.12, 0.069, 0.04, 0.066
        mass, inertia = 0.68, 0.0095
    else:
        length = rng.uniform(0.25, 0.40)
        head = length * rng.uniform(0.31, 0.41)
        span = length * rng.uniform(0.18, 0.24)
        offset = length * rng.uniform(0.09, 0.14)
        tail = length * rng.uniform(0.16, 0.24)
        mass = 0.68 * (length / 0.331) ** 3 * rng.uniform(0.85, 1.15)
        inertia = 0.1275 * mass * length**2 * rng.uniform(0.9, 1.2)
    size = length / 0.331
    coefficients = {
        "C_T": 4.5e-3 * size**2 * rng.uniform(0.8, 1.25),
        "C_La": 3.14 * rng.uniform(0.8, 1.15),
        "C_Da": rng.uniform(1.5, 4.5),
        "C_D0": 0.5 * rng.uniform(0.8, 1.3),
        "C_Ma": 0.1 * size * rng.uniform(0.6, 1.2),
        "C_Md": 0.125 * size**5 * rng.uniform(0.8, 1.3),
    }
    return Robot(
        mass=round(float(mass), 4),
        inertia=round(float(inertia), 4),
        body_length=round(float(length), 4),
        head_length=round(float(head), 4),
        head_span=round(float(span), 4),
        hinge_to_com=round(float(offset), 4),
        tail_length=round(float(tail), 4),
        keypoint_depth=round(float(rng.uniform(0.03, 0.06)), 3),
        coefficients={name: float(v) for name, v in coefficients.items()},
    )


def straight_growth(robot: Robot, fin: Fin | None, flap: float = FULL_POWER_FLAP) -> float:
    """Largest growth rate (1/s) of sway and yaw in straight swimming at the speed of equilibrium.

    The equations are linearised at alpha = -v/u. A `trailing_edge` fin counts as one point at its
    arm, although it acts at three stations: its true growth rate differs.
    """
    c = robot.coefficients
    area = robot.head_length * robot.head_span
    speed = flap * np.sqrt(c["C_T"] / c["C_D0"])
    q_u = HALF_DENSITY * area * speed  # q over speed
    side = -q_u * (2 * c["C_La"] + c["C_D0"])  # dY/dv
    turn = robot.arm(robot.head_length) * side - q_u * 2 * c["C_Ma"]  # dN/dv
    s, a = (HALF_DENSITY * fin.area, fin.arm) if fin else (0.0, 0.0)
    flow = np.hypot(speed, fin.shape * flap) if fin and fin.form == "flapping" else speed
    matrix = [
        [(side - s * flow) / robot.mass, s * flow * a / robot.mass - speed],
        [(turn + a * s * flow) / robot.inertia, -a * a * s * flow / robot.inertia],
    ]
    return float(np.linalg.eigvals(np.array(matrix)).real.max())


def draw_fin(rng: np.random.Generator, robot: Robot) -> Fin:
    """A fin whose area makes straight swimming at full power marginally to strongly stable."""
    form = str(rng.choice(list(FIN_SHAPES)))
    shape = float(rng.uniform(*FIN_SHAPES[form]))
    arm = float(robot.tail_reach() * rng.uniform(0.6, 0.85))
    target = -np.exp(rng.uniform(np.log(SLOWEST_DECAY), np.log(FASTEST_DECAY)))
    for area in np.geomspace(0.0005, 0.08, 300) * (robot.body_length / 0.331) ** 2:
        fin = Fin(form, shape, arm, float(area))
        if straight_growth(robot, fin) < target:
            break
    return fin
