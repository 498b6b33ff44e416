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
STATEMENT = (
    "The water of the pool turns slowly as one eddy, so that trials are pushed differently in "
    "different places."
)
REGIME = "depends on the place in the pool"
CONFUSED_WITH = ("uniform_current", "wall_effect", "port_starboard_asymmetry")
PARAMETERS = (
    Parameter("G", "m/s", 0.01, -0.3, 0.3, "speed at the long walls, counter-clockwise positive"),
)


def water(x: float, y: float, L_pool: float, W_pool: float, G: float) -> tuple[float, float]:
    """Velocity of the water in the pool frame (m/s)."""
    sx, cx = sin_cos(math.pi * x / L_pool)
    sy, cy = sin_cos(math.pi * y / W_pool)
    return G * sx * cy, -G * (W_pool / L_pool) * cx * sy
