"""Forces that differ between the two sides.

For k > 0, the lift of the head is larger than the lift L of a symmetric head if it points to the
left, and smaller if it points to the right. Left and right are seen along the motion of the head.
At every angle of attack alpha, the change of the lift points to the left:

    dL = k |L| s / sqrt(s^2 + w^2),  s = |sin 2 alpha|

With w = 0, the lift is 1 + k times that of a symmetric head if it points to the left, and 1 - k
times if it points to the right. With w > 0, the sides differ less at small angles of attack.

Three other quantities differ between the sides. With w = 0, they are multiplied by these factors:

- the moment q C_Ma sin 2 alpha: 1 + m k if the lift points to the left, 1 - m k if to the right;
- the drag C_Da (1 - cos 2 alpha) of the head: 1 + g if the lift points to the left, 1 - g if to the
  right;
- the yaw damping C_Md r |r|: 1 - n in a turn to the left, 1 + n in a turn to the right.

The effect vanishes at zero angle of attack without rotation. If all turns go to one side, it cannot
be recognised: a symmetric head with other formulas for lift and drag could cause the same motion.

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
MOST_VISIBLE_WHERE = "turns, with opposite sign to port and starboard"
CONFUSED_WITH = ("head_angle_offset", "trim_moment", "keypoint_bias")
NEEDS_TURNS_TO_BOTH_SIDES = True
STRENGTH_PARAMETER_COUNT = 3
EFFECT_PARAMETERS = (
    Parameter("lift_difference", "1", 0.05, -1.0, 1.0,
              "lift to the left over that of a symmetric head, minus 1",
              symbol="k"),
    Parameter("damping_difference", "1", 0.05, -2.0, 2.0,
              "share by which yaw is damped less in a turn to the left", symbol="n"),
    Parameter("drag_difference", "1", 0.05, -2.0, 2.0,
              "relative excess of the drag while the lift points to the left", symbol="g"),
    Parameter("transition_sine", "1", 0.03, 0.0, 1.0,
              "sine of 2 alpha up to which the sides differ less", spread=0.5, symbol="w"),
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
