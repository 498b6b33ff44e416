"""Side force of core and tail as a fin, in core axes, for water of 1000 kg/m^3.

Each law returns the force (complex, N) at a point `arm` behind the centre of mass. u is the forward
speed there, w the sideways speed, positive to the left; the force acts against w.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
HALF_DENSITY = 500.0
SLOPE = 1.6
"""Lift slope per radian, pi/2 times an aspect ratio of about one (Jones 1946, NACA Report 835)."""


@dataclass(frozen=True)
class Fin:
    """A law with its area (m^2), arm behind the centre of mass (m), cross-flow drag coefficient
    (1) and angle at which it stalls (rad).
    """

    law: Callable[[Array, Array, Fin], Array]
    area: float
    arm: float
    cross: float = 1.2
    onset: float = 0.35


def fin_force(flow: Array, rate: Array, fin: Fin) -> tuple[Array, Array]:
    """Force (N, complex) and moment about the centre of mass (N m) of a fin."""
    force = fin.law(flow.real, flow.imag - fin.arm * rate, fin)
    return force, -fin.arm * force.imag


def low_aspect_ratio(u: Array, w: Array, fin: Fin) -> Array:
    """Y = -1/2 rho S a |u| w. Jones 1946, NACA Report 835: slender wing of low aspect ratio."""
    return -1j * HALF_DENSITY * fin.area * SLOPE * np.abs(u) * w


def with_crossflow(u: Array, w: Array, fin: Fin) -> Array:
    """Y = -1/2 rho S (a |u| w + C_c |w| w). Whicker and Fehlner 1958, DTMB Report 933."""
    return -1j * HALF_DENSITY * fin.area * (SLOPE * np.abs(u) + fin.cross * np.abs(w)) * w


def polhamus(u: Array, w: Array, fin: Fin) -> Array:
    """C_N = K_p sin a cos a + K_v sin^2 a, normal to the plate. Polhamus 1966, NASA TN D-3767."""
    speed = np.hypot(u, w)
    sine, cosine = w / np.maximum(speed, 1e-9), np.abs(u) / np.maximum(speed, 1e-9)
    normal = SLOPE * sine * cosine + np.pi * sine * np.abs(sine)
    return -1j * HALF_DENSITY * fin.area * speed**2 * normal


def stalling(u: Array, w: Array, fin: Fin) -> Array:
    """Attached lift that gives way to 1.2 sin a beyond an onset. Hoerner 1975, Fluid-Dynamic Lift,
    chapter XVII; the blend is that of Beard and McLain 2012, Small Unmanned Aircraft, Eq. 4.10.
    """
    speed = np.hypot(u, w)
    attack = np.arctan2(w, np.abs(u) + 1e-9)
    stalled = 0.5 * (1 + np.tanh((np.abs(attack) - fin.onset) / 0.06))
    C = (1 - stalled) * SLOPE * np.sin(attack) * np.cos(attack) + stalled * 1.2 * np.sin(attack)
    return -1j * HALF_DENSITY * fin.area * speed**2 * C


def lighthill(u: Array, w: Array, fin: Fin) -> Array:
    """Y = -m u w, X = 1/2 m w^2 with m = rho S a / 2, the momentum shed at the trailing edge.

    Lighthill 1971, Proc. R. Soc. B 179, 125-138, large-amplitude elongated-body theory, steady.
    """
    m = HALF_DENSITY * fin.area * SLOPE
    return 0.5 * m * w**2 - 1j * m * np.abs(u) * w


def with_induced_drag(u: Array, w: Array, fin: Fin) -> Array:
    """Y = -1/2 rho S a V w, X = -1/2 rho S C_L^2 / (pi e AR), e AR = 1. Prandtl 1918."""
    speed = np.hypot(u, w)
    C_L = SLOPE * w / np.maximum(speed, 1e-9)
    return HALF_DENSITY * fin.area * speed**2 * (-1j * C_L - C_L**2 / np.pi * np.sign(u))


FINS = (low_aspect_ratio, with_crossflow, polhamus, stalling, lighthill, with_induced_drag)
