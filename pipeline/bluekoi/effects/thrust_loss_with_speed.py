"""Thrust that falls with forward speed.

At the surge velocity u and the flapping frequency f, the thrust T changes by

    dT = -k rho A f u ((1 - w) + w (u / f) / J_1) (f / f_1)^q,  J_1 = 0.15 m, f_1 = 3.5 Hz

- u / f: advance, the distance that the robot swims in one tail beat (m);
- k: loss of T / (rho A f^2) per metre of advance, at the advance J_1 and the frequency f_1; rho:
  density of the water; A: area of the head plate;
- w: weight of a loss proportional to the square of the advance. With w = 0, the loss is
  proportional to the advance. Both forms are equal at the advance J_1. With w > 1, the thrust is
  largest at an advance above 0, as that of a tail at its best Strouhal number;
- q: exponent of the frequency. With q = 0, the relative loss dT / T depends only on the advance, as
  for a propeller. With q = 1 (for w = 0) or q = 2 (for w = 1), it depends only on the speed.

The loss vanishes at rest.

Source: Carlton, Marine Propellers and Propulsion (2012), sec. 6.1 (open-water curves);
Triantafyllou et al., J. Fluids Struct. 7 (1993), 205 (Strouhal number of fish tails).
"""

from __future__ import annotations

from ..integrate.branchless import branchless_power
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge",)
DEPENDS_ON_VARIABLES = (
    "speed",
    "beat",
)
EFFECT_DESCRIPTION = "Thrust falls as the forward speed of the robot rises."
MOST_VISIBLE_WHERE = "start-up (more thrust) against steady swimming (less thrust)"
CONFUSED_WITH = ("viscous_drag", "wave_drag", "battery_sag")
EFFECT_PARAMETERS = (
    Parameter("loss_per_advance", "m", 0.02, 0.0, 1.0,
              "loss of T / (rho A f^2) per metre of advance, at 0.15 m and 3.5 Hz", symbol="k"),
    Parameter("quadratic_share", "1", 0.0, 0.0, 4.0, "weight of a loss proportional to u^2",
              spread=1.0, symbol="w"),
    Parameter("frequency_exponent", "1", 0.0, 0.0, 2.0, "growth with frequency at equal advance",
              spread=1.0, symbol="q"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "linear": {},
    "quadratic": {"quadratic_share": 1.0},
    "square of the speed": {"quadratic_share": 1.0, "frequency_exponent": 2.0},
    "best at one advance": {"quadratic_share": 2.0},
}


def thrust(
    rho: float, A: float, f: float, uc: float, length_unit: float, time_unit: float, k: float,
    w: float, q: float,
) -> tuple[float]:  # fmt: skip
    """Change of thrust (N)."""
    beat = branchless_power(max(f * time_unit, 1e-9) / 3.5, q)
    return (-k * rho * A * uc * ((1.0 - w) * f + w * uc / (0.15 * length_unit)) * beat,)
