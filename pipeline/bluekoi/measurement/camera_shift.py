"""A camera that was moved between or during trials.

From some moment of a trial on, all measured positions are displaced by (dx, dy). Before the fit,
the finder tests every moment of every trial for such a displacement
(mismatch/camera_displacement.py). It fits a displacement only if this test finds it probable. The
fit uses the moment found by the test.

If the camera moved in several trials, (dx, dy) is the displacement in the trial in which it is the
most certain. The displacements of all trials have fixed ratios to it. With positions as complex
numbers x + i y, the displacement in trial n is (a_n + i b_n)(dx + i dy). The test gives the ratios
a_n + i b_n, and the fit does not change them.

Source: own statement.
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("sway", "yaw")
EFFECT_DESCRIPTION = "The camera was moved: from some time on, all positions are displaced."
MOST_VISIBLE_WHERE = "all positions from one trial or time on"
CONFUSED_WITH = ("keypoint_bias", "uniform_current")
STRENGTH_PARAMETER_COUNT = 2
EFFECT_PARAMETERS = (
    Parameter(
        "dx", "m", 0.005, -0.3, 0.3, "displacement in x in the trial where it is most certain"
    ),
    Parameter(
        "dy", "m", 0.005, -0.3, 0.3, "displacement in y in the trial where it is most certain"
    ),
)


def observe(
    t: float, time_unit: float, t_shift: float, x_shift: float, y_shift: float, dx: float, dy: float
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    late = smooth_step((t - t_shift) * 30.0 / time_unit)
    return late * (x_shift * dx - y_shift * dy), late * (y_shift * dx + x_shift * dy), 0.0, 0.0
