"""A robot that sinks during the trial.

    D = -1/2 rho A k t V^2 v_hat, t since the start

Trim and drag change as it leaves the surface; the rigid distances seen shrink as it sinks.
Source: own statement (the paper reports slight sinking, sec. III-A).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge", "sway")
STATEMENT = (
    "The robot sinks during the trial: drag grows with time, and it looks smaller and smaller."
)
REGIME = "late in long trials"
CONFUSED_WITH = ("battery_sag", "wake_reentry")
PARAMETERS = (Parameter("k", "1/s", 0.03, 0.0, 0.5, "growth of the drag coefficient per second"),)


def force(
    rho: float, A: float, t: float, uc: float, vc: float, V: float, k: float
) -> tuple[float, float, float]:
    """Surge and sway (N)."""
    s = -0.5 * rho * A * k * t * V
    return s * uc, s * vc, 0.0
