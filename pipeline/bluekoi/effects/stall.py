"""Lift lost at a high angle of attack.

Above an onset angle of attack, the flow separates from the head plate. The separated share of the
flow, z, follows its steady value w(alpha) with a delay. During this delay, the head travels about s
head lengths h at the speed V:

    z' = (w(alpha) - z) / (s h / V + t_0),   t_0 = 1/60 second

- w(alpha): separated share in steady flow at the angle of attack alpha. It rises from 0 to 1 as
  |sin alpha| rises from s0 to s0 + b;
- t_0: shortest delay that the integrator can follow. With s = 0, z follows w(alpha) within t_0.

At small angles of attack there is no loss. Otherwise, the head plate loses the share j k z of its
lift, and the share m k z of its yaw moment q C_Ma sin 2 alpha, with q = 1/2 rho A V^2:

- z: separated share of the flow;
- k: share of the lift that is lost in fully separated flow, with j = 1;
- j: 1 if lift is lost, 0 if only the moment is lost;
- m: loss of the moment, relative to k.

Source: Abbott and von Doenhoff, Theory of Wing Sections (1959), sec. 4.1 (stalled flow); Hoerner
and Borst, Fluid-Dynamic Lift (1975), ch. 4; Goman and Khrabrov, J. Aircraft 31 (1994), 1109
(separation as a state).
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("sway", "yaw")
DEPENDS_ON_VARIABLES = ("angle of attack",)
EFFECT_DESCRIPTION = (
    "At a high angle of attack the flow separates from the head, which loses part of its lift."
)
MOST_VISIBLE_WHERE = "large head angles, with an angle of attack above 20 degrees"
CONFUSED_WITH = ("head_angle_offset", "lift_lag", "servo_lag")
EFFECT_PARAMETERS = (
    Parameter("lift_loss", "1", 0.3, 0.0, 1.0, "share of the lift lost in fully separated flow",
              symbol="k"),
    Parameter("onset_sine", "1", 0.4, 0.05, 0.8, "sine of the angle of attack at the onset",
              symbol="s0"),
    Parameter("transition_width", "1", 0.25, 0.04, 0.8,
              "range of the sine from onset to separated flow", spread=0.1, symbol="b"),
    Parameter("moment_share", "1", 0.0, 0.0, 1.2,
              "loss of the moment, relative to the loss of the lift",
              spread=0.5, symbol="m"),
    Parameter("lift_share", "1", 1.0, 0.0, 1.0, "1: lift is lost, 0: the moment alone is lost",
              spread=0.5, symbol="j"),
    Parameter("separation_lengths", "1", 0.0, 0.0, 10.0,
              "head lengths travelled as the flow separates", spread=1.5, symbol="s"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "smooth step": {},
    "slow separation (Goman and Khrabrov)": {"separation_lengths": 3.0},
    "lift and moment": {"moment_share": 1.0},
    "moment alone": {"lift_share": 0.0, "moment_share": 1.0},
    "early": {"onset_sine": 0.2},
    "late": {"onset_sine": 0.6},
}
EFFECT_STATE_NAMES = ("z_stall",)


def head_plate_force(
    rho: float, A: float, uh: float, vh: float, V: float, C_La: float,
    z_stall: float, k: float, j: float,
) -> tuple[float, float]:  # fmt: skip
    """Lift taken away, in the head's frame (N)."""
    L = 0.5 * rho * A * C_La * (-2.0 * uh * vh) / V
    lost = -j * k * z_stall
    return -lost * L * vh, lost * L * uh


def force(
    rho: float, A: float, uh: float, vh: float, C_Ma: float, z_stall: float, k: float, m: float
) -> tuple[float, float, float]:
    """Moment taken away (N m)."""
    return 0.0, 0.0, m * k * z_stall * 0.5 * rho * A * C_Ma * 2.0 * uh * vh


def effect_state_derivatives(
    vh: float, V: float, h: float, time_unit: float, z_stall: float, s0: float, b: float, s: float
) -> tuple[float]:
    """Derivative of the separated share z (1/s), not faster than the integrator follows."""
    separated = smooth_step((abs(vh) / (V + 1e-9) - s0) / b)
    return ((separated - z_stall) * V / (s * h + V * time_unit / 60.0 + 1e-12),)
