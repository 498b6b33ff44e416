"""Robots of 0.3 to 1.2 m, scaled from the published one, with and without a fin.

Lengths scale with the body, coefficients by their dimensions: `C_T` (m^2) with its square, `C_Ma`
(m) with the length, `C_Md` (kg m^2) and the yaw inertia with its fifth power.

Lift curves of the fin, a wing of low aspect ratio AR:
    helmbold   2 pi AR / (2 + sqrt(AR^2 + 4)); H. B. Helmbold, Ingenieur-Archiv 13 (1942) 273
    polhamus   K_p sin a cos^2 a + K_v cos a sin^2 a; E. C. Polhamus, NASA TN D-3767 (1966)
    lighthill  side force -m' U w of the trailing edge; M. J. Lighthill, Proc. R. Soc. B 179 (1971)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

DENSITY = 1000.0
COEFFICIENTS = ("C_T", "C_La", "C_Da", "C_D0", "C_Ma", "C_Md")
PAPER_BODY_LENGTH = 0.331
FIN_FORMS = ("helmbold", "polhamus", "lighthill")
CORE_SHARE_OF_INERTIA = 0.8
"""Share of core and tail in the yaw inertia; the head has the rest."""


@dataclass(frozen=True)
class Fin:
    """A lifting surface at the tail. area: m^2; arm: m behind the centre of mass; slope: 1/rad."""

    form: str
    area: float
    arm: float
    slope: float


@dataclass(frozen=True)
class Robot:
    """What a robot is; SI units. flap: Hz at full power. recoil: rad. ripple: share of thrust."""

    mass: float
    inertia: float
    body_length: float
    head_length: float
    head_span: float
    hinge_to_com: float
    tail_length: float
    keypoint_depth: float
    flap: float
    coefficients: tuple[float, ...]
    recoil: float
    ripple: float
    fin: Fin | None = None

    @property
    def head_area(self) -> float:
        """Area of the 1x head plate (m^2)."""
        return self.head_length * self.head_span

    @property
    def speed(self) -> float:
        """F sqrt(C_T / C_D0): published straight speed at full power (m/s)."""
        return float(self.flap * np.sqrt(self.coefficients[0] / self.coefficients[3]))

    @property
    def drag(self) -> float:
        """Drag at the published straight speed (N)."""
        return 0.5 * DENSITY * self.head_area * self.coefficients[3] * self.speed**2

    @property
    def aft(self) -> float:
        """Distance from the centre of mass back to the tail tip (m)."""
        return self.body_length - self.head_length - self.hinge_to_com + self.tail_length

    def arm(self, head: Any) -> Any:
        """L = h + hinge_to_com - (body_length + h - head_length) / 4 (m)."""
        return head + self.hinge_to_com - (self.body_length + head - self.head_length) / 4


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot without a fin."""
    body = float(np.exp(rng.uniform(np.log(0.3), np.log(1.0))))
    s = body / PAPER_BODY_LENGTH

    def near(value: float, digits: int = 3) -> float:
        return round(float(value * rng.uniform(0.9, 1.1)), digits)

    coefficients = (
        4.5e-3 * s**2 * rng.uniform(0.8, 1.3), rng.uniform(2.0, 3.5), rng.uniform(0.5, 3.0),
        rng.uniform(0.4, 0.8), 0.1 * s * rng.uniform(0.4, 1.1), 0.12 * s**5 * rng.uniform(0.8, 1.4),
    )  # fmt: skip
    return Robot(
        mass=near(0.68 * s**3), inertia=near(0.0095 * s**5, 5), body_length=round(body, 3),
        head_length=near(0.12 * s), head_span=near(0.069 * s), hinge_to_com=near(0.04 * s),
        tail_length=near(0.066 * s), keypoint_depth=near(0.04 * s),
        flap=float(5.8 * s**-0.8 * rng.uniform(0.85, 1.15)),
        coefficients=tuple(float(c) for c in coefficients),
        recoil=float(np.radians(rng.uniform(0.8, 3.0))), ripple=float(rng.uniform(0.2, 0.7)),
    )  # fmt: skip


def _slope(form: str, aspect: float) -> float:
    """Slope of the side force at small angles (1/rad)."""
    if form == "helmbold":
        return float(2 * np.pi * aspect / (2 + np.sqrt(aspect**2 + 4)))
    return float(np.pi * aspect / 2)


def draw_fin(rng: np.random.Generator, robot: Robot, form: str) -> Fin:
    """A fin that makes straight swimming marginally to strongly stable."""
    arm, slope = robot.aft * rng.uniform(0.75, 0.95), _slope(form, rng.uniform(0.8, 2.0))
    target = -rng.uniform(0.1, 1.2) * robot.speed / robot.body_length
    low, high = 0.0, 4 * robot.body_length * robot.head_span
    for _ in range(40):
        middle = 0.5 * (low + high)
        if straight_growth(robot, Fin(form, middle, arm, slope)) > target:
            low = middle
        else:
            high = middle
    return Fin(form, high, float(arm), slope)


def straight_growth(robot: Robot, fin: Fin | None) -> float:
    """Growth (1/s) of a small yaw of a straight robot at full speed, as the linear model has it.

    m (w' + U r) = Y_w w + Y_r r,  I r' = N_w w + N_r r.
    """
    _, c_la, _, c_d0, c_ma, _ = robot.coefficients
    head = 0.5 * DENSITY * robot.head_area * robot.speed
    y_w, y_r = -head * (2 * c_la + c_d0), 0.0
    n_w, n_r = float(robot.arm(robot.head_length)) * y_w - 2 * head * c_ma, 0.0
    if fin:
        side = 0.5 * DENSITY * fin.area * fin.slope * robot.speed
        y_w, y_r = y_w - side, y_r + side * fin.arm
        n_w, n_r = n_w + side * fin.arm, n_r - side * fin.arm**2
    matrix = [
        [y_w / robot.mass, y_r / robot.mass - robot.speed],
        [n_w / robot.inertia, n_r / robot.inertia],
    ]
    return float(np.max(np.linalg.eigvals(np.array(matrix)).real))


def fin_force(fin: Fin, u: Array, w: Array, r: Array) -> tuple[Array, Array]:
    """Force of the fin in axes of the core (N, complex) and its moment (N m).

    Sideways speed at the fin: w - r arm. The force is normal to the core, except for the forward
    force m' w^2 / 2 of `lighthill`.
    """
    across = w - r * fin.arm
    speed = np.hypot(u, across) + 1e-9
    scale = 0.5 * DENSITY * fin.area * fin.slope
    if fin.form == "helmbold":
        force = -scale * speed * across + 0j
        return 1j * force, -fin.arm * force.real
    if fin.form == "polhamus":
        sine, cosine = across / speed, np.abs(u) / speed
        vortex = np.pi / fin.slope
        side = -scale * speed**2 * (sine * cosine**2 + vortex * cosine * sine * np.abs(sine))
        return 1j * side, -fin.arm * side
    side = -scale * np.abs(u) * across
    return 0.5 * scale * across**2 * np.tanh(speed / 0.02) + 1j * side, -fin.arm * side
