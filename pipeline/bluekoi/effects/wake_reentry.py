"""Drag changed by the own wake after a full circle.

After about one circle, the robot swims in water that it has set in motion. In a tight circle this
happens earlier, because the wake is wider than the body. The effect vanishes in straight runs and
short arcs.

At the speed V, the drag changes by

    dD = -k E(n) (t_w / 6 s)^(-a) 1/2 rho A ((1 - j) V^2 + j V V_1),  V_1 = 0.3 m/s

- rho: density of the water; A: area of the head plate;
- k: reduction of the drag in a wake of the age 6 s, over 1/2 rho A V^2, with E = 1 and j = 0;
- n: change of the heading since the start of the trial, in turns;
- E(n): growth of the change with the turns. E rises smoothly from 0 to 1 over b turns around
  n = n_1, where the robot meets its wake. For n > n_1, E has the additional factor 1 + g (n - n_1):
  the change grows by the share g with each further turn;
- t_w: age of the wake (s), which is the duration 2 pi / |r| of one turn at the yaw rate r;
- a: exponent of the decay of the wake. With a > 0, an older wake changes the drag less;
- j: weight of a change that is proportional to V, as in moving water. With j = 0, the change is
  proportional to V^2. Both forms are equal at the speed V_1.

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
              "reduction of the drag in the wake, over 1/2 rho A V^2", symbol="k"),
    Parameter("entry_turns", "1", 0.9, 0.1, 1.5, "turns until the robot meets its wake",
              spread=0.3, symbol="n_1"),
    Parameter("entry_width", "1", 0.3, 0.05, 1.5, "turns over which the change builds up",
              spread=0.45, symbol="b"),
    Parameter("growth_per_turn", "1", 0.0, 0.0, 1.5, "relative growth with each further turn",
              spread=0.4, symbol="g"),
    Parameter("age_exponent", "1", 0.0, 0.0, 2.0, "exponent of the decay of the wake with its age",
              spread=0.5, symbol="a"),
    Parameter("linear_share", "1", 0.0, 0.0, 1.0, "weight of a change that grows as V",
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
