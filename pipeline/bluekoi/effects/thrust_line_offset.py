"""Thrust that misses the centre of mass when the head is turned.

    N = T d (sin(phi) + w (phi - sin(phi)))

The head's mass swings to one side with phi, and with it the centre of mass: with sin(phi) about a
hinge (w = 0); w is the part that grows with phi itself, as of a body that bends along an arc. A
jet that follows the turned body (sin 2 phi) has a w below 0, up to 45 degrees.
Vanishes with the head straight. Source: rigid-body statics; MODEL equations place T through the
centre of mass.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw",)
VARIABLES = ("head angle",)
STATEMENT = "With the head turned, the thrust misses the centre of mass and turns the robot."
REGIME = "turns, in proportion to thrust; also before it moves"
CONFUSED_WITH = ("head_angle_offset", "trim_moment", "stall")
PARAMETERS = (
    Parameter("offset", "m", 0.003, -0.05, 0.05,
              "of the line of thrust at a head angle of 90 degrees", symbol="d"),
    Parameter("linear_share", "1", 0.0, -4.0, 4.0, "part that grows with the angle, not its sine",
              spread=1.5, symbol="w"),
)  # fmt: skip


def force(T: float, phi: float, sphi: float, d: float, w: float) -> tuple[float, float, float]:
    """Yaw moment alone (N m)."""
    return 0.0, 0.0, T * d * (sphi + w * (phi - sphi))
