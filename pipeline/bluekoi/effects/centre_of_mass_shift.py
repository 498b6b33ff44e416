"""A centre of mass that is not where it was said to be.

All forces of the head act at an arm shorter by d, the thrust along the core's axis makes no moment,
and the keypoint core_center lies at distance d from the centre of mass along the core.
Source: rigid-body statics.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw",)
VARIABLES = ("head angle",)
STATEMENT = "The centre of mass lies further forward or back along the core than the study says."
REGIME = "all turns"
CONFUSED_WITH = ("head_angle_offset", "stall", "tail_fin_lift")
PARAMETERS = (Parameter("d", "m", 0.005, -0.08, 0.08, "shift towards the head"),)


def force(Xh: float, Yh: float, cphi: float, sphi: float, d: float) -> tuple[float, float, float]:
    """Yaw moment alone (N m): the side force of the head along the core, with its arm shortened."""
    return 0.0, 0.0, -d * (Yh * cphi - Xh * sphi)


def observe(cpsi: float, spsi: float, d: float) -> tuple[float, float, float, float]:
    """The keypoint lies behind the centre of mass by d (m)."""
    return -d * cpsi, -d * spsi, 0.0, 0.0
