"""Robots: geometry, the six published coefficients, a fin of wanted stability."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.optimize import brentq

from .fins import FINS, Fin

DENSITY = 1000.0
"""Density of the water, kg/m^3."""
STABILITY_RANGE = (1.12, 3.5)
"""Least and greatest area of a fin over that at which straight swimming is neutral."""


@dataclass(frozen=True)
class Coefficients:
    """The six of the paper. C_T: m^2. C_D0, C_Da, C_La: 1. C_Ma: m. C_Md: kg m^2."""

    C_T: float = 4.5e-3
    C_D0: float = 0.5
    C_Da: float = 2.5
    C_La: float = 3.14
    C_Ma: float = 0.1
    C_Md: float = 0.13


COEFFICIENT_NAMES = tuple(f.name for f in fields(Coefficients))


@dataclass(frozen=True)
class Robot:
    """Geometry as in study.yaml (m, kg, kg m^2), coefficients, and a fin or none."""

    mass: float = 0.68
    inertia: float = 0.0095
    body_length: float = 0.331
    head_length: float = 0.12
    span: float = 0.069
    hinge_to_com: float = 0.04
    tail_length: float = 0.066
    keypoint_depth: float = 0.04
    coefficients: Coefficients = Coefficients()
    fin: Fin | None = None

    def area(self, head: np.ndarray) -> np.ndarray:
        """Area of the head plate, m^2, for head lengths in m."""
        return head * self.span

    def arm(self, head: np.ndarray) -> np.ndarray:
        """Centre of mass to aerodynamic centre, m: h + a - (body + h - h_1) / 4 (STUDY.md)."""
        return head + self.hinge_to_com - (self.body_length + head - self.head_length) / 4

    @property
    def base(self) -> float:
        """Centre of mass to caudal base, m."""
        return self.body_length - self.head_length - self.hinge_to_com


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot without a fin near the published one, sizes within about 15 %."""

    def near(value: float, share: float) -> float:
        return float(np.round(value * np.exp(share * rng.uniform(-1, 1)), 5))

    coefficients = Coefficients(
        C_T=near(4.5e-3, 0.25), C_D0=near(0.5, 0.2), C_Da=near(2.2, 0.5), C_La=near(3.0, 0.15),
        C_Ma=near(0.08, 0.3), C_Md=near(0.125, 0.2),
    )  # fmt: skip
    return Robot(
        mass=near(0.68, 0.1), inertia=near(0.0095, 0.12), body_length=near(0.331, 0.05),
        head_length=near(0.12, 0.05), span=near(0.069, 0.06), hinge_to_com=near(0.04, 0.15),
        tail_length=near(0.066, 0.1), keypoint_depth=near(0.06, 0.6), coefficients=coefficients,
    )  # fmt: skip


def growth_rate(robot: Robot, hertz: float = 4.0) -> float:
    """Greatest real part, per second, of the sway and yaw modes of straight steady swimming.

    The modes scale with the speed, so that their sign does not depend on the frequency.
    """
    from .motion import rates  # noqa: PLC0415  the equations need robots
    from .trials import straight_trial  # noqa: PLC0415

    k = robot.coefficients
    lane = straight_trial(robot, hertz)
    state = np.zeros((8, 1))
    state[3] = hertz * np.sqrt(k.C_T / k.C_D0)
    # sideways velocity relative to the core: heading fixed, so the world's y velocity
    step = np.array([1e-5, 1e-5])
    matrix = np.zeros((2, 2))
    for column, (row, delta) in enumerate(zip((4, 5), step, strict=True)):
        moved = [state.copy(), state.copy()]
        moved[0][row] -= delta
        moved[1][row] += delta
        low, high = (rates(np.zeros(1), s, lane, robot)[4:6, 0] for s in moved)
        matrix[:, column] = (high - low) / (2 * delta)
    matrix[0, 1] -= state[3, 0]  # d(vy)/dt in core axes: the axes turn with r
    return float(np.linalg.eigvals(matrix).real.max())


def with_fin(rng: np.random.Generator, robot: Robot) -> Robot:
    """The robot with a fin of random form whose straight swimming is stable."""
    law = FINS[rng.integers(len(FINS))]
    fin = Fin(law, area=0.01, arm=float(rng.uniform(0.10, 0.19)),
              cross=float(rng.uniform(0.8, 2.2)), onset=float(rng.uniform(0.22, 0.45)))  # fmt: skip

    def unstable(log_area: float) -> float:
        return growth_rate(replace(robot, fin=replace(fin, area=float(np.exp(log_area)))))

    neutral = np.exp(brentq(unstable, np.log(1e-4), np.log(0.5), xtol=1e-3))
    factor = np.exp(rng.uniform(*np.log(STABILITY_RANGE)))
    return replace(robot, fin=replace(fin, area=float(neutral * factor)))
