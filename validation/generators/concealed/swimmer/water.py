"""Velocity of the water at a place: eddies that are always there, and hidden motions of the pool.

Compiled; `eddies` `(n, 7)` holds amplitude (m^2/s), kx, ky (rad/m), three phases, rate (rad/s) of
the stream function `a sin(kx x + px) sin(ky y + py) cos(w t + pt)`.
"""

import math

import numpy as np
from numba import njit

from bluekoi.synthetic.eddies import Eddy
from validation.generators.concealed.swimmer.inputs import BodyParameters, HiddenLaws

__all__ = ["eddies_as_rows", "eddy_flow", "gyre_flow", "water_velocity"]

CELL, GAUSSIAN, SCULLY = 0, 1, 2


def eddies_as_rows(eddies: tuple[Eddy, ...]) -> np.ndarray:
    """Eddies `(n, 7)` as the compiled laws take them."""
    rows = [
        (e.amplitude_m2_s, *e.wavenumber, e.phase[0], e.phase[1], e.phase[2], e.rate_rad_s)
        for e in eddies
    ]
    return np.array(rows, dtype=float).reshape(-1, 7)


@njit(cache=True)
def eddy_flow(eddies: np.ndarray, t: float, x: float, y: float) -> tuple[float, float]:
    """Sum of the eddies (m/s): `u = d psi/dy`, `v = -d psi/dx`."""
    u = v = 0.0
    for i in range(eddies.shape[0]):
        a, kx, ky, px, py, pt, w = eddies[i]
        now = a * math.cos(w * t + pt)
        sx, cx = math.sin(kx * x + px), math.cos(kx * x + px)
        sy, cy = math.sin(ky * y + py), math.cos(ky * y + py)
        u += now * ky * sx * cy
        v -= now * kx * cx * sy
    return u, v


@njit(cache=True)
def gyre_flow(b: BodyParameters, g: HiddenLaws, x: float, y: float) -> tuple[float, float]:
    """One eddy that fills the pool, `gyre` (m/s) its speed half way to the long walls.

    CELL: stream function `sin(pi x/L) sin(pi y/W)`; GAUSSIAN: `z exp(-|z|^2/c^2)`;
    SCULLY: `z / (c^2 + |z|^2)`, a vortex with a core (Scully 1975).
    """
    L, W, c = b.pool_length_m, b.pool_width_m, g.gyre_core_m
    if g.gyre_law == CELL:
        ax, ay = math.pi * x / L, math.pi * y / W
        s = g.gyre * math.sqrt(2.0)
        return s * math.sin(ax) * math.cos(ay), -s * W / L * math.cos(ax) * math.sin(ay)
    dx, dy, half = x - 0.5 * L, y - 0.5 * W, 0.25 * W
    if g.gyre_law == GAUSSIAN:
        s = math.exp((half * half - dx * dx - dy * dy) / (c * c)) / half
    else:
        s = (c * c + half * half) / (c * c + dx * dx + dy * dy) / half
    return -g.gyre * s * dy, g.gyre * s * dx


@njit(cache=True)
def water_velocity(
    b: BodyParameters, g: HiddenLaws, eddies: np.ndarray, t: float, x: float, y: float
) -> tuple[float, float]:
    """Velocity of the water (m/s, pool frame): eddies, current, gyre, sloshing of the pool."""
    u, v = eddy_flow(eddies, t, x, y)
    u, v = u + g.current_x, v + g.current_y
    if g.gyre != 0.0:
        gu, gv = gyre_flow(b, g, x, y)
        u, v = u + gu, v + gv
    if g.seiche_m_s != 0.0:
        u += g.seiche_m_s * math.sin(2 * math.pi * t / g.seiche_period_s)
    return u, v
