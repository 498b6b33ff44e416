"""A camera that was moved between or during trials.

From some moment of a trial on, all positions are displaced by (dx, dy). The finder tests every
moment of every trial for such a displacement before the fit (mismatch/camera_displacement.py). Only
displacements that are probable are fitted, from the moment found.

If the camera moved in several trials, (dx, dy) is the displacement in the trial that determines it
best. In trial i, with positions as complex numbers, the displacement is (a_i + i b_i)(dx + i dy).
The test gives a_i and b_i, and the fit leaves them as they are.

Source: own statement.
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("sway", "yaw")
EFFECT_DESCRIPTION = "The camera was moved: from some time on, all positions are displaced."
MOST_VISIBLE_WHERE = "from one trial or time on"
CONFUSED_WITH = ("keypoint_bias", "uniform_current")
STRENGTH_PARAMETER_COUNT = 2
EFFECT_PARAMETERS = (
    Parameter(
        "dx", "m", 0.005, -0.3, 0.3, "displacement in x in the trial that determines it best"
    ),
    Parameter(
        "dy", "m", 0.005, -0.3, 0.3, "displacement in y in the trial that determines it best"
    ),
)


def observe(
    t: float, time_unit: float, t_shift: float, x_shift: float, y_shift: float, dx: float, dy: float
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    late = smooth_step((t - t_shift) * 30.0 / time_unit)
    return late * (x_shift * dx - y_shift * dy), late * (y_shift * dx + x_shift * dy), 0.0, 0.0
