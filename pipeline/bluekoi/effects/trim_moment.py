"""Constant yaw moment of an asymmetric robot.

At the speed V and the flapping frequency f, the yaw moment is

    N = 1/2 rho A c V0^2 ((1 - w) (V / V0)^(2 p) + w (f / f0)^2),   V0 = 0.3 m/s, f0 = 3.5 Hz

- rho: density of the water; A: area of the head plate;
- V0, f0: a speed and a frequency that the published robot reaches;
- c: lever arm (m). At V = V0 and f = f0, the moment is that of the force 1/2 rho A V0^2 at this
  arm;
- w: weight of a moment that is proportional to the thrust, as for a misaligned tail;
- p: exponent of the other moment, which has the weight 1 - w. With p = 1, it is proportional to
  V^2, as for an asymmetric hull. With p = 0, it is constant, as for a cable that pulls. With p > 0,
  N vanishes if robot and tail are at rest.

The moment turns a robot with a straight head always to the same side.

Source: Fossen (2011), sec. 7.1 (asymmetric hull terms).
"""

from __future__ import annotations

from ..integrate.branchless import branchless_power
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("yaw",)
DEPENDS_ON_VARIABLES = ("side",)
EFFECT_DESCRIPTION = (
    "The robot is not symmetric: a small yaw moment acts even with a straight head, always to the "
    "same side."
)
MOST_VISIBLE_WHERE = "all trials, with the same sign; best in straight runs"
CONFUSED_WITH = ("head_angle_offset", "port_starboard_asymmetry", "keypoint_bias")
EFFECT_PARAMETERS = (
    Parameter("moment_arm", "m", 0.001, -0.1, 0.1,
              "moment at 0.3 m/s and 3.5 Hz, over 1/2 rho A (0.3 m/s)^2; counter-clockwise "
              "positive", symbol="c"),
    Parameter("speed_dependence", "1", 1.0, 0.0, 1.5, "exponent of the squared speed",
              spread=0.5, symbol="p"),
    Parameter("thrust_share", "1", 0.0, 0.0, 1.0, "weight of a moment proportional to the thrust",
              spread=0.5, symbol="w"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "V^2": {},
    "constant": {"speed_dependence": 0.0},
    "in proportion to the thrust": {"thrust_share": 1.0},
}


def force(
    rho: float, A: float, f: float, V: float, speed_unit: float, time_unit: float, c: float,
    p: float, w: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Yaw moment alone (N m)."""
    V0, beat = 0.3 * speed_unit, f * time_unit / 3.5
    hull = branchless_power(max(V, 1e-9) / V0, 2.0 * p)
    return 0.0, 0.0, 0.5 * rho * A * c * V0 * V0 * (hull + w * (beat * beat - hull))
