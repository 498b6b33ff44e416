"""Currents, gyres and walls: laws of the place in the pool."""

# ruff: noqa: ARG001 - laws of one stage share their arguments

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .form import Form, form_maker

Array = NDArray[np.float64]
ShapeParameters = Any


def _direction(p: ShapeParameters) -> complex:
    return complex(np.exp(1j * np.deg2rad(p["way_deg"])))


def _from_centre(c: SimpleNamespace, p: ShapeParameters) -> Any:
    """Place from the centre of the pool, m, complex."""
    return c.x - (p["pool_length_m"] + 1j * p["pool_width_m"]) / 2


def current_constant(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """The same velocity s, m/s, in all trials."""
    return s * _direction(p)


def current_drifting(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """A direction that turns slowly in each trial."""
    return s * _direction(p) * np.exp(1j * p["turn_rad_s"] * (c.t - 3))


def current_sheared(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """Along the pool, s (1 + k y/half width): inflow on one side."""
    y = _from_centre(c, p).imag / (p["pool_width_m"] / 2)
    return s * (1 + p["shear"] * y) + 0j


def current_decaying(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """Left by handling: falls to 1/e in tau after the start of a trial."""
    return s * _direction(p) * np.exp(-c.t / p["tau_s"])


def _velocity_around(at: Any, speed: Array) -> Any:
    """Velocity around a centre from its size as a function of the distance."""
    return 1j * at / (np.abs(at) + 1e-9) * speed


def gyre_solid(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """Rotation as a solid body; s at half the width of the pool."""
    return 1j * s * _from_centre(c, p) / (p["pool_width_m"] / 2)


def gyre_cell(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """One cell, stream function sin(pi x/L) sin(pi y/W) (Stommel)."""
    L, W = p["pool_length_m"], p["pool_width_m"]
    x, y = np.pi * c.x.real / L, np.pi * c.x.imag / W
    return -s * (np.sin(x) * np.cos(y) - 1j * W / L * np.cos(x) * np.sin(y))


def gyre_lamb(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """Lamb-Oseen vortex, (1 - exp(-r^2/a^2)) a/r, greatest about r = 1.12 a."""
    at = _from_centre(c, p)
    r = np.abs(at) / p["core_m"] + 1e-9
    return _velocity_around(at, s / 0.638 * (1 - np.exp(-(r**2))) / r)


def gyre_scully(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """Scully vortex, 2 r a/(r^2 + a^2) (Scully 1975; Kaufmann 1962)."""
    at = _from_centre(c, p)
    r = np.abs(at) / p["core_m"]
    return _velocity_around(at, s * 2 * r / (1 + r**2))


def gyre_two(c: SimpleNamespace, s: Array, p: ShapeParameters) -> Any:
    """Two cells side by side, turning in opposite senses."""
    L, W = p["pool_length_m"], p["pool_width_m"]
    x, y = 2 * np.pi * c.x.real / L, np.pi * c.x.imag / W
    return -s * (np.sin(x) * np.cos(y) - 2j * W / L * np.cos(x) * np.sin(y))


def wall_distances(c: SimpleNamespace, p: ShapeParameters) -> list[tuple[Array, complex]]:
    """Distances to the four walls, m, with the directions away from them."""
    x, y = c.x.real, c.x.imag
    walls = [(x, 1 + 0j), (p["pool_length_m"] - x, -1 + 0j), (y, 1j), (p["pool_width_m"] - y, -1j)]
    return [(np.maximum(gap, 0.05), away) for gap, away in walls]


def _wall_force(c: SimpleNamespace, s: Array, p: ShapeParameters, law: Any) -> tuple[Any, Array]:
    """Push of the walls s q law(gap), s at a gap of 0.3 m, and its moment about the nose's side."""
    F = sum(s * c.q * law(gap) / law(0.3) * away for gap, away in wall_distances(c, p))
    return F, p["lever_m"] * (F * np.conj(1j * c.axis)).real


def wall_exponential(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """exp(-gap/scale)."""
    return _wall_force(c, s, p, lambda gap: np.exp(-gap / p["scale_m"]))


def wall_power(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """gap^-2: image of a doublet in cross-flow (Newman 1965)."""
    return _wall_force(c, s, p, lambda gap: gap ** (-p["power"]))


def wall_gaussian(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """exp(-(gap/scale)^2)."""
    return _wall_force(c, s, p, lambda gap: np.exp(-((gap / p["scale_m"]) ** 2)))


def wall_suction(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Suction to a bank by the speed along it, (Norrbin 1974): gap^-1.5, q cos^2 of the course."""
    F = 0j
    for gap, away in wall_distances(c, p):
        beside = 1 - (c.along * np.conj(away)).real ** 2
        F = F - s * c.q * beside * (gap / 0.3) ** -1.5 * away
    return F, p["lever_m"] * (F * np.conj(1j * c.axis)).real


_current = form_maker("uniform_current", "water", "m/s", ("surge", "sway"))
_gyre = form_maker("pool_gyre", "water", "m/s", ("surge", "sway"), signed=True)
_wall = form_maker("wall_effect", "force", "1", ("surge", "sway", "yaw"))
DIRECTION_RANGE = {"way_deg": (0.0, 360.0)}
LEVER_RANGE = {"lever_m": (-0.02, 0.04)}
FORMS: tuple[Form, ...] = (
    _current("constant", current_constant, 3e-4, 0.06, **DIRECTION_RANGE),
    _current("drifting", current_drifting, 3e-4, 0.06, **DIRECTION_RANGE, turn_rad_s=(-0.3, 0.3)),
    _current("sheared", current_sheared, 3e-4, 0.06, shear=(-0.9, 0.9)),
    _current("decaying", current_decaying, 3e-4, 0.08, **DIRECTION_RANGE, tau_s=(4.0, 12.0)),
    _gyre("solid", gyre_solid, 3e-4, 0.08),
    _gyre("cell", gyre_cell, 3e-4, 0.08),
    _gyre("lamb_oseen", gyre_lamb, 3e-4, 0.08, core_m=(0.3, 0.7)),
    _gyre("scully", gyre_scully, 3e-4, 0.08, core_m=(0.3, 0.7)),
    _gyre("two_cells", gyre_two, 3e-4, 0.08),
    _wall("exponential", wall_exponential, 1e-3, 0.8, **LEVER_RANGE, scale_m=(0.08, 0.2)),
    _wall("power", wall_power, 1e-3, 0.8, **LEVER_RANGE, power=(1.5, 2.5)),
    _wall("gaussian", wall_gaussian, 1e-3, 0.8, **LEVER_RANGE, scale_m=(0.2, 0.4)),
    _wall("suction", wall_suction, 1e-3, 0.8, **LEVER_RANGE),
)
