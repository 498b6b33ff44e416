"""The robot: geometry, mass, the six coefficients and its surroundings in one study."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RHO = 1000.0
"""Density of water, kg/m^3."""
COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")
"""m^2, 1, 1, 1, m, kg m^2 (MODEL.md, audit 1)."""


@dataclass(frozen=True)
class Robot:
    """Geometry (m), mass (kg), yaw inertia (kg m^2) and coefficients of a robot."""

    mass: float
    inertia: float
    body_length: float
    head_length: float
    span: float
    hinge_to_com: float
    tail_length: float
    depth: float
    coefficients: dict[str, float]
    background: float = 0.0
    """Share of the ellipsoid's added mass that is always there."""

    @property
    def stern(self) -> float:
        """Distance from the centre of mass to the caudal base, m."""
        return self.body_length - self.head_length - self.hinge_to_com

    def area(self, head):
        """Area of a head plate of length `head`, m^2."""
        return head * self.span

    def arm(self, head):
        """Centre of mass to aerodynamic centre along the head, m: a quarter of the length."""
        return head + self.hinge_to_com - (self.body_length + head - self.head_length) / 4

    def stations(self, number: int = 8) -> tuple[np.ndarray, float]:
        """Midpoints from hinge to tail tip, m ahead of the centre of mass, and their width."""
        ends = np.linspace(self.hinge_to_com, -self.stern - self.tail_length, number + 1)
        return (ends[1:] + ends[:-1]) / 2, float(ends[0] - ends[1])


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot like that of the paper, each number changed by up to about a quarter."""
    low = {"C_T": 3.6e-3, "C_D0": 0.42, "C_Da": 1.2, "C_La": 2.3, "C_Ma": 0.06, "C_Md": 0.085}
    high = {"C_T": 5.6e-3, "C_D0": 0.66, "C_Da": 4.5, "C_La": 3.5, "C_Ma": 0.14, "C_Md": 0.150}
    size = rng.uniform(0.92, 1.1)
    return Robot(
        mass=round(0.68 * size**3 * rng.uniform(0.9, 1.1), 3),
        inertia=round(0.0095 * size**5 * rng.uniform(0.88, 1.12), 5),
        body_length=round(0.331 * size * rng.uniform(0.97, 1.03), 3),
        head_length=round(0.12 * size * rng.uniform(0.94, 1.06), 3),
        span=round(0.069 * size * rng.uniform(0.93, 1.07), 4),
        hinge_to_com=round(rng.uniform(0.034, 0.048), 3),
        tail_length=round(0.066 * size * rng.uniform(0.9, 1.1), 3),
        depth=round(rng.uniform(0.03, 0.065), 3),
        coefficients={name: float(rng.uniform(low[name], high[name])) for name in COEFFICIENTS},
    )


def spheroid_added_mass(length: float, width: float) -> tuple[float, float, float]:
    """Added masses of a prolate spheroid: surge and sway (kg), yaw (kg m^2).

    k1 = a0/(2 - a0), k2 = b0/(2 - b0),
    k' = e^4 (b0 - a0) / ((2 - e^2) (2 e^2 - (2 - e^2)(b0 - a0)))
    with a0 = 2 (1 - e^2)/e^3 (atanh e - e), b0 = 1/e^2 - (1 - e^2)/e^3 atanh e.
    Lamb, Hydrodynamics, sections 114 and 115.
    """
    e = np.sqrt(1 - (width / length) ** 2)
    a0 = 2 * (1 - e**2) / e**3 * (np.arctanh(e) - e)
    b0 = 1 / e**2 - (1 - e**2) / e**3 * np.arctanh(e)
    displaced = RHO * np.pi / 6 * length * width**2
    turning = displaced * (length**2 + width**2) / 20
    k = e**4 * (b0 - a0) / ((2 - e**2) * (2 * e**2 - (2 - e**2) * (b0 - a0)))
    return displaced * a0 / (2 - a0), displaced * b0 / (2 - b0), turning * k
