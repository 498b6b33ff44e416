"""Coming round into its own wake.

After a full circle the robot swims in water that it has set in motion: the drag changes by the
share -k, smoothly between 0.9 and 1.1 turns. Vanishes in straight runs and short arcs.
Source: own statement; momentum wake behind a self-propelled body (Tennekes and Lumley, A First
Course in Turbulence (1972), sec. 4.4).
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
VARIABLES = ("heading turned",)
STATEMENT = "After a full circle the robot meets the water that it stirred up itself."
REGIME = "tight turns beyond 360 degrees of arc"
CONFUSED_WITH = ("battery_sag", "sinking")
PARAMETERS = (
    Parameter("drag_loss", "1", 0.2, -3.0, 3.0,
              "share of the drag 1/2 rho A V^2 that is lost in the wake", symbol="k"),
)  # fmt: skip


def force(
    rho: float, A: float, psi: float, psi0: float, uc: float, vc: float, V: float, k: float
) -> tuple[float, float, float]:
    """Surge and sway (N)."""
    turns = abs(psi - psi0) / 6.283185307179586
    s = 0.5 * rho * A * k * smooth_step((turns - 0.9) / 0.2) * V
    return s * uc, s * vc, 0.0
