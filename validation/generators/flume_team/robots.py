"""Robots: geometry, the six coefficients, and the tail fin that some of them have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .form import Array

DENSITY = 1000.0
"""Density of water, kg/m^3."""


@dataclass(frozen=True)
class Coefficients:
    """C_T m^2; C_D0, C_Da, C_La without unit; C_Ma m; C_Md kg m^2 (MODEL.md)."""

    C_T: float
    C_D0: float
    C_Da: float
    C_La: float
    C_Ma: float
    C_Md: float


@dataclass(frozen=True)
class Fin:
    """Core and tail as a fin. area: m^2, with the slope of its force; arm: m behind the centre."""

    law: str
    area: float
    arm: float
    onset: float


@dataclass(frozen=True)
class Robot:
    """Robot with its 1x head; lengths m, mass kg, inertia kg m^2."""

    coefficients: Coefficients
    mass: float
    inertia: float
    body_length: float
    head_length: float
    span: float
    hinge_to_com: float
    tail_length: float
    keypoint_depth: float
    fin: Fin | None = None

    def area(self, head: Array) -> Array:
        """Area of head plates of a length, m^2."""
        return head * self.span

    def arm(self, head: Array) -> Array:
        """Distance of the aerodynamic centre ahead of the centre of mass, m (STUDY.md)."""
        return head + self.hinge_to_com - (self.body_length + head - self.head_length) / 4


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot without a fin, near the size of the published one."""
    size = rng.uniform(0.85, 1.25)
    coefficients = Coefficients(
        C_T=float(f"{rng.uniform(3.2e-3, 5.5e-3):.4g}"),
        C_D0=float(f"{rng.uniform(0.35, 0.75):.4g}"),
        C_Da=float(f"{rng.uniform(0.8, 4.0):.4g}"),
        C_La=float(f"{rng.uniform(2.2, 3.6):.4g}"),
        C_Ma=float(f"{rng.uniform(0.04, 0.11):.4g}"),
        C_Md=float(f"{rng.uniform(0.08, 0.16) * size**3:.4g}"),
    )
    return Robot(
        coefficients,
        mass=round(0.68 * size**3 * rng.uniform(0.9, 1.1), 3),
        inertia=round(0.0095 * size**5 * rng.uniform(0.85, 1.2), 5),
        body_length=round(0.331 * size, 3),
        head_length=round(0.12 * size * rng.uniform(0.95, 1.05), 3),
        span=round(0.069 * size, 3),
        hinge_to_com=round(0.04 * size * rng.uniform(0.9, 1.2), 3),
        tail_length=round(0.066 * size, 3),
        keypoint_depth=round(float(rng.uniform(0.03, 0.07)), 3),
    )
