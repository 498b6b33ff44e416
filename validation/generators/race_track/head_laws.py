"""Laws of the head plate, of the inertia of the water and of the place of the mass.

Hooks: `head` factors on lift, drag and moment of the plate; `lag` states behind the lift;
`mass` added masses; `centre` shift of the centre of mass (m, core axes) for a head angle.
"""

from __future__ import annotations

import numpy as np

from .form import Family
from .robots import DENSITY, Array, Robot

Factors = tuple[Array, Array, Array]


def _folded(alpha: Array) -> Array:
    """Angle between plate and flow, 0 to pi/2."""
    return np.arcsin(np.abs(np.sin(alpha)).clip(0, 1))


def stall_kirchhoff(alpha: Array, size: float, shape: float) -> Factors:
    """Lift times 1 - size (1 - K), K = ((1 + sqrt f)/2)^2 of the separation point f(alpha).

    J. G. Leishman, T. S. Beddoes, J. American Helicopter Soc. 34 (1989) 3, eqs. 6 and 7.
    """
    excess = _folded(alpha) - np.radians(11 + 7 * shape)
    early = 1 - 0.3 * np.exp(np.minimum(excess, 0) / np.radians(3))
    late = 0.04 + 0.66 * np.exp(-np.maximum(excess, 0) / np.radians(5))
    lost = 1 - (0.5 * (1 + np.sqrt(np.where(excess < 0, early, late)))) ** 2
    return 1 - size * lost, np.ones_like(alpha), np.ones_like(alpha)


def stall_step(alpha: Array, size: float, shape: float) -> Factors:
    """Lift and moment fall by size over a smooth step at 15 to 25 degrees."""
    step = 1 / (1 + np.exp(-(_folded(alpha) - np.radians(15 + 10 * shape)) / np.radians(3)))
    return 1 - size * step, np.ones_like(alpha), 1 - size * step


def stall_separation(alpha: Array, size: float, shape: float) -> Factors:
    """Steady separation x = (1 - tanh(b (alpha - alpha*)))/2 and lift (1 + sqrt x)^2 / 4.

    M. Goman, A. Khrabrov, J. Aircraft 31 (1994) 1109.
    """
    x = 0.5 * (1 - np.tanh(9 * (_folded(alpha) - np.radians(14 + 8 * shape))))
    return 1 - size * (1 - 0.25 * (1 + np.sqrt(x)) ** 2), 1 + 0.2 * size * (1 - x), 1 + 0 * x


def asymmetry_step(alpha: Array, size: float, _shape: float) -> Factors:
    """Lift slope 1 + size on one side, 1 - size on the other."""
    factor = 1 + size * np.tanh(np.sin(2 * alpha) / 0.03)
    return factor, np.ones_like(alpha), factor


def asymmetry_smooth(alpha: Array, size: float, shape: float) -> Factors:
    """Slope that changes over 6 to 14 degrees: a cambered plate."""
    factor = 1 + size * np.tanh(np.sin(2 * alpha) / (2 * np.radians(6 + 8 * shape)))
    return factor, np.ones_like(alpha), np.ones_like(alpha)


def asymmetry_drag(alpha: Array, size: float, _shape: float) -> Factors:
    """Lift and drag differ: an edge that separates on one side."""
    side = np.tanh(np.sin(2 * alpha) / 0.1)
    return 1 + size * side, 1 + 0.5 * size * side, 1 + size * side


def lag_first(behind: Array, lift: Array, travel: Array, size: float, _shape: float) -> Array:
    """D c/ds = (C - c) / size with s in head lengths; both states alike."""
    return travel * (lift - behind) / size


def lag_wagner(behind: Array, lift: Array, travel: Array, size: float, _shape: float) -> Array:
    """Wagner's function with R. T. Jones's exponents, distances stretched by size.

    R. T. Jones, NACA Report 681 (1940): 1 - 0.165 e^(-0.0455 s) - 0.335 e^(-0.3 s), half chords.
    """
    return 2 * travel * np.array([[0.0455], [0.3]]) * (lift - behind) / size


def lag_kussner(behind: Array, lift: Array, travel: Array, size: float, shape: float) -> Array:
    """Kuessner-like growth from zero, half with 3 to 8 times the distance of the other.

    W. R. Sears, J. Aeronautical Sciences 8 (1941) 104: 1 - 0.5 e^(-0.13 s) - 0.5 e^(-s).
    """
    slow = np.array([[1 / (3 + 5 * shape)], [1.0]])
    return 2 * travel * slow * (lift - behind) / size


