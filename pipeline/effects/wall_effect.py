"""Water held up between the body and a wall.

    D grows by k exp(-d / 0.15 m) for each wall at distance d

Away from walls it vanishes. Source: Hoerner, Fluid-Dynamic Drag (1965), ch. 8 (blockage).
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
STATEMENT = "Close to a wall of the pool the robot is slowed."
REGIME = "within some 0.3 m of a wall"
CONFUSED_WITH = ("pool_gyre", "uniform_current")
PARAMETERS = (
    Parameter(
        "k", "1", 0.5, 0.0, 20.0, "share of the reference drag 1/2 rho A V^2 added at the wall"
    ),
    Parameter("s", "m", 0.15, 0.03, 0.5, "distance within which it fades by e", 0.06),
)


def force(
    rho: float,
    A: float,
    x: float,
    y: float,
    L_pool: float,
    W_pool: float,
    uc: float,
    vc: float,
    V: float,
    k: float,
    s: float,
) -> tuple[float, float, float]:
    """Surge and sway (N)."""
    near = (
        exponential(-max(x, 0.0) / s)
        + exponential(-max(L_pool - x, 0.0) / s)
        + exponential(-max(y, 0.0) / s)
        + exponential(-max(W_pool - y, 0.0) / s)
    )
    drag = -0.5 * rho * A * k * near * V
    return drag * uc, drag * vc, 0.0
