"""Skin friction.

At the speed V, the drag against the direction of motion v_hat is

    D = -k V_1^(3/2) (V / V_1)^p v_hat,  V_1 = 0.3 m/s

- k: coefficient (N (s/m)^1.5). The drag at the speed V_1 is k V_1^(3/2);
- p: exponent of the speed. In laminar flow, the friction coefficient is proportional to Re^(-1/2),
  with the Reynolds number Re, so that p = 3/2. In creeping flow p = 1, and in a turbulent boundary
  layer p = 1.8.

The drag vanishes at rest.

The share h of the drag acts at the head plate, at the distance l ahead of the centre of mass, like
all drag in the paper. The rest acts at the centre of mass.

The component of the drag across the core, the rigid body behind the head, is multiplied by the
factor c. With c = 1, the drag is opposite to the motion. With c = 0, it has no component across the
core. This is the case in models that describe the drag along the body by one term, such as X_u u,
and the drag across it by another.

Source: Schlichting and Gersten, Boundary-Layer Theory (2017), sec. 6.5 (laminar plate friction) and
ch. 18 (turbulent); Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), sec.
6.4 (linear damping in surge, X_u).
"""

from __future__ import annotations

import math

from ..integrate.branchless import branchless_power
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway")
DEPENDS_ON_VARIABLES = ("speed",)
EFFECT_DESCRIPTION = (
    "Skin friction grows more slowly than the square of the speed, so that drag at low power is "
    "larger than in the model."
)
MOST_VISIBLE_WHERE = "low speed: the smallest power, start-up and coasting"
CONFUSED_WITH = ("coulomb_friction", "thrust_loss_with_speed", "wave_drag")
EFFECT_PARAMETERS = (
    Parameter("coefficient", "N (s/m)^1.5", 0.1, 0.0, 5.0, "force at 0.3 m/s over 0.3^1.5",
              symbol="k"),
    Parameter("speed_exponent", "1", 1.5, 1.0, 1.9, "power of the speed in the drag",
              spread=0.25, symbol="p"),
    Parameter("head_share", "1", 0.0, 0.0, 1.0, "share of the drag that acts at the head",
              spread=0.5, symbol="h"),
    Parameter("sideways_share", "1", 1.0, 0.0, 1.0, "factor of the drag across the core",
              spread=0.5, symbol="c"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "V": {"speed_exponent": 1.0},
    "V^(3/2)": {},
    "V^1.8": {"speed_exponent": 1.8},
    "at the head": {"head_share": 1.0},
    "along the core": {"sideways_share": 0.0},
    "X_u u": {"speed_exponent": 1.0, "sideways_share": 0.0},
}


def force(
    l: float, uc: float, vc: float, V: float, speed_unit: float, k: float, p: float, h: float,
    c: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N) and yaw (N m)."""
    V_1 = 0.3 * speed_unit
    s = -k * math.sqrt(V_1) * branchless_power(max(V, 1e-9) / V_1, p - 1.0)
    return s * uc, c * s * vc, h * l * c * s * vc