LAG_PARTS = {"first": (0.0, 0.5, 0.5), "wagner": (0.5, 0.165, 0.335), "kussner": (0.0, 0.5, 0.5)}
"""Shares of the present lift and of the two states behind it."""


def _ellipsoid(robot: Robot) -> tuple[float, float, float]:
    """k1, k2, k' of a prolate spheroid of length and span; H. Lamb, Hydrodynamics 114."""
    a = 0.5 * (robot.body_length + robot.tail_length)
    b = 0.5 * robot.head_span
    e = np.sqrt(1 - (b / a) ** 2)
    log = np.log((1 + e) / (1 - e))
    alpha0 = 2 * (1 - e**2) / e**3 * (0.5 * log - e)
    beta0 = 1 / e**2 - (1 - e**2) / (2 * e**3) * log
    k1, k2 = alpha0 / (2 - alpha0), beta0 / (2 - beta0)
    ratio = beta0 - alpha0
    k3 = e**4 * ratio / ((2 - e**2) * (2 * e**2 - (2 - e**2) * ratio))
    return float(k1), float(k2), float(k3)


def mass_spheroid(robot: Robot, size: float, _shape: float) -> tuple[float, ...]:
    """(a11, a22, a26, a66) of a spheroid of the robot's mass, times size; Lamb's factors."""
    k1, k2, k3 = _ellipsoid(robot)
    a, b = 0.5 * (robot.body_length + robot.tail_length), 0.5 * robot.head_span
    m = size * robot.mass
    return k1 * m, k2 * m, 0.0, k3 * m * (a * a + b * b) / 5


def mass_strips(robot: Robot, size: float, shape: float) -> tuple[float, ...]:
    """Slender body: (pi/4) rho h^2 a strip, so that sway and yaw are coupled.

    J. N. Newman, Marine Hydrodynamics (1977) 7.2; the depth grows to the tail by 0 to 40 %.
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)
    nose = robot.hinge_to_com + robot.head_length
    half = 0.5 * (nose + robot.aft)
    along = nose - half + half * nodes
    height = robot.head_span * (1 - 0.4 * shape * nodes)
    strip = size * 0.25 * np.pi * DENSITY * height**2 * weights * half
    a22, a26, a66 = strip.sum(), (strip * along).sum(), (strip * along**2).sum()
    return 0.05 * size * robot.mass, float(a22), float(a26), float(a66)


def mass_sway(robot: Robot, size: float, _shape: float) -> tuple[float, ...]:
    """Only sway and surge: a plate across the flow and a tenth of its mass along it."""
    side = size * 0.25 * np.pi * DENSITY * robot.head_span**2 * robot.body_length
    return 0.1 * side, side, 0.0, 0.0


def centre_fixed(phi: Array, robot: Robot, size: float, _shape: float) -> Array:
    """Ballast in the core: the mass lies size (body lengths) ahead of the stated place."""
    return size * robot.body_length + 0j * phi


def centre_head(phi: Array, robot: Robot, size: float, _shape: float) -> Array:
    """Ballast in the head: the mass moves with it."""
    return size * robot.body_length * np.exp(-1j * phi)


FAMILIES = (
    Family("stall", "head", "share_of_loss", "1", 0.05, 1.2,
           {"kirchhoff": stall_kirchhoff, "step": stall_step, "separation": stall_separation}),
    Family("port_starboard_asymmetry", "head", "share_of_slope", "1", 0.02, 0.6,
           {"step": asymmetry_step, "smooth": asymmetry_smooth, "drag": asymmetry_drag}, odd=True),
    Family("lift_lag", "lag", "distance", "1", 0.1, 12.0,
           {"first": lag_first, "wagner": lag_wagner, "kussner": lag_kussner}),
    Family("added_mass", "mass", "share", "1", 0.1, 1.5,
           {"spheroid": mass_spheroid, "strips": mass_strips, "sway": mass_sway}),
    Family("centre_of_mass_shift", "centre", "share_of_body_length", "1", 0.01, 0.1,
           {"fixed": centre_fixed, "head": centre_head}, odd=True),
)  # fmt: skip
