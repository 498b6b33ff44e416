"""Constant offset of a keypoint on the body.

The pose of the robot is fitted to all keypoints. A constant offset of one keypoint on the body
therefore changes the whole pose:

- `bx`, `by`: shift of the core centre along the core (the rigid body behind the head) and across
  it;
- `bpsi`: change of the heading of the core;
- `bphi`: change of the head angle.

If the marked point follows the edge of the head, it moves on the robot when the head turns. The
shift `by` across the core and the changes `bpsi` of the heading and `bphi` of the head angle are
therefore multiplied by a factor that depends on the head angle phi and a weight w:

    (1 - w) + w sin(phi) / sin(45 deg)

The offset `bx` along the core is at most 2 cm. A larger one is a `centre_of_mass_shift`.

Source: own statement.
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("sway", "yaw")
EFFECT_DESCRIPTION = "A keypoint is always marked away from its true position on the robot."
MOST_VISIBLE_WHERE = "all frames, fixed to the robot"
CONFUSED_WITH = ("centre_of_mass_shift", "trim_moment", "head_angle_offset", "camera_shift")
STRENGTH_PARAMETER_COUNT = 4
EFFECT_PARAMETERS = (
    Parameter("left_offset", "m", 0.003, -0.04, 0.04, "displacement to the left of the core",
              symbol="by"),
    Parameter("forward_offset", "m", 0.003, -0.02, 0.02, "displacement along the core",
              symbol="bx"),
    Parameter("heading_offset", "rad", 0.01, -0.25, 0.25, "error of the observed heading",
              symbol="bpsi"),
    Parameter("head_angle_offset", "rad", 0.01, -0.35, 0.35, "error of the observed head angle",
              symbol="bphi"),
    Parameter("head_angle_share", "1", 0.0, 0.0, 1.0,
              "weight of an offset proportional to the sine of the head angle", spread=0.5,
              symbol="w"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "constant": {},
    "with the head angle": {"head_angle_share": 1.0},
}


def observe(
    cpsi: float, spsi: float, sphi: float, bx: float, by: float, bpsi: float, bphi: float, w: float
) -> tuple[float, float, float, float]:
    """Change of what is seen (m, m, rad, rad)."""
    a = 1.0 - w + w * 1.4142135623730951 * sphi
    return bx * cpsi - by * a * spsi, bx * spsi + by * a * cpsi, bpsi * a, bphi * a
