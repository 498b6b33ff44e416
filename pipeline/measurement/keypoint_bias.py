"""A keypoint that is always placed beside its true point.

The core centre is seen displaced by (bx, by) along and across the core.
Source: own statement.
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "measurement"
CHANNELS = ("sway", "yaw")
STATEMENT = "A keypoint is always placed beside its true point on the robot."
REGIME = "all frames, fixed to the robot"
CONFUSED_WITH = ("centre_of_mass_shift", "trim_moment", "camera_shift")
STRENGTHS = 2
PARAMETERS = (
    Parameter("by", "m", 0.003, -0.05, 0.05, "displacement to the left of the core"),
    Parameter("bx", "m", 0.003, -0.05, 0.05, "displacement along the core"),
)


def observe(cpsi: float, spsi: float, bx: float, by: float) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    return bx * cpsi - by * spsi, bx * spsi + by * cpsi, 0.0, 0.0
