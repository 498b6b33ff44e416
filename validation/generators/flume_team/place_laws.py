"""Water that moves, walls, and depth.

`water` laws: time, x, y, pool -> velocity of the water, complex, m/s, pool axes.
`depth` laws: time -> extra depth of the robot, m.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .form import REFERENCE_SPEED, Array, Form, Situation

Pool = tuple[float, float]


def current_constant(
    _: Array, x: Array, __: Array, ___: Pool, speed: float, *, way: float
) -> Array:
    """The same everywhere (Fossen 2011, sec. 8.3)."""
    return speed * np.exp(1j * way) + 0j * x


def current_drifting(
    t: Array, x: Array, _: Array, __: Pool, speed: float, *, way: float, turn: float
) -> Array:
    """Direction turns at a slow rate (Fossen 2011, sec. 8.3, slowly varying)."""
    return speed * np.exp(1j * (way + turn * np.asarray(t))) + 0j * x


def current_sheared(
    _: Array, x: Array, y: Array, pool: Pool, speed: float, *, shear: float
) -> Array:
    """Along the pool, changing across it by the share `shear` (channel flow, Chow 1959)."""
    return speed * (1 + shear * (2 * y / pool[1] - 1)) + 0j * x


def gyre_cell(_: Array, x: Array, y: Array, pool: Pool, speed: float) -> Array:
    """One cell, stream function sin sin (Stommel 1948; Pedlosky 1996)."""
    a, b = np.pi * x / pool[0], np.pi * y / pool[1]
    return speed * (-np.sin(a) * np.cos(b) + 1j * pool[1] / pool[0] * np.cos(a) * np.sin(b))


def gyre_gaussian(_: Array, x: Array, y: Array, pool: Pool, speed: float, *, core: float) -> Array:
    """Gaussian vortex about the middle (Lamb 1932, art. 334a), greatest speed near `speed`."""
    place = (x - pool[0] / 2) + 1j * (y - pool[1] / 2)
    ratio = np.maximum(np.abs(place) / core, 1e-6)
    swirl = 1.57 * speed * (1 - np.exp(-(ratio**2))) / ratio
    return 1j * swirl * place / np.maximum(np.abs(place), 1e-6)


def gyre_scully(_: Array, x: Array, y: Array, pool: Pool, speed: float, *, core: float) -> Array:
    """Algebraic vortex 2 speed R/(1 + R^2) (Scully 1975, MIT ASRL TR 178-1)."""
    place = (x - pool[0] / 2) + 1j * (y - pool[1] / 2)
    ratio = np.abs(place) / core
    return 2j * speed / (1 + ratio**2) * place / core


def _wall_force(
    s: Situation, size: float, decay: Callable[[Array], Array]
) -> tuple[Array, Array, Array]:
    """Sum over four walls of size (V/V0)^2 decay(gap) inward, at the head's quarter point."""
    length, width = s.lanes.pool
    inward = decay(s.x) - decay(length - s.x) + 1j * (decay(s.y) - decay(width - s.y))
    push = size * (s.speed / REFERENCE_SPEED) ** 2 * inward * np.exp(-1j * s.psi)
    return push.real, push.imag, 0.3 * s.robot.body_length * push.imag


def wall_exponential(s: Situation, size: float, reach: float) -> tuple[Array, Array, Array]:
    """exp(-gap/reach) (near field of a source sheet; Newman 1977, sec. 4)."""
    return _wall_force(s, size, lambda gap: np.exp(-np.maximum(gap, 0.05) / reach))


def wall_power(s: Situation, size: float, reach: float) -> tuple[Array, Array, Array]:
    """(1 + gap/reach)^-3: image of a dipole (Lamb 1932, art. 98)."""
    return _wall_force(s, size, lambda gap: (1 + np.maximum(gap, 0.05) / reach) ** -3.0)


def wall_gaussian(s: Situation, size: float, reach: float) -> tuple[Array, Array, Array]:
    """exp(-(gap/reach)^2) (cushion of an image vortex pair, Blevins et al. 2013)."""
    return _wall_force(s, size, lambda gap: np.exp(-((np.maximum(gap, 0.05) / reach) ** 2)))


def sink_linear(t: Array, depth: float) -> Array:
    """Sinking by depth t/20 s: slightly too heavy, terminal speed (Fossen 2011, sec. 4.1)."""
    return depth * np.asarray(t) / 20


def sink_square(t: Array, depth: float) -> Array:
    """Sinking by depth (t/20 s)^2: constant downward acceleration."""
    return depth * (np.asarray(t) / 20) ** 2


def sink_saturating(t: Array, depth: float, tau: float) -> Array:
    """Sinking by depth (1 - exp(-t/tau)): settles at a depth where it floats."""
    return depth * (1 - np.exp(-np.asarray(t) / tau))


_PI = float(np.pi)
FORMS: tuple[Form, ...] = (
    Form("uniform_current", current_constant, "water", "m/s", 0.01, 0.12, ("surge", "sway"),
         "velocity of the water", shape={"way": (-_PI, _PI)}),
    Form("uniform_current", current_drifting, "water", "m/s", 0.01, 0.12, ("surge", "sway"),
         "velocity of the water", shape={"way": (-_PI, _PI), "turn": (-0.08, 0.08)}),
    Form("uniform_current", current_sheared, "water", "m/s", 0.01, 0.12, ("surge", "sway"),
         "velocity of the water", shape={"shear": (-0.6, 0.6)}, signed=True),
    Form("pool_gyre", gyre_cell, "water", "m/s", 0.01, 0.15, ("surge", "sway"), "x, y",
         signed=True),
    Form("pool_gyre", gyre_gaussian, "water", "m/s", 0.01, 0.15, ("surge", "sway"), "x, y",
         shape={"core": (0.6, 1.2)}, signed=True),
    Form("pool_gyre", gyre_scully, "water", "m/s", 0.01, 0.15, ("surge", "sway"), "x, y",
         shape={"core": (0.6, 1.2)}, signed=True),
    Form("wall_effect", wall_exponential, "force", "N", 0.1, 1.5, ("sway", "yaw"), "gap",
         shape={"reach": (0.12, 0.3)}),
    Form("wall_effect", wall_power, "force", "N", 0.1, 1.5, ("sway", "yaw"), "gap",
         shape={"reach": (0.3, 0.6)}),
    Form("wall_effect", wall_gaussian, "force", "N", 0.1, 1.5, ("sway", "yaw"), "gap",
         shape={"reach": (0.3, 0.55)}),
    Form("sinking", sink_linear, "depth", "m", 0.06, 0.4, ("surge",), "t"),
    Form("sinking", sink_square, "depth", "m", 0.06, 0.4, ("surge",), "t"),
    Form("sinking", sink_saturating, "depth", "m", 0.06, 0.4, ("surge",), "t",
         shape={"tau": (5.0, 15.0)}),
)  # fmt: skip
