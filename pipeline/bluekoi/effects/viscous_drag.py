"""Skin friction of a laminar boundary layer.

At the speed V, the drag against the direction of motion v_hat is

    D = -k V^(3/2) ((1 - w) + w (V_1 / V)^(1/2)) v_hat,  V_1 = 0.3 m/s

In laminar flow, the friction coefficient is proportional to Re^(-1/2), so that the drag grows as
V^(3/2) (w = 0). The part w grows as V, as in creeping flow. The drag vanishes at rest.

The part h of the drag acts at the head plate, at the distance l ahead of the centre of mass, like
all drag in the paper. The rest acts at the centre of mass.

Source: Schlichting and Gersten, Boundary-Layer Theory (2017), sec. 6.5 (plate friction).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
VARIABLES = ("speed",)
STATEMENT = (
    "Skin friction grows more slowly than the square of the speed, so that drag at low power is "
    "larger than in the model."
)
REGIME = "low speed: 50 % power, start-up and coasting"
CONFUSED_WITH = ("coulomb_friction", "thrust_loss_with_speed", "wave_drag")
PARAMETERS = (
    Parameter("coefficient", "N (s/m)^1.5", 0.1, 0.0, 5.0, "force at 0.3 m/s over 0.3^1.5",
              symbol="k"),
    Parameter("linear_share", "1", 0.0, 0.0, 1.0, "part that grows as V",
              spread=0.4, symbol="w"),
    Parameter("head_share", "1", 0.0, 0.0, 1.0, "part of it that acts at the head",
              spread=0.5, symbol="h"),
)  # fmt: skip


def force(
    l: float, uc: float, vc: float, V: float, k: float, w: float, h: float
) -> tuple[float, float, float]:
    """Surge and sway (N) and yaw (N m)."""
    s = -k * ((1.0 - w) * math.sqrt(V) + 0.5477225575051661 * w)
    return s * uc, s * vc, h * l * s * vc
