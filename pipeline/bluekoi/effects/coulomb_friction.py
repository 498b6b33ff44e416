"""Friction force independent of speed.

The friction force F acts against the velocity v of the robot, with the speed V = |v|:

    F = -F_c (1 + s exp(-(V / V_s)^2)) v / sqrt(V^2 + c^2),  V_s = 0.1 m/s

- F_c: sliding friction (N). At speeds well above c and V_s, the force is constant, with this value;
- c: onset speed (m/s). Below it, the force falls smoothly to 0 at rest. With a large c, the force
  rises gradually with the speed;
- s: excess of static over sliding friction, relative to sliding friction (Stribeck effect). V_s is
  the speed over which the excess decays.

In a pool, such a force comes from a tether, from the floor, or from the film on the water surface.

Source: Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), 1083, sec. 2 (Coulomb
and Stribeck friction).
"""

from __future__ import annotations

import math

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway")
DEPENDS_ON_VARIABLES = ("speed",)
EFFECT_DESCRIPTION = (
    "A nearly constant friction force acts against the motion: it hardly depends on the speed."
)
MOST_VISIBLE_WHERE = "lowest speeds: start-up and the smallest power"
CONFUSED_WITH = ("viscous_drag", "thrust_loss_with_speed")
EFFECT_PARAMETERS = (
    Parameter("F_c", "N", 0.02, 0.0, 1.0, "sliding friction"),
    Parameter("onset_speed", "m/s", 0.02, 0.002, 0.2, "speed up to which the friction rises",
              spread=0.03, symbol="c"),
    Parameter("static_excess", "1", 0.0, 0.0, 3.0, "excess of static over sliding friction",
              spread=0.5, symbol="s"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "sign of the velocity": {"onset_speed": 0.002},
    "smoothed": {},
    "Stribeck": {"static_excess": 0.5},
    "saturating": {"onset_speed": 0.08},
}


def force(
    uc: float, vc: float, V: float, speed_unit: float, F_c: float, c: float, s: float
) -> tuple[float, float, float]:
    """Surge and sway (N)."""
    slow = exponential(-100.0 * V * V / (speed_unit * speed_unit))
    k = -F_c * (1.0 + s * slow) / math.sqrt(V * V + c * c)
    return k * uc, k * vc, 0.0
