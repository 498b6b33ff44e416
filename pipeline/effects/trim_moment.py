"""A robot that is not quite symmetric.

    N = 1/2 rho A c V^2

Vanishes at rest; turns a robot with a straight head, always to the same side.
Source: Fossen (2011), sec. 7.1 (asymmetric hull terms).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw",)
STATEMENT = (
    "A small lasting turning moment acts even with the head straight: the robot is out of trim."
)
REGIME = "all trials, to one side, straight runs most visibly"
CONFUSED_WITH = ("head_angle_offset", "port_starboard_asymmetry", "keypoint_bias")
PARAMETERS = (
    Parameter("c", "m", 0.001, -0.1, 0.1, "moment per 1/2 rho A V^2, counter-clockwise positive"),
)


def force(rho: float, A: float, V: float, c: float) -> tuple[float, float, float]:
    """Yaw moment alone (N m)."""
    return 0.0, 0.0, 0.5 * rho * A * c * V * V
