"""Cross-flow drag of core and tail by strip theory.

A section of the body at the distance x ahead of the centre of mass moves sideways at the speed
w = v + x r, with the sway velocity v and the yaw rate r. In straight swimming, w is 0 and the
cross-flow drag vanishes. The side force dY on a section of the length dx, and the yaw moment N of
all sections, are

    dY = -1/2 rho C d_x w ((1 - e) |w| + e (|w| w_1)^(1/2)) dx,  w = v + x r,  w_1 = 0.1 m/s
    N = integral x dY

- rho: density of the water; C: drag coefficient of a section;
- d_x: height of the body at x (m);
- e: weight of a force that grows as w^(3/2), as with a drag coefficient that falls with the
  Reynolds number. With e = 0, the force is quadratic in w. Both forms are equal at the sideways
  speed w_1.

The height d_x of the body falls linearly from the hinge of the head to the tail base. With the
taper q, d_x is 1 + q times the span of the head at the hinge, and 1 - q times this span at the tail
base. Between hinge and tail base, five Gauss points integrate the force. The tail behind the tail
base is one more section. Its height is j times the span of the head.

Source: Hoerner, Fluid-Dynamic Drag (1965), ch. 3; Fossen, Handbook of Marine Craft Hydrodynamics
(2011), sec. 6.4.3 (cross-flow drag, ITTC strip form).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("sway", "yaw")
DEPENDS_ON_VARIABLES = (
    "drift",
    "turn",
)
EFFECT_DESCRIPTION = (
    "Core and tail have drag across the body when the robot moves sideways or turns."
)
MOST_VISIBLE_WHERE = "tight turns with much sideways motion"
CONFUSED_WITH = ("tail_fin_lift", "linear_yaw_damping", "stall")
EFFECT_PARAMETERS = (
    Parameter("drag_coefficient", "1", 0.5, 0.0, 5.0,
              "drag coefficient of a section across the flow", symbol="C"),
    Parameter("taper", "1", 0.1, -0.8, 0.8, "height at the hinge over the mean height, minus 1",
              spread=0.3, symbol="q"),
    Parameter("tail_depth", "1", 0.0, 0.0, 3.0, "height of the tail behind its base, in head spans",
              spread=0.5, symbol="j"),
    Parameter("reynolds_share", "1", 0.0, 0.0, 1.0, "weight of a drag that grows as w^1.5",
              spread=0.5, symbol="e"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "quadratic": {},
    "power 3/2": {"reynolds_share": 1.0},
    "tapered body": {"taper": 0.4},
    "with the tail": {"tail_depth": 1.0},
}


def section_drag_factor(w: float, e: float, speed_unit: float) -> float:
    """Drag of a section over w, per 1/2 rho C d (m/s)."""
    return (1.0 - e) * abs(w) + e * math.sqrt(0.1 * speed_unit * abs(w))


def force(
    rho: float, span: float, x_hinge: float, x_tail: float, l_tail: float, speed_unit: float,
    vc: float, rc: float, C: float, q: float, j: float, e: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Sway (N) and yaw (N m) from five strips between hinge and tail base, and one behind."""
    middle, half = 0.5 * (x_hinge - x_tail), 0.5 * (x_hinge + x_tail)
    k, ga, gb = -0.5 * rho * C * span * half, 0.9061798459386640, 0.5384693101056831
    xa, xb, xc, xd = middle - ga * half, middle - gb * half, middle + gb * half, middle + ga * half
    va, vb, vm, vd, ve = vc + xa * rc, vc + xb * rc, vc + middle * rc, vc + xc * rc, vc + xd * rc
    Ya = k * (1.0 - ga * q) * 0.2369268850561891 * va * section_drag_factor(va, e, speed_unit)
    Yb = k * (1.0 - gb * q) * 0.4786286704993665 * vb * section_drag_factor(vb, e, speed_unit)
    Ym = k * 0.5688888888888889 * vm * section_drag_factor(vm, e, speed_unit)
    Yd = k * (1.0 + gb * q) * 0.4786286704993665 * vd * section_drag_factor(vd, e, speed_unit)
    Ye = k * (1.0 + ga * q) * 0.2369268850561891 * ve * section_drag_factor(ve, e, speed_unit)
    xt = -x_tail - 0.5 * l_tail
    vt = vc + xt * rc
    Yt = -0.5 * rho * C * span * l_tail * j * vt * section_drag_factor(vt, e, speed_unit)
    N = xa * Ya + xb * Yb + middle * Ym + xc * Yd + xd * Ye + xt * Yt
    return 0.0, Ya + Yb + Ym + Yd + Ye + Yt, N
