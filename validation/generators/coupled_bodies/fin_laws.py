"""Forces of the core and the tail: fin, cross-flow drag, damping of yaw, added masses.

Frame: along the axis of the core; u ahead and w to port are the components of the velocity through
the water, x is measured from the centre of mass ahead, m.
"""

# ruff: noqa: ARG001 - laws of one stage share their arguments

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import polars
from .form import Form, form_maker
from .robots import RHO

Array = NDArray[np.float64]
ShapeParameters = Any
FIN_POLARS = {
    stall: polars.thin_fin(np.deg2rad(stall), np.deg2rad(4)) for stall in (14, 18, 22, 28)
}
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(6)


def at_fin(c: SimpleNamespace, back: float) -> tuple[Array, Array]:
    """Place of the fin (share `back` of the way to the tip of the tail) and sideways speed."""
    x = -back * (c.robot.tail_base + c.robot.tail_length)
    return x, c.w + x * c.r_core


def _side_load(c: SimpleNamespace, Y: Array, x: Array | float) -> tuple[Any, Array]:
    return 1j * Y * c.axis, Y * x


def fin_forward(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Y = -1/2 rho S |u| w: lift of a plate of slope-area S, m^2, in forward flow (Fossen 6.5)."""
    x, w = at_fin(c, p["back"])
    return _side_load(c, -0.5 * RHO * s * np.abs(c.u) * w, x)


def fin_speed(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Y = -1/2 rho S V w with the speed at the fin: quasi-steady strip."""
    x, w = at_fin(c, p["back"])
    return _side_load(c, -0.5 * RHO * s * np.hypot(c.u, w) * w, x)


def fin_polhamus(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Potential and vortex lift, K_p sin cos + K_v sin^2 (Polhamus 1966, NASA TN D-3767)."""
    x, w = at_fin(c, p["back"])
    return _side_load(c, -0.5 * RHO * s * (np.abs(c.u) + p["vortex"] * np.abs(w)) * w, x)


def fin_trailing_edge(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Y = -m_a |u| w at the trailing edge, and its suction m_a w^2/2 (Lighthill 1971, eq. 5)."""
    x, w = at_fin(c, p["back"])
    F, N = _side_load(c, -RHO * 0.5 * s * np.abs(c.u) * w, x)
    return F - RHO * 0.25 * s * w**2 * np.sign(c.u) * c.axis, N


def fin_stalling(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """Lift and drag of a fin polar over the full circle, which stalls at 14 to 28 deg."""
    x, w = at_fin(c, p["back"])
    flow = c.u + 1j * w
    V = np.abs(flow)
    alpha = -np.angle(flow)
    stall = min(FIN_POLARS, key=lambda k: abs(k - p["stall_deg"]))
    lift, drag = polars.interpolate_polar(FIN_POLARS[stall], alpha)
    F = 0.5 * RHO * s * V * flow * (1j * lift - drag)
    return F * c.axis, F.imag * x


def strip_velocities(c: SimpleNamespace) -> tuple[Array, Array, Array]:
    """Nodes (6, 1) between hinge and tail tip, m, their lengths, m, and sideways speeds."""
    front, rear = c.robot.hinge_to_com, -(c.robot.tail_base + c.robot.tail_length)
    x = ((front + rear) / 2 + (front - rear) / 2 * GAUSS)[:, None]
    return x, ((front - rear) / 2 * WEIGHTS)[:, None], c.w + x * c.r_core


def _strip_force(c: SimpleNamespace, x: Array, Y: Array) -> tuple[Any, Array]:
    return 1j * Y.sum(0) * c.axis, (x * Y).sum(0)


def cross_square(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """DY = -1/2 rho C_d b w|w| dx with uniform span b (Faltinsen 1990, sec. 6)."""
    x, dx, w = strip_velocities(c)
    return _strip_force(c, x, -0.5 * RHO * s * c.robot.span * w * np.abs(w) * dx)


def cross_power(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """DY ~ |w|^(n-1) w with n from 1.5 to 1.85, equal to the square at 0.1 m/s."""
    x, dx, w = strip_velocities(c)
    size = 0.01 * np.abs(w / 0.1) ** p["power"]
    return _strip_force(c, x, -0.5 * RHO * s * c.robot.span * np.sign(w) * size * dx)


def cross_tapered(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """As the square, with a span that falls linearly to the share `tip` at the tail."""
    x, dx, w = strip_velocities(c)
    share = (c.robot.hinge_to_com - x) / np.ptp(x)
    span = c.robot.span * (1 - (1 - p["tip"]) * np.clip(share, 0, 1))
    return _strip_force(c, x, -0.5 * RHO * s * span * w * np.abs(w) * dx)


def cross_reynolds(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """C_d (1 + 10 Re^(-2/3)) (White 1991, eq. 3-225), Re from sideways speed and width 3 cm."""
    x, dx, w = strip_velocities(c)
    size = w**2 + 10 * (0.03 / 1e-6) ** (-2 / 3) * np.abs(w) ** (4 / 3)
    return _strip_force(c, x, -0.5 * RHO * s * c.robot.span * np.sign(w) * size * dx)


def yaw_linear(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = -N_r r, N m s (Fossen 2011, eq. 6.58)."""
    return 0j, -s * c.r


def yaw_three_halves(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = -K r |r|^(1/2): laminar boundary layer on a turning plate."""
    return 0j, -s * c.r * np.sqrt(np.abs(c.r) + 1e-9)


def yaw_speed(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, Array]:
    """N = -K V r: damping of a manoeuvring derivative (Abkowitz 1964)."""
    return 0j, -s * c.V * c.r


def mass_slender(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, ...]:
    """Pi rho b^2/4 a length, from nose to tail base (Munk 1924; Lighthill 1960)."""
    rear, front = -c.robot.tail_base, c.robot.hinge_to_com + c.head
    line = s * np.pi / 4 * RHO * c.robot.span**2
    return (0 * s, line * (front - rear), line * (front**2 - rear**2) / 2,
            line * (front**3 - rear**3) / 3, 1.0)  # fmt: skip


def mass_ellipsoid(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, ...]:
    """Prolate spheroid, Lamb's k_1, k_2 and k' of sec. 115."""
    a, b = (c.robot.body_length + c.head - c.robot.head_length) / 2, c.robot.span / 2
    e = np.sqrt(1 - (b / a) ** 2)
    log = np.log((1 + e) / (1 - e))
    alpha = 2 * (1 - e**2) / e**3 * (log / 2 - e)
    beta = 1 / e**2 - (1 - e**2) / (2 * e**3) * log
    m = 4 / 3 * np.pi * RHO * a * b**2
    k = e**4 * (beta - alpha) / ((2 - e**2) * (2 * e**2 - (2 - e**2) * (beta - alpha)))
    inertia = m * (a**2 + b**2) / 5
    return s * m * alpha / (2 - alpha), s * m * beta / (2 - beta), 0.0, s * k * inertia, 1.0


def mass_strip(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, ...]:
    """Strips of elliptic span about the centre of mass, and a share `axial` of the side mass."""
    half = (c.robot.body_length + c.head - c.robot.head_length) / 2
    x = half * GAUSS[:, None]
    dm = s * np.pi / 4 * RHO * c.robot.span**2 * (1 - GAUSS[:, None] ** 2) * half * WEIGHTS[:, None]
    shift = p["shift_m"]
    side = dm.sum(0)
    return p["axial"] * side, side, side * shift, (dm * (x + shift) ** 2).sum(0), 1.0


def mass_munk(c: SimpleNamespace, s: Array, p: ShapeParameters) -> tuple[Any, ...]:
    """The slender body with a share of Munk's moment: the wake sheds the rest (Jorgensen 1977)."""
    return (*mass_slender(c, s, p)[:4], p["share"])


_fin = form_maker("tail_fin_lift", "force", "m^2", ("sway", "yaw"))
_cross = form_maker("crossflow_drag", "force", "1", ("sway", "yaw"))
_yaw = form_maker("linear_yaw_damping", "force", "N m s", ("yaw",))
_mass = form_maker("added_mass", "inertia", "1", ("surge", "sway", "yaw"))
FIN_POSITION_RANGE = (0.55, 0.85)
FORMS: tuple[Form, ...] = (
    _fin("forward", fin_forward, 1e-4, 0.06, back=FIN_POSITION_RANGE),
    _fin("speed", fin_speed, 1e-4, 0.06, back=FIN_POSITION_RANGE),
    _fin("polhamus", fin_polhamus, 1e-4, 0.06, back=FIN_POSITION_RANGE, vortex=(0.5, 1.5)),
    _fin("trailing_edge", fin_trailing_edge, 1e-4, 0.06, back=(0.75, 0.95)),
    _fin("stalling", fin_stalling, 1e-4, 0.06, back=FIN_POSITION_RANGE, stall_deg=(14, 28)),
    _cross("square", cross_square, 0.02, 30),
    _cross("power", cross_power, 0.02, 30, power=(1.5, 1.85)),
    _cross("tapered", cross_tapered, 0.02, 30, tip=(0.2, 0.6)),
    _cross("reynolds", cross_reynolds, 0.02, 30),
    _yaw("linear", yaw_linear, 1e-4, 0.2),
    _yaw("three_halves", yaw_three_halves, 1e-4, 0.2),
    _yaw("speed", yaw_speed, 1e-4, 0.5),
    _mass("slender", mass_slender, 0.01, 2),
    _mass("ellipsoid", mass_ellipsoid, 0.01, 2),
    _mass("strip", mass_strip, 0.01, 2, axial=(0.05, 0.15), shift_m=(-0.02, 0.02)),
    _mass("munk", mass_munk, 0.01, 2, share=(0.3, 0.8)),
)
