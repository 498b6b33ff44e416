"""Forces that differ between the two sides.

The lift of the head to the left differs from that to the right, seen along the motion of the head.
At every angle of attack alpha, the lift changes by a force dL to the left (to the right, if k < 0):

    dL = k |L| s / sqrt(s^2 + w^2),  s = |sin 2 alpha|

- L: lift of a symmetric head (N);
- k: relative difference. With w = 0, the lift is (1 + k) |L| if it points to the left, and
  (1 - k) |L| if it points to the right;
- w: value of s up to which the sides differ less. With w > 0, this reduces the difference at small
  angles of attack.

Three other quantities differ between the sides. They are multiplied by these factors, of which the
first two hold for w = 0:

- the yaw moment q C_Ma sin 2 alpha of the head: 1 + m k if the lift points to the left, 1 - m k if
  to the right;
- the part C_Da (1 - cos 2 alpha) of the drag coefficient of the head: 1 + g if the lift points to
  the left, 1 - g if to the right;
- the yaw damping C_Md r |r| at the yaw rate r: 1 - n in a turn to the left, 1 + n in a turn to the
  right.

The effect vanishes at zero angle of attack without rotation. It cannot be identified if all turns
go to one side: a symmetric head with other formulas for lift and drag could cause the same motion.

Source: own statement (asymmetric hull or head cap).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("sway", "yaw")
DEPENDS_ON_VARIABLES = ("side",)
EFFECT_DESCRIPTION = (
    "Lift, drag or yaw damping differ between the two sides, so that turns to port and to "
    "starboard differ."
)
MOST_VISIBLE_WHERE = "turns; the change has the opposite sign to port and to starboard"
CONFUSED_WITH = ("head_angle_offset", "trim_moment", "keypoint_bias")
NEEDS_TURNS_TO_BOTH_SIDES = True
STRENGTH_PARAMETER_COUNT = 3
EFFECT_PARAMETERS = (
    Parameter("lift_difference", "1", 0.05, -1.0, 1.0,
              "lift to the left over that of a symmetric head, minus 1",
              symbol="k"),
    Parameter("damping_difference", "1", 0.05, -2.0, 2.0,
              "relative reduction of the yaw damping in a turn to the left", symbol="n"),
    Parameter("drag_difference", "1", 0.05, -2.0, 2.0,
              "relative excess of the drag while the lift points to the left", symbol="g"),
    Parameter("transition_sine", "1", 0.03, 0.0, 1.0,
              "absolute sine of 2 alpha up to which the sides differ less", spread=0.5, symbol="w"),
    Parameter("moment_share", "1", 0.0, 0.0, 1.2,
              "difference of the moment, relative to that of the lift", spread=0.5, symbol="m"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "step": {"transition_sine": 0.0},
    "smooth": {"transition_sine": 0.2},
    "at large angles": {"transition_sine": 1.0},
    "moment as well": {"moment_share": 1.0},
}


def head_plate_force(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float, C_Da: float,
    k: float, g: float, w: float,
) -> tuple[float, float]:  # fmt: skip
    """Additional lift and drag, in the head's frame (N)."""
    s = 2.0 * uh * vh
    over = math.sqrt(s * s + (w * V * V) ** 2 + 1e-24)
    L = 0.5 * rho * A * C_La * k * s * s / (over * V)
    D = -0.5 * rho * A * C_Da * g * s / over * 2.0 * vh * vh / V
    return -L * vh - D * uh, L * uh - D * vh


def force(
    rho: float, A: float, uh: float, vh: float, V: float, rd: float, C_Ma: float, C_Md: float,
    k: float, n: float, w: float, m: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Additional moment alone (N m)."""
    s = 2.0 * uh * vh
    over = math.sqrt(s * s + (w * V * V) ** 2 + 1e-24)
    return 0.0, 0.0, 0.5 * rho * A * C_Ma * m * k * s * s / over + n * C_Md * rd * rd
