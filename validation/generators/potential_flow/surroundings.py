"""Laws of currents, walls, added mass and balance; and the forces that no listed cause is."""

from __future__ import annotations

import numpy as np

from .craft import RHO, spheroid_added_mass

# Velocity of the water, complex, pool axes, m/s; k in m/s.


def current_constant(s, k, p):
    """Value k in the direction `bearing`."""
    return k * np.exp(1j * p["bearing"]) + 0 * s.place


def current_drifting(s, k, p):
    """Turns through the session by `turn` rad from the first to the last trial."""
    return k * np.exp(1j * (p["bearing"] + p["turn"] * s.order / 23)) + 0 * s.place


def current_sheared(s, k, _):
    """Along x, from 0.4 k at one long wall to 1.6 k at the other."""
    return k * (0.4 + 1.2 * s.place.imag / s.pool[1]) + 0j


def _offset_from_centre(s, profile):
    """Circulation about the middle of the pool with the speed profile(distance)."""
    out = s.place - (s.pool[0] + 1j * s.pool[1]) / 2
    far = np.abs(out) + 1e-9
    return 1j * out / far * profile(far)


def gyre_cell(s, k, _):
    """Stream function sin(pi x/L) sin(pi y/W): the gravest cell; k the largest speed."""
    L, W = s.pool[:2]
    X, Y = np.pi * s.place.real / L, np.pi * s.place.imag / W
    return k * (-np.sin(X) * np.cos(Y) + 1j * W / L * np.cos(X) * np.sin(Y))


def gyre_two_cells(s, k, _):
    """Stream function sin(2 pi x/L) sin(pi y/W): two cells that turn opposite ways."""
    L, W = s.pool[:2]
    X, Y = 2 * np.pi * s.place.real / L, np.pi * s.place.imag / W
    return k * (-np.sin(X) * np.cos(Y) + 2j * W / L * np.cos(X) * np.sin(Y))


def gyre_lamb_oseen(s, k, p):
    """Value k 1.4 (c/d) (1 - e^(-(d/c)^2 1.26)): Lamb-Oseen vortex with its peak at c."""
    return _offset_from_centre(
        s, lambda d: k * 1.4 * p["c"] / d * (1 - np.exp(-1.256 * (d / p["c"]) ** 2))
    )


def gyre_scully(s, k, p):
    """2 k c d / (c^2 + d^2): Scully's vortex (1975)."""
    return _offset_from_centre(s, lambda d: 2 * k * p["c"] * d / (p["c"] ** 2 + d**2))


# Walls: sums over the four, gap g of the centre of mass, unit vectors away from the wall.


def _walls(s):
    x, y, (L, W, _) = s.place.real, s.place.imag, s.pool
    return ((x, 1.0), (L - x, -1.0), (y, 1j), (W - y, -1j))


def _wall(s, k, nearness, away: bool):
    total = 0.0
    for gap, normal in _walls(s):
        near = k * s.q * s.V**2 * nearness(np.maximum(gap, 0.02))
        total = total + (near * normal * np.conj(s.turn) if away
                         else -near * s.v / (s.V + 1e-9))  # fmt: skip
    return total, 0.0


def wall_exponential(s, k, p):
    """Drag k q e^(-g/reach) of each wall (blockage)."""
    return _wall(s, k, lambda g: np.exp(-g / p["reach"]), away=False)


def wall_power(s, k, p):
    """Drag k q (reach/g)^2."""
    return _wall(s, k, lambda g: (p["reach"] / g) ** 2, away=False)


def wall_suction(s, k, p):
    """Towards the wall, k q (reach/g)^3: the body and its image (Milne-Thomson)."""
    force, moment = _wall(s, k, lambda g: (p["reach"] / g) ** 3, away=True)
    return -force, moment


def wall_cushion(s, k, p):
    """Away from the wall, k q e^(-(g/reach)^2)."""
    return _wall(s, k, lambda g: np.exp(-((g / p["reach"]) ** 2)), away=True)


