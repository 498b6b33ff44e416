"""Skin friction of a laminar boundary layer.

    D = -k V^(3/2) v_hat        (c_f ~ Re^(-1/2), so that the force grows as V^2 V^(-1/2))

Weaker than quadratic drag as speed grows; vanishes at rest.
Source: Schlichting and Gersten, Boundary-Layer Theory (2017), sec. 6.5 (plate friction).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
STATEMENT = (
    "Skin friction grows more slowly than speed squared, so drag weighs more at low power "
    "than the model says."
)
REGIME = "low speed: 50 % power, start-up and coasting"
CONFUSED_WITH = ("coulomb_friction", "thrust_loss_with_speed", "wave_drag")
PARAMETERS = (Parameter("k", "N (s/m)^1.5", 0.1, 0.0, 5.0, "force at 1 m/s"),)


def force(uc: float, vc: float, V: float, k: float) -> tuple[float, float, float]:
    """Surge and sway (N); no moment."""
    s = -k * math.sqrt(V)
    return s * uc, s * vc, 0.0
