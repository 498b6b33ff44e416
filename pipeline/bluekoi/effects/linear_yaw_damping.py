"""Yaw damping in proportion to the yaw rate.

At the yaw rate r and the speed V, the yaw moment is

    N = -N_r r ((1 - p - q) + p (|r| / r_1)^(1/2) + q V / V_1),  r_1 = 0.5 rad/s, V_1 = 0.3 m/s

- N_r: damping coefficient (N m s). With p = q = 0, the moment is proportional to r;
- p: weight of a moment that grows as r^(3/2), as for skin friction of a laminar boundary layer on
  the turning body;
- q: weight of a moment that grows as V r, as for the lift on the sections of a body that turns
  while it swims ahead.

The three forms of the moment, proportional to r, r^(3/2) and V r, are equal at the yaw rate
r = 0.5 rad/s and the speed V = 0.3 m/s.

The moment vanishes without rotation. Relative to the quadratic damping of the model, C_Md r |r| at
the yaw rate r, it is largest in slow turns.

Source: Fossen, Handbook of Marine Craft Hydrodynamics (2011), sec. 6.4 (linear damping, potential
and skin friction); Schlichting and Gersten, Boundary-Layer Theory (2017), sec. 6.5; Newman, Marine
Hydrodynamics (1977), sec. 7.9 (lift of a slender body).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("yaw",)
DEPENDS_ON_VARIABLES = ("turn",)
EFFECT_DESCRIPTION = (
    "The water damps turning in proportion to the yaw rate, in addition to the quadratic damping "
    "of the model."
)
MOST_VISIBLE_WHERE = "turns, mostly at low yaw rate and low power"
CONFUSED_WITH = ("tail_fin_lift", "crossflow_drag", "viscous_drag")
EFFECT_PARAMETERS = (
    Parameter("N_r", "N m s", 0.005, 0.0, 0.3, "moment over yaw rate, at 0.5 rad/s and 0.3 m/s"),
    Parameter("laminar_share", "1", 0.0, 0.0, 1.0, "weight of a moment that grows as r^1.5",
              spread=0.5, symbol="p"),
    Parameter("speed_share", "1", 0.0, 0.0, 1.0, "weight of a moment that grows as V r",
              spread=0.5, symbol="q"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "r": {},
    "r^(3/2)": {"laminar_share": 1.0},
    "V r": {"speed_share": 1.0},
}


def force(
    rc: float, V: float, speed_unit: float, time_unit: float, N_r: float, p: float, q: float
) -> tuple[float, float, float]:
    """Yaw moment alone (N m)."""
    laminar, speed = math.sqrt(2.0 * time_unit * abs(rc)), V / (0.3 * speed_unit)
    form = 1.0 + p * (laminar - 1.0) + q * (speed - 1.0)
    return 0.0, 0.0, -N_r * rc * form
