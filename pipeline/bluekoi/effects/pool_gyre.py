"""One eddy that fills the pool.

The velocity of the water is a weighted sum of two flows. The flow with the weight 1 - b is a cell:
an eddy that fills the pool. The flow with the weight b is a vortex about the middle of the pool.

No water of the cell crosses the walls. At the position (x, y) in a pool of the length L and the
width W, the stream function of the cell is proportional to

    (1 - c) sin(pi x / L) sin(pi y / W) + c sin(2 pi x / L) sin(pi y / W)

- c: weight of two eddies side by side, which rotate in opposite directions. With c = 0, one eddy
  fills the pool;
- G: largest speed of the cell along the long walls (m/s).

At the distance D from the middle of the pool, the speed of the water in the vortex is

    U = 2 G (D / a) / (1 + (D / a)^2)

- a: radius of the vortex core (m). With a large a, the water rotates like a rigid body;
- G: largest speed of the vortex (m/s), reached at D = a.

All forces depend on the velocity of the robot relative to the water at its position. The water also
rotates there: Omega is the angular velocity of a line along the robot that moves with the water. In
the formula of the yaw damping, C_Md r |r|, the yaw rate r is reduced by d Omega. In all other
forces, the rotation of the water counts as g Omega: it reduces the yaw rate, and, by l g Omega, the
sideways velocity of the head plate, a distance l ahead of the centre of mass. The factors d and g
are below 1 if the robot spans a part of the eddy, and therefore feels only a share of Omega.

Source: Batchelor, An Introduction to Fluid Dynamics (1967), sec. 7.4 (cell); Scully, MIT ASRL TR
178-1 (1975), and Kaufmann, Ing.-Arch. 31 (1962), 1 (vortex).
"""

from __future__ import annotations

import math

from ..integrate.branchless import sin_cos
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway", "yaw")
DEPENDS_ON_VARIABLES = ("place",)
EFFECT_DESCRIPTION = (
    "The water of the pool rotates slowly as one eddy, so that the current depends on the "
    "position in the pool."
)
MOST_VISIBLE_WHERE = "all trials, differently at each position in the pool"
CONFUSED_WITH = ("uniform_current", "wall_effect", "port_starboard_asymmetry")
EFFECT_PARAMETERS = (
    Parameter("wall_speed", "m/s", 0.01, -0.3, 0.3,
              "speed at the long walls, counter-clockwise positive", symbol="G"),
    Parameter("rotation_share", "1", 0.5, 0.0, 1.5,
              "share of the water's rotation that acts on core and head", spread=0.4, symbol="g"),
    Parameter("damping_share", "1", 0.2, 0.0, 1.5,
              "share of the water's rotation that acts in the yaw damping", spread=0.4, symbol="d"),
    Parameter("vortex_share", "1", 0.0, 0.0, 1.0, "weight of a vortex about the middle",
              spread=0.5, symbol="b"),
    Parameter("two_cell_share", "1", 0.0, 0.0, 1.0, "weight of two eddies side by side",
              spread=0.5, symbol="c"),
    Parameter("core_radius", "m", 0.6, 0.15, 3.0, "radius of the core of the vortex",
              spread=0.4, symbol="a"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "cell": {},
    "vortex": {"vortex_share": 1.0},
    "solid body": {"vortex_share": 1.0, "core_radius": 1.2},
    "two cells": {"two_cell_share": 1.0},
}


def ambient_flow(
    x: float, y: float, psi: float, L_pool: float, W_pool: float,
    G: float, g: float, d: float, b: float, c: float, a: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Velocity of the water in the pool frame (m/s) and its turning of a line along psi (rad/s).

    The line e = (cos psi, sin psi) with n to its left turns at n . (e . grad) w, of which a body
    that spans a part of the eddy feels a share g.
    """
    sx, cx = sin_cos(math.pi * x / L_pool)
    sy, cy = sin_cos(math.pi * y / W_pool)
    s2, c2 = 2.0 * sx * cx, cx * cx - sx * sx  # sine and cosine of 2 pi x / L
    spsi, cpsi = sin_cos(psi)
    # X(x) of the stream function X sin(pi y / W), its slope times L / pi, curvature -(L / pi)^2
    X, slope, curvature = sx + c * (s2 - sx), cx + c * (2.0 * c2 - cx), sx + c * (4.0 * s2 - sx)
    aspect = W_pool / L_pool
    stretch, up = slope * cy / L_pool, X * sy / W_pool
    right = aspect * curvature * sy / L_pool
    cell = math.pi * (spsi * spsi * up + cpsi * cpsi * right - 2.0 * spsi * cpsi * stretch)
    dx, dy = x - 0.5 * L_pool, y - 0.5 * W_pool
    e = 1.0 + (dx * dx + dy * dy) / (a * a)
    rate, along = 2.0 / (a * e), dx * cpsi + dy * spsi
    vortex = rate - 2.0 * rate / (a * a * e) * along * along
    turning = G * (cell + b * (vortex - cell))
    return (
        G * (X * cy + b * (-rate * dy - X * cy)),
        G * (-aspect * slope * sy + b * (rate * dx + aspect * slope * sy)),
        g * turning,
        d * turning,
    )
