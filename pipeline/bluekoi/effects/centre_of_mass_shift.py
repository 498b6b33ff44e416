"""A centre of mass displaced from the stated position.

A displaced centre of mass changes the arms of the forces. This causes the additional yaw moment

    N = -e (Y_h cos phi - X_h sin phi) + s X,   X = T + X_h cos phi + Y_h sin phi
    e = d ((1 - w) + w |sin phi| / sin 45 deg)

- X_h, Y_h: forces on the head plate, along it and across it; phi: head angle;
- X: force of thrust T and head along the core, the rigid body behind the head;
- e: shift of the centre of mass towards the head (m). It shortens the arm of the side force of the
  head;
- d: value of e at a head angle of 45 deg (m);
- w: weight of a shift that grows with the head angle, because turning the head moves its mass. With
  w = 0, e is d at every head angle;
- s: shift of the centre of mass to the left (m). It is the arm of the force X.

The keypoint core_center marks the stated centre of mass. In the axes of the core, it lies at
(-e, -s) from the true centre of mass: the distance e behind it and the distance s to its right.

Source: rigid-body statics.
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("yaw",)
DEPENDS_ON_VARIABLES = ("head angle", "side")
EFFECT_DESCRIPTION = (
    "The centre of mass does not lie where the study states it: it is displaced along the core or"
    " to one side of it."
)
MOST_VISIBLE_WHERE = "all turns; a shift to one side also in straight runs"
CONFUSED_WITH = ("head_angle_offset", "stall", "tail_fin_lift", "keypoint_bias")
STRENGTH_PARAMETER_COUNT = 2
EFFECT_PARAMETERS = (
    Parameter("forward_shift", "m", 0.005, -0.04, 0.04, "shift towards the head", symbol="d"),
    Parameter("left_shift", "m", 0.003, -0.02, 0.02, "shift to the left of the core", symbol="s"),
    Parameter("head_angle_share", "1", 0.0, 0.0, 1.0,
              "weight of a shift that grows with the head angle", spread=0.5, symbol="w"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "fixed": {},
    "moves with the head": {"head_angle_share": 1.0},
}


def force(
    T: float, Xh: float, Yh: float, cphi: float, sphi: float, d: float, s: float, w: float
) -> tuple[float, float, float]:
    """Yaw moment alone (N m)."""
    along, across = T + Xh * cphi + Yh * sphi, Yh * cphi - Xh * sphi
    return 0.0, 0.0, s * along - forward_com_shift_m(sphi, d, w) * across


def forward_com_shift_m(sphi: float, d: float, w: float) -> float:
    """Shift towards the head, m."""
    return d * (1.0 - w + w * 1.4142135623730951 * abs(sphi))


def observe(
    cpsi: float, spsi: float, sphi: float, d: float, s: float, w: float
) -> tuple[float, float, float, float]:
    """The keypoint lies `forward_com_shift_m` behind the centre of mass and s to its right (m)."""
    e = forward_com_shift_m(sphi, d, w)
    return s * spsi - e * cpsi, -s * cpsi - e * spsi, 0.0, 0.0
