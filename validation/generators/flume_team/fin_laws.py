"""Side force (N) of core and tail as a fin.

Arguments of each: u, w forward and sideways speed at the fin (m/s), area (m^2, with the slope),
onset (rad). w > 0 is leftward, and so is a positive force.
"""

from __future__ import annotations

import numpy as np

from .form import Array

HALF_DENSITY = 500.0


def forward_times_sideways(u: Array, w: Array, area: float, _: float) -> Array:
    """-rho/2 S |u| w: slender body with a sharp end (Lighthill 1970, J. Fluid Mech. 44)."""
    return -HALF_DENSITY * area * np.abs(u) * w


def speed_times_sideways(u: Array, w: Array, area: float, _: float) -> Array:
    """-rho/2 S V w: lift proportional to sin beta (Hoerner and Borst 1975, ch. 3)."""
    return -HALF_DENSITY * area * np.hypot(u, w) * w


def suction_analogy(u: Array, w: Array, area: float, _: float) -> Array:
    """-rho/2 S (sin b cos^2 b + 0.8 sin^2 b cos b) V^2 (Polhamus 1966, NASA TN D-3767)."""
    speed = np.hypot(u, w) + 1e-9
    sine, cosine = w / speed, np.abs(u) / speed
    potential, vortex = sine * cosine**2, 0.8 * sine * np.abs(sine) * cosine
    return -HALF_DENSITY * area * speed**2 * (potential + vortex)


def stalling_fin(u: Array, w: Array, area: float, onset: float) -> Array:
    """-rho/2 S |u| w / (1 + (beta/(2 onset))^4)^(1/2): stall (Hoerner and Borst 1975, ch. 4)."""
    beta = np.arctan2(np.abs(w), np.abs(u) + 1e-9)
    return -HALF_DENSITY * area * np.abs(u) * w / np.sqrt(1 + (beta / (2 * onset)) ** 4)


LAWS = {
    law.__name__: law
    for law in (forward_times_sideways, speed_times_sideways, suction_analogy, stalling_fin)
}
"""Forms of `tail_fin_lift` by name."""