# Added mass in the core's axes: surge, sway (kg), coupling (kg m), yaw (kg m^2); k a factor.


def added_mass_spheroid(s, k, _):
    """Prolate spheroid of the body's length and height (Lamb, section 114)."""
    ax, ay, j = spheroid_added_mass(s.craft.body_length, s.craft.span)
    return k * ax, k * ay, 0.0, k * j


def _strips(craft, height):
    x, dx = craft.stations(24)
    a = RHO * np.pi / 4 * height(x) ** 2 * dx
    return a.sum(), (a * x).sum(), (a * x**2).sum()


def added_mass_slender(s, k, _):
    """Masses rho pi h^2/4 of each section of core and tail, with coupling (Lighthill 1960)."""
    ay, c, j = _strips(s.craft, lambda x: s.craft.span + 0 * x)
    return 0.0, k * ay, k * c, k * j


def added_mass_tapered(s, k, _):
    """The same with a tapering tail and a surge mass of a tenth of the sway mass."""
    ay, c, j = _strips(s.craft, lambda x: s.craft.span * (1 - 0.6 * (x[0] - x) / (x[0] - x[-1])))
    return 0.1 * k * ay, k * ay, k * c, k * j


def added_mass_munk(s, k, _):
    """Only the Munk moment N = -(A_y - A_x) u w of the spheroid (Munk 1924), k its share."""
    ax, ay, _ = spheroid_added_mass(s.craft.body_length, s.craft.span)
    return 0.0, -k * (ay - ax) * s.core.real * s.core.imag


# Balance: the centre of mass ahead of `core_center`, complex, head's axes, m.


def mass_shift_along_core(s, k, _):
    """Value k along the core."""
    return k * np.exp(1j * s.phi)


def mass_shift_with_angle(s, k, _):
    """Battery that slides aft with the turned head: -k (1 - cos phi) 4 along the core."""
    return -4 * k * (1 - np.cos(s.phi)) * np.exp(1j * s.phi)


def mass_shift_with_head(s, k, _):
    """A heavier head: k along the head, growing with its length."""
    return k * s.head / s.craft.head_length + 0 * s.phi


# No listed cause: force and moment.


def unlisted_heading(s, k, p):
    """N = k sin(2 theta + c): a tether or the earth's field."""
    return 0.0, k * np.sin(2 * s.theta + p["c"])


def unlisted_place(s, k, p):
    """Surge force k sin(2 pi x / length + c), at speed."""
    at = 2 * np.pi * s.place.real / p["length"] + p["c"]
    return k * np.sin(at) * np.tanh(s.V / 0.05) + 0j, 0.0


def unlisted_time(s, k, p):
    """Sway force k sin(2 pi t / period), at speed."""
    return 1j * k * np.sin(2 * np.pi * s.t / p["period"]) * np.tanh(s.V / 0.05), 0.0


def unlisted_beat(s, k, _):
    """N = k sin(phase/6): every sixth beat, a slipping gear."""
    return 0.0, k * np.sin(s.phase / 6)


def unlisted_rate_angle(s, k, _):
    """Surge force k r phi (even under reflection)."""
    return k * s.r * s.phi + 0j, 0.0


def unlisted_compass(s, k, p):
    """Sway force k V cos(theta - c)."""
    return 1j * k * s.V * np.cos(s.theta - p["c"]), 0.0


def unlisted_saddle(s, k, _):
    """N = k V (x - L/2)(y - W/2) / (L W / 4)."""
    out = s.place - (s.pool[0] + 1j * s.pool[1]) / 2
    return 0.0, k * s.V * out.real * out.imag / (s.pool[0] * s.pool[1] / 4)


def unlisted_speed(s, k, p):
    """Surge force k sin(2 pi V / scale): vibration that comes and goes with speed."""
    return -k * np.sin(2 * np.pi * s.V / p["scale"]) * s.v / (s.V + 0.02), 0.0
