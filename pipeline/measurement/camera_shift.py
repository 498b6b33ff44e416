"""A camera that was moved between trials or during one.

Trials after the shift (constant `shifted` is 1) are seen displaced by (dx, dy) and turned by dpsi.
Source: own statement.
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

KIND = "measurement"
CHANNELS = ("sway", "yaw")
STATEMENT = "The camera was moved: from some moment on everything is seen displaced."
REGIME = "from one trial or moment on"
CONFUSED_WITH = ("keypoint_bias", "uniform_current")
STRENGTHS = 2
PARAMETERS = (
    Parameter("dx", "m", 0.005, -0.3, 0.3, "displacement in x"),
    Parameter("dy", "m", 0.005, -0.3, 0.3, "displacement in y"),
)


def observe(t: float, t_shift: float, dx: float, dy: float) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    late = smooth_step((t - t_shift) * 30.0)
    return late * dx, late * dy, 0.0, 0.0
