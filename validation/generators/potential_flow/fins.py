"""Core and tail as a fin, and cross-flow along them: forces of the body's after part.

Each law returns the force (complex, head's axes, N) and its moment (N m). Speeds along the core
are those of the core's axes: `core` = u_c + i w_c, and w_c + x r at the station x ahead of the
centre of mass, m.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .craft import RHO

PANEL_COUNT = 4
WAKE_LAG_CHORDS = 1.0
"""Chords of travel in which the wake's downwash grows (1/e)."""


@lru_cache(maxsize=64)
def lattice_circulations(chord: float, height: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Circulations for a unit normal speed at each panel, (PANELS, PANELS), m; bound x; control x.

    Horseshoe vortices at a quarter of each panel, no flow through three quarters of it. A
    vortex of span h with its two legs induces at the distance d behind its middle
    w = Gamma / (2 pi h) (1 + sqrt(d^2 + h^2/4) / d) ... Katz and Plotkin, Low-Speed Aerodynamics,
    equation 12.13 at mid-span. x from the leading edge, positive aft, m.
    """
    width = chord / PANEL_COUNT
    bound = width * (np.arange(PANEL_COUNT) + 0.25)
    control = bound + width / 2
    d = control[:, None] - bound[None, :]
    half = height / 2
    induced = (1 + np.sqrt(d**2 + half**2) / d) / (2 * np.pi * half)
    return np.linalg.inv(induced), bound, control


def _total_load(s, x, side):
    """Sum of side forces `side` (stations, n) across the core at x, in the head's axes."""
    x = np.reshape(x, (-1,) + (1,) * (np.ndim(side) - 1))
    return 1j * np.exp(1j * s.phi) * side.sum(axis=0), (x * side).sum(axis=0)


def _sideways_speed(s, x):
    """Sideways speed of the core at x, m/s."""
    return s.core.imag + x * s.r


def _tail_velocity(s):
    return -s.craft.stern - 0.5 * s.craft.tail_length


def lattice_fin(s, k, _):
    """Y_j = -rho |u| Gamma_j h on each panel, Gamma = G w / 2 (1 + m): half at once, half late."""
    craft = s.craft
    chord = craft.stern + craft.tail_length
    G, bound, control = lattice_circulations(round(chord, 4), round(0.8 * craft.span, 4))
    w = np.array([_sideways_speed(s, -x) for x in control])
    late = s.memory[0] - _sideways_speed(s, -0.5 * chord)
    gamma = np.tensordot(G, w + 0.5 * late, axes=1)
    return _total_load(s, -bound, -k * RHO * np.abs(s.core.real) * 0.8 * craft.span * gamma)


def lattice_wake(s, _):
    """State of the wake: the mid-chord's sideways speed, late by LAG chords of travel."""
    chord = s.craft.stern + s.craft.tail_length
    now = _sideways_speed(s, -0.5 * chord)
    return ((now - s.memory[0]) * (s.V + 0.02) / (WAKE_LAG_CHORDS * chord))[None]


def lighthill_fin(s, k, _):
    """Y = -m_a u w at the trailing edge, m_a = rho pi h^2 / 4 (Lighthill 1970, reactive force)."""
    x = -s.craft.stern - s.craft.tail_length
    m_a = RHO * np.pi * s.craft.span**2 / 4
    return _total_load(s, [x], -k * m_a * np.abs(s.core.real) * _sideways_speed(s, x)[None])


def _fin_side_force(s, k, coefficient):
    """Y = -k rho/2 S V_x^2 C_N(a), a the angle of attack at the tail."""
    w, u = _sideways_speed(s, _tail_velocity(s)), s.core.real
    V = np.sqrt(u**2 + w**2) + 1e-9
    S = 0.5 * s.craft.span * s.craft.tail_length * 2
    return _total_load(
        s, [_tail_velocity(s)], (-k * RHO / 2 * S * V**2 * coefficient(w / V, np.abs(u) / V))[None]
    )


def polhamus_fin(s, k, p):
    """C_N = K_p sin a cos a + K_v sin a |sin a| (Polhamus 1966, leading-edge suction analogy)."""
    return _fin_side_force(s, k, lambda sin, cos: p["K_p"] * sin * cos + np.pi * sin * np.abs(sin))


def resultant_fin(s, k, _):
    """C_N = 2 sin a: linear in the sideways speed, growing with the whole speed."""
    return _fin_side_force(s, k, lambda sin, _: 2 * sin)


def separating_fin(s, k, p):
    """C_N = 2 sin a cos a / (1 + (sin a / sin a_s)^2): separates beyond a_s."""
    return _fin_side_force(s, k, lambda sin, cos: 2 * sin * cos / (1 + (sin / p["onset"]) ** 2))


def crossflow_strips(s, k, p):
    """Y = -k rho/2 h |w|w dx along core and tail (Hoerner 1965; k the drag coefficient)."""
    return _crossflow(s, k, 2.0, lambda x: 1 + 0 * x, p)


def crossflow_tapered(s, k, p):
    """The same with a height that falls to 30 % at the tail's tip."""
    return _crossflow(s, k, 2.0, lambda x: 1 - 0.7 * (x[0] - x) / (x[0] - x[-1]), p)


def crossflow_power(s, k, p):
    """Y ~ |w|^n, n between 1.5 and 1.8, the same as the square at 0.1 m/s."""
    return _crossflow(s, k, p["power"], lambda x: 1 + 0 * x, p)


def crossflow_reynolds(s, k, p):
    """Y = -k (1 + w_0/|w|) |w|w: drag coefficient of a cylinder falling with Reynolds number."""
    x, dx = s.craft.stations()
    w = np.array([_sideways_speed(s, a) for a in x])
    return _total_load(s, x, -k * RHO / 2 * s.craft.span * dx * w * (np.abs(w) + p["w_0"]))


def _crossflow(s, k, power, height, _):
    x, dx = s.craft.stations()
    w = np.array([_sideways_speed(s, a) for a in x])
    h = s.craft.span * height(x).reshape((-1,) + (1,) * (w.ndim - 1))
    size = 0.01 * np.sign(w) * (np.abs(w) / 0.1) ** power
    return _total_load(s, x, -k * RHO / 2 * h * dx * size)
