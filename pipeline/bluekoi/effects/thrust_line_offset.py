"""Thrust that misses the centre of mass when the head is turned.

In Eq. 8 of the paper, the thrust T acts at the centre of mass. However, turning the head moves its
mass, and with it the centre of mass, to one side. The line of thrust then passes the centre of mass
at the distance N / T, and the thrust causes the yaw moment

    N = T d (sin(phi) + w (phi - sin(phi)))

- phi: head angle. The moment vanishes with a straight head (phi = 0);
- d: distance at a head angle of 90 degrees, with w = 0 (m);
- w: form of the bend. With w = 0, the robot bends at a hinge. With w = 1, the distance is
  proportional to phi, as for a body that bends along an arc. With w < 0, the distance grows more
  slowly than sin(phi) at large angles; with w = -3 it is close to 1/2 d sin(2 phi).

Source: rigid-body statics.
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("yaw",)
DEPENDS_ON_VARIABLES = ("head angle",)
EFFECT_DESCRIPTION = (
    "When the head is turned, the line of thrust misses the centre of mass, and the thrust turns "
    "the robot."
)
MOST_VISIBLE_WHERE = "turns, in proportion to thrust; also at rest"
CONFUSED_WITH = ("head_angle_offset", "trim_moment", "stall")
EFFECT_PARAMETERS = (
    Parameter("offset", "m", 0.003, -0.05, 0.05,
              "distance at a head angle of 90 degrees (w = 0)", symbol="d"),
    Parameter("linear_share", "1", 0.0, -4.0, 4.0,
              "weight of the difference between the angle and its sine",
              spread=1.5, symbol="w"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "sin phi": {},
    "phi": {"linear_share": 1.0},
    "sin 2 phi": {"linear_share": -3.0},
}


def force(T: float, phi: float, sphi: float, d: float, w: float) -> tuple[float, float, float]:
    """Yaw moment alone (N m)."""
    return 0.0, 0.0, T * d * (sphi + w * (phi - sphi))
