"""Sideways drag along core and tail, strip by strip.

    dY = -1/2 rho C d_x (v + x r) |v + x r| dx,    N = integral x dY

over the body from the hinge to the tail base (Gauss points of order 5), depth d_x = head span.
Quadratic in the sideways speed: vanishes in straight swimming and without rotation.
Source: Hoerner (1965), ch. 3; Fossen (2011), sec. 6.4.3 (cross-flow drag, ITTC strip form).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("sway", "yaw")
STATEMENT = (
    "Core and tail are dragged sideways through the water when the robot drifts or turns, "
    "strip by strip along the body."
)
REGIME = "tight turns with much drift"
CONFUSED_WITH = ("tail_fin_lift", "linear_yaw_damping", "stall")
PARAMETERS = (Parameter("C", "1", 0.5, 0.0, 5.0, "drag coefficient of a section across the flow"),)


def force(
    rho: float, span: float, x_hinge: float, x_tail: float, vc: float, r: float, C: float
) -> tuple[float, float, float]:
    """Sway (N) and yaw (N m) from five strips between hinge and tail base."""
    middle, half = 0.5 * (x_hinge - x_tail), 0.5 * (x_hinge + x_tail)
    k = -0.5 * rho * C * span * half
    xa, xb = middle - 0.9061798459386640 * half, middle - 0.5384693101056831 * half
    xc, xd = middle + 0.5384693101056831 * half, middle + 0.9061798459386640 * half
    va, vb, vm, vd, ve = vc + xa * r, vc + xb * r, vc + middle * r, vc + xc * r, vc + xd * r
    Ya = k * 0.2369268850561891 * va * abs(va)
    Yb = k * 0.4786286704993665 * vb * abs(vb)
    Ym = k * 0.5688888888888889 * vm * abs(vm)
    Yd = k * 0.4786286704993665 * vd * abs(vd)
    Ye = k * 0.2369268850561891 * ve * abs(ve)
    return 0.0, Ya + Yb + Ym + Yd + Ye, xa * Ya + xb * Yb + middle * Ym + xc * Yd + xd * Ye
