"""Lift lost at a high angle of attack.

The head plate loses the share k w(alpha) of its lift at the angle of attack alpha. w rises from 0
to 1 as |sin alpha| rises from s0 to s0 + b. At small angles there is no loss. The head also loses
the share m k w(alpha) of its yaw moment q C_Ma sin 2 alpha.

Source: Abbott and von Doenhoff, Theory of Wing Sections (1959), sec. 4.1 (stalled flow); Hoerner
and Borst, Fluid-Dynamic Lift (1975), ch. 4.
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("sway", "yaw")
VARIABLES = ("angle of attack",)
STATEMENT = (
    "At a high angle of attack the flow separates from the head, which loses part of its lift."
)
REGIME = "large head angles, with an angle of attack above 20 degrees"
CONFUSED_WITH = ("head_angle_offset", "lift_lag", "servo_lag")
PARAMETERS = (
    Parameter("lift_loss", "1", 0.3, 0.0, 1.0, "share of the lift lost in fully separated flow",
              symbol="k"),
    Parameter("onset_sine", "1", 0.4, 0.05, 0.8, "sine of the angle of attack at the onset",
              symbol="s0"),
    Parameter("transition_width", "1", 0.25, 0.04, 0.8,
              "range of the sine from onset to separated flow", spread=0.1, symbol="b"),
    Parameter("moment_share", "1", 0.0, 0.0, 1.2, "part of the moment that is lost as the lift is",
              spread=0.5, symbol="m"),
)  # fmt: skip


def plate(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float,
    k: float, s0: float, b: float,
) -> tuple[float, float]:  # fmt: skip
    """Lift taken away, in the head's frame (N)."""
    L = 0.5 * rho * A * C_La * (-2.0 * uh * vh) / V
    lost = -k * smooth_step((abs(vh) / V - s0) / b)
    return -lost * L * vh, lost * L * uh


def force(
    rho: float, A: float, uh: float, vh: float, V: float, C_Ma: float,
    k: float, s0: float, b: float, m: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Moment taken away (N m)."""
    lost = m * k * smooth_step((abs(vh) / (V + 1e-9) - s0) / b)
    return 0.0, 0.0, lost * 0.5 * rho * A * C_Ma * 2.0 * uh * vh
