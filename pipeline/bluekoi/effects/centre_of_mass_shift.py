"""A centre of mass displaced from the stated position.

If the centre of mass is displaced, forces act at other distances from it and cause the yaw moment

    N = -d (Y_h cos phi - X_h sin phi) + s X,   X = T + X_h cos phi + Y_h sin phi

X_h and Y_h are the forces on the head along and across the head, phi is the head angle, and T the
thrust. d is the shift of the centre of mass towards the head. It shortens the arm of the side
forces of the head by d. s is the shift to the left. Forces along the core then act at the distance
s from the centre of mass and turn the robot.

The keypoint core_center lies at (-d, -s) from the true centre of mass.

Source: rigid-body statics.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw",)
VARIABLES = ("head angle", "side")
STATEMENT = (
    "The centre of mass does not lie where the study states it: it is displaced along the core or"
    " to one side of it."
)
REGIME = "all turns; a shift to one side also in straight runs"
CONFUSED_WITH = ("head_angle_offset", "stall", "tail_fin_lift", "keypoint_bias")
STRENGTHS = 2
PARAMETERS = (
    Parameter("forward_shift", "m", 0.005, -0.08, 0.08, "shift towards the head", symbol="d"),
    Parameter("left_shift", "m", 0.003, -0.04, 0.04, "shift to the left of the core", symbol="s"),
)  # fmt: skip


def force(
    T: float, Xh: float, Yh: float, cphi: float, sphi: float, d: float, s: float
) -> tuple[float, float, float]:
    """Yaw moment alone (N m)."""
    along, across = T + Xh * cphi + Yh * sphi, Yh * cphi - Xh * sphi
    return 0.0, 0.0, s * along - d * across


def observe(cpsi: float, spsi: float, d: float, s: float) -> tuple[float, float, float, float]:
    """The keypoint lies behind the centre of mass by d and to its right by s (m)."""
    return s * spsi - d * cpsi, -s * cpsi - d * spsi, 0.0, 0.0
