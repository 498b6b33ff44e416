"""Water that swings to and fro, without a name of its own among the causes.

    w = (sx sin Wt + cx cos Wt, sy sin Wt + cy cos Wt),   t since the release

all over the pool at once: the first swing of a basin in its middle, set off by the release (a basin
of length L and depth H swings at W^2 = (pi g / L) tanh(pi H / L)). A term without a name like those
of `residual`.
Source: Lamb, Hydrodynamics (1932), sec. 257.
"""

from __future__ import annotations

from ..integrate.branchless import sin_cos
from ..integrate.system import Parameter

KIND = "residual"
CHANNELS = ("surge", "sway")
STATEMENT = "The water swings to and fro."
STRENGTHS = 4
PARAMETERS = (
    Parameter("sx", "m/s", 0.01, -0.3, 0.3, "swing along the pool's x, none at the release"),
    Parameter("cx", "m/s", 0.01, -0.3, 0.3, "swing along the pool's x, largest at the release"),
    Parameter("sy", "m/s", 0.01, -0.3, 0.3, "swing along the pool's y, none at the release"),
    Parameter("cy", "m/s", 0.01, -0.3, 0.3, "swing along the pool's y, largest at the release"),
    Parameter("W", "rad/s", 2.2, 0.8, 8.0, "rate of the swing",
              tries=(1.2, 1.5, 1.8, 2.5, 2.9, 3.4, 4.0, 4.7, 5.5)),
)  # fmt: skip


def water(
    t: float, sx: float, cx: float, sy: float, cy: float, W: float
) -> tuple[float, float, float, float]:
    """Velocity of the water in the pool frame (m/s); it does not turn (rad/s)."""
    s, c = sin_cos(W * t)
    return sx * s + cx * c, sy * s + cy * c, 0.0, 0.0
