"""A force against motion that hardly depends on speed.

    F = -F_c v_hat        (smoothed below 0.02 m/s, so that it vanishes at rest)

Source: own statement (a tether, the floor, or the surface film dragging on a buoyant robot).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
VARIABLES = ("speed",)
STATEMENT = "Something drags on the robot with nearly constant force, whatever its speed."
REGIME = "lowest speeds: start-up and 50 % power"
CONFUSED_WITH = ("viscous_drag", "thrust_loss_with_speed")
PARAMETERS = (Parameter("F_c", "N", 0.02, 0.0, 1.0, "force"),)


def force(uc: float, vc: float, V: float, F_c: float) -> tuple[float, float, float]:
    """Surge and sway (N)."""
    s = -F_c / math.sqrt(V * V + 0.0004)
    return s * uc, s * vc, 0.0
