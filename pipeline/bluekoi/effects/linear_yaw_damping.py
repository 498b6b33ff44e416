"""Yaw damping in proportion to the yaw rate.

    N = -N_r r

Vanishes without rotation; against the quadratic term C_Md it weighs most in slow turns.
Source: Fossen (2011), sec. 6.4 (linear damping, potential and skin friction).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw",)
VARIABLES = ("turn",)
STATEMENT = (
    "The water resists turning in proportion to the yaw rate, not only to its square, so slow "
    "turns are damped more than the model says."
)
REGIME = "turns; weighs most at low yaw rate and low power"
CONFUSED_WITH = ("tail_fin_lift", "crossflow_drag", "viscous_drag")
PARAMETERS = (Parameter("N_r", "N m s", 0.005, 0.0, 0.3, "moment at 1 rad/s"),)


def force(rc: float, N_r: float) -> tuple[float, float, float]:
    """Yaw moment alone (N m)."""
    return 0.0, 0.0, -N_r * rc
