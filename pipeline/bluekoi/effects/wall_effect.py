"""Water held up between the body and a wall.

    D grows by k ((1 - w) exp(-d / s) + w / (1 + (d / s)^2)) for each wall at distance d

The part w falls with the square of the distance, like the effect of an image behind the wall in two
dimensions. Vanishes away from walls.
Source: Hoerner, Fluid-Dynamic Drag (1965), ch. 8 (blockage); Newman (1977), ch. 4 (images).
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
VARIABLES = ("place",)
STATEMENT = "Close to a wall of the pool the robot is slowed."
REGIME = "within some 0.3 m of a wall"
CONFUSED_WITH = ("pool_gyre", "uniform_current")
PARAMETERS = (
    Parameter("added_drag", "1", 0.5, 0.0, 20.0,
              "share of the drag 1/2 rho A V^2 added at the wall", symbol="k"),
    Parameter("decay_length", "m", 0.15, 0.03, 0.5, "distance within which it falls by e",
              spread=0.06, symbol="s"),
    Parameter("wide_share", "1", 0.0, 0.0, 1.0, "part that falls as distance squared",
              spread=0.4, symbol="w"),
)  # fmt: skip


def force(
    rho: float, A: float, x: float, y: float, L_pool: float, W_pool: float, uc: float, vc: float, V:
    float, k: float, s: float, w: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Surge and sway (N)."""
    left, right = max(x, 0.0) / s, max(L_pool - x, 0.0) / s
    low, high = max(y, 0.0) / s, max(W_pool - y, 0.0) / s
    steep = exponential(-left) + exponential(-right) + exponential(-low) + exponential(-high)
    wide = (
        1.0 / (1.0 + left * left) + 1.0 / (1.0 + right * right)
        + 1.0 / (1.0 + low * low) + 1.0 / (1.0 + high * high)
    )  # fmt: skip
    near = steep + w * (wide - steep)
    drag = -0.5 * rho * A * k * near * V
    return drag * uc, drag * vc, 0.0
