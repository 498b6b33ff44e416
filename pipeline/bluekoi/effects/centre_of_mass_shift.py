"""A centre of mass that is not where it was said to be.

    N = -d (Y_h cos phi - X_h sin phi) + s X,   X = T + X_h cos phi + Y_h sin phi

All side forces of the head act at an arm shorter by d, the shift towards the head; what pushes
along the core passes the centre of mass at a distance s, the shift to the left, and turns the
robot. The keypoint core_center runs at (-d, -s) from the centre of mass.
Source: rigid-body statics.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw",)
VARIABLES = ("head angle", "side")
STATEMENT = (
    "The centre of mass does not lie where the study says: further along or beside the core."
)
REGIME = "all turns; beside the core also straight runs, with opposite sign to port and starboard"
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
