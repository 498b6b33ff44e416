"""A residual drag that rises or falls about one speed.

    dX = -h (1/2 rho A) V u / (1 + ((V - c) / w)^2)^2

as where waves of the robot and of the pool's walls meet.
Source: own statement.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "residual"
CHANNELS = ("surge",)
VARIABLES = ("speed",)
STATEMENT = "The drag rises or falls about one speed."
SPEEDS = (0.15, 0.2, 0.26, 0.42, 0.53)
NARROW = 0.05
"""Other speeds are tried with this width: tries of several shapes go together, one by one."""
PARAMETERS = (
    Parameter("added_drag", "1", 0.1, -5.0, 5.0,
              "drag coefficient added at that speed, of the head plate", symbol="h"),
    Parameter("centre_speed", "m/s", 0.33, 0.05, 1.0, "speed of the largest change",
              tries=SPEEDS, symbol="c"),
    Parameter("width", "m/s", 0.07, 0.03, 0.25, "width in speed",
              tries=(NARROW,) * len(SPEEDS), symbol="w"),
)  # fmt: skip


def force(
    rho: float, A: float, uc: float, V: float, h: float, c: float, w: float
) -> tuple[float, float, float]:
    """Surge, sway (N) and yaw (N m)."""
    q = (V - c) / w
    e = 1.0 + q * q
    return -h * 0.5 * rho * A * V * uc / (e * e), 0.0, 0.0
