"""Forces close to a wall of the pool.

Each wall of the pool causes a drag, an attraction and a yaw moment. They are proportional to n(d),
where d is the distance from the wall:

    n(d) = (1 - w) exp(-d / s) + w / (1 + (d / s)^2)
    drag k n q A,  attraction g n q A,  moment towards the wall j n q A (0.1 m)

- q: dynamic pressure rho V^2 / 2 at the speed V; A: area of the head plate;
- s: distance over which the effect decays (m);
- w: weight of a form that falls as the inverse square of the distance if d is much larger than s.
  Potential flow with an image of the body behind the wall has this form, and explains the
  attraction;
- j: strength of the moment. A force j n q A towards the wall that acts 0.1 m ahead of the centre of
  mass would cause the same moment.

The contributions of the four walls are added. The effect vanishes far from the walls.

Source: Hoerner, Fluid-Dynamic Drag (1965), ch. 8 (blockage); Newman (1977), ch. 4 (images).
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

EFFECT_KIND = "physics"
AFFECTED_CHANNELS = ("surge", "sway", "yaw")
DEPENDS_ON_VARIABLES = ("place",)
EFFECT_DESCRIPTION = (
    "Close to a wall of the pool, additional drag, an attraction and a yaw moment act on the robot."
)
MOST_VISIBLE_WHERE = "positions within about 0.3 m of a wall"
CONFUSED_WITH = ("pool_gyre", "uniform_current")
STRENGTH_PARAMETER_COUNT = 3
EFFECT_PARAMETERS = (
    Parameter("added_drag", "1", 0.5, 0.0, 20.0,
              "drag added at a wall, over 1/2 rho A V^2", symbol="k"),
    Parameter("suction", "1", 0.2, -20.0, 20.0, "attraction at a wall, over 1/2 rho A V^2",
              symbol="g"),
    Parameter("moment", "1", 0.2, -20.0, 20.0,
              "moment towards a wall, over 1/2 rho A V^2 (0.1 m)", symbol="j"),
    Parameter("decay_length", "m", 0.15, 0.03, 0.5,
              "distance over which the effect falls by a factor e",
              spread=0.075, symbol="s"),
    Parameter("wide_share", "1", 0.0, 0.0, 1.0,
              "weight of a form that falls as the inverse square of the distance",
              spread=0.5, symbol="w"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "exponential": {},
    "wide": {"decay_length": 0.3},
    "image": {"wide_share": 1.0},
    "narrow": {"decay_length": 0.07},
}


def wall_decay_factor(d: float, w: float) -> float:
    """Effect of a wall at the distance d, in decay lengths."""
    steep = exponential(-d)
    return steep + w * (1.0 / (1.0 + d * d) - steep)


def force(
    rho: float, A: float, x: float, y: float, L_pool: float, W_pool: float, length_unit: float,
    cpsi: float, spsi: float, uc: float, vc: float, V: float, k: float, g: float, j: float,
    s: float, w: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N) and yaw (N m)."""
    left, right = (
        wall_decay_factor(max(x, 0.0) / s, w),
        wall_decay_factor(max(L_pool - x, 0.0) / s, w),
    )
    low, high = (
        wall_decay_factor(max(y, 0.0) / s, w),
        wall_decay_factor(max(W_pool - y, 0.0) / s, w),
    )
    q = 0.5 * rho * A * V
    drag = -k * q * (left + right + low + high)
    px, py = q * V * (right - left), q * V * (high - low)
    ahead, across = px * cpsi + py * spsi, py * cpsi - px * spsi
    return drag * uc + g * ahead, drag * vc + g * across, 0.1 * length_unit * j * across
