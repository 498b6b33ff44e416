"""Drag changed by the own wake after a full circle.

After about one circle, the robot swims in water that it has set in motion. In a tight circle this
happens earlier, because the wake is wider than the body. The effect vanishes in straight runs and
short arcs.

The drag 1/2 rho A V^2 at the speed V changes by the share -k. The change builds up smoothly from
n_1 - b/2 to n_1 + b/2 turns. With each further turn, the drag changes by g k more. If the wake
decays (a > 0), the change is multiplied by (age / 6 s)^-a, where the age of the wake is the
duration 2 pi / |r| of one turn at the yaw rate r. The part j of the change is proportional to the
speed instead of its square, as in moving water, and equals the other part at 0.3 m/s.

Source: Tennekes and Lumley, A First Course in Turbulence (1972), sec. 4.4 (momentum wake behind a
self-propelled body) and 4.2 (a wake that fades with its age).
"""

from __future__ import annotations

from ..integrate.branchless import branchless_power, smooth_step
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway")
DEPENDS_ON_VARIABLES = ("heading turned",)
EFFECT_DESCRIPTION = "After a full circle the robot swims through its own wake."
MOST_VISIBLE_WHERE = "tight turns beyond 360 degrees of arc"
CONFUSED_WITH = ("battery_sag", "sinking")
EFFECT_PARAMETERS = (
    Parameter("drag_loss", "1", 0.2, -3.0, 3.0,
              "share of the drag 1/2 rho A V^2 that is lost in the wake", symbol="k"),
    Parameter("entry_turns", "1", 0.9, 0.1, 1.5, "turns after which it meets its wake",
              spread=0.3, symbol="n_1"),
    Parameter("entry_width", "1", 0.3, 0.05, 1.5, "turns over which the change grows",
              spread=0.45, symbol="b"),
    Parameter("growth_per_turn", "1", 0.0, 0.0, 1.5, "further change with each further turn",
              spread=0.4, symbol="g"),
    Parameter("age_exponent", "1", 0.0, 0.0, 2.0, "decay of the wake with its age",
              spread=0.5, symbol="a"),
    Parameter("linear_share", "1", 0.0, 0.0, 1.0, "part in proportion to the speed",
              spread=0.5, symbol="j"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "step": {},
    "ramp": {"entry_width": 1.2},
    "grows with each turn": {"growth_per_turn": 0.5},
    "fades with age": {"age_exponent": 1.0},
    "moving water": {"linear_share": 1.0},
    "early": {"entry_turns": 0.6},
}


def force(
    rho: float, A: float, psi: float, psi0: float, uc: float, vc: float, rc: float, V: float,
    speed_unit: float, time_unit: float, k: float, n_1: float, b: float, g: float, a: float,
    j: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N)."""
    turns = abs(psi - psi0) / 6.283185307179586
    entered = smooth_step((turns - n_1) / b + 0.5) * (1.0 + g * max(turns - n_1, 0.0))
    age = branchless_power(max(0.954929658551372 * time_unit * abs(rc), 1e-3), a)
    s = 0.5 * rho * A * k * entered * age * (V + j * (0.3 * speed_unit - V))
    return s * uc, s * vc, 0.0
