"""One eddy that fills the pool.

Stream function sin(pi x / L) sin(pi y / W), so that no water crosses the walls; G is the largest
speed along the long walls. Source: Batchelor, An Introduction to Fluid Dynamics (1967), sec. 7.4.
"""

from __future__ import annotations

import math

from ..integrate.branchless import sin_cos
from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway", "yaw")
VARIABLES = ("place",)
STATEMENT = (
    "The water of the pool turns slowly as one eddy, so that trials are pushed differently in "
    "different places."
)
REGIME = "depends on the place in the pool"
CONFUSED_WITH = ("uniform_current", "wall_effect", "port_starboard_asymmetry")
PARAMETERS = (
    Parameter("wall_speed", "m/s", 0.01, -0.3, 0.3,
              "speed at the long walls, counter-clockwise positive", symbol="G"),
    Parameter("rotation_share", "1", 0.5, 0.0, 1.5,
              "share of the water's rotation that acts on core and head", spread=0.4, symbol="g"),
    Parameter("damping_share", "1", 0.2, 0.0, 1.5, "share of it relative to which yaw is damped",
              spread=0.4, symbol="d"),
)  # fmt: skip


def water(
    x: float, y: float, psi: float, L_pool: float, W_pool: float, G: float, g: float, d: float
) -> tuple[float, float, float, float]:
    """Velocity of the water in the pool frame (m/s) and its turning of a line along psi (rad/s).

    The line e = (cos psi, sin psi) with n to its left turns at n . (e . grad) w, of which a body
    that spans a part of the eddy feels a share g.
    """
    sx, cx = sin_cos(math.pi * x / L_pool)
    sy, cy = sin_cos(math.pi * y / W_pool)
    s, c = sin_cos(psi)
    aspect = W_pool / L_pool
    stretch, up, right = cx * cy / L_pool, sx * sy / W_pool, aspect * sx * sy / L_pool
    turning = G * math.pi * (s * s * up + c * c * right - 2.0 * s * c * stretch)
    return G * sx * cy, -G * aspect * cx * sy, g * turning, d * turning
