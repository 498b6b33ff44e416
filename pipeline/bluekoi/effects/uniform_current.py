"""Water that moves evenly through the pool.

    w = (c_x, c_y) everywhere; all forces depend on the velocity relative to it.

Source: Fossen (2011), sec. 8.3 (relative velocity in an irrotational current).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
VARIABLES = ("current",)
STATEMENT = (
    "The water itself moves, the same everywhere: the robot is carried along, and turn "
    "circles drift."
)
REGIME = "all trials, in a fixed direction of the pool"
CONFUSED_WITH = ("pool_gyre", "keypoint_bias", "trim_moment")
STRENGTHS = 2
PARAMETERS = (
    Parameter("c_x", "m/s", 0.005, -0.3, 0.3, "current along the pool's x"),
    Parameter("c_y", "m/s", 0.005, -0.3, 0.3, "current along the pool's y"),
)


def water(c_x: float, c_y: float) -> tuple[float, float, float, float]:
    """Velocity of the water in the pool frame (m/s); it does not turn (rad/s)."""
    return c_x, c_y, 0.0, 0.0
