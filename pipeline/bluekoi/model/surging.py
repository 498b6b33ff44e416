"""A thrust that comes and goes with the time, without a name of its own among the causes.

    dT = T (s sin Wt + c cos Wt),   t since the start

as where a supply hunts about its voltage or a controller about its speed. A term without a name
like those of `residual`.
Source: own statement.
"""

from __future__ import annotations

from ..integrate.branchless import sin_cos
from ..integrate.system import Parameter

KIND = "residual"
CHANNELS = ("surge",)
STATEMENT = "The thrust comes and goes with the time since the start."
STRENGTHS = 2
PARAMETERS = (
    Parameter("s", "1", 0.05, -1.0, 1.0, "part of the thrust, none at the start"),
    Parameter("c", "1", 0.05, -1.0, 1.0, "part of the thrust, largest at the start"),
    Parameter("W", "rad/s", 2.2, 0.5, 8.0, "rate at which it comes and goes",
              tries=(1.0, 1.4, 1.8, 2.7, 3.3, 4.0, 5.0, 6.2)),
)  # fmt: skip


def thrust(
    rho: float, A: float, f: float, t: float, C_T: float, s: float, c: float, W: float
) -> tuple[float]:
    """Change of thrust (N)."""
    sine, cosine = sin_cos(W * t)
    return ((s * sine + c * cosine) * C_T * 0.5 * rho * A * f * f,)
