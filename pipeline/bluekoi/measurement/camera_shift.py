"""A camera that was moved between or during trials.

From the time t_shift of a trial on, all positions are displaced by (dx, dy).

If the camera moved in several trials, (dx, dy) is the displacement in the trial that determines it
best. The displacements in the other trials are proportional to it, with a rotation and scale
(x_shift, y_shift) that is fixed at its first estimate. For a single trial, (x_shift, y_shift) is
(1, 0).

Source: own statement.
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

KIND = "measurement"
CHANNELS = ("sway", "yaw")
STATEMENT = "The camera was moved: from some time on, all positions are displaced."
REGIME = "from one trial or time on"
CONFUSED_WITH = ("keypoint_bias", "uniform_current")
STRENGTHS = 2
PARAMETERS = (
    Parameter("dx", "m", 0.005, -0.3, 0.3, "displacement in x, where it is surest"),
    Parameter("dy", "m", 0.005, -0.3, 0.3, "displacement in y, where it is surest"),
)


def observe(
    t: float, t_shift: float, x_shift: float, y_shift: float, dx: float, dy: float
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    late = smooth_step((t - t_shift) * 30.0)
    return late * (x_shift * dx - y_shift * dy), late * (y_shift * dx + x_shift * dy), 0.0, 0.0
