"""Thrust that falls during a trial.

    dT = -k t T,  t since the start of the trial

Source: own statement; terminal voltage falls with charge drawn (Linden, Handbook of Batteries,
ch. 2).
"""

from __future__ import annotations

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge",)
STATEMENT = "The longer a trial lasts, the weaker the push: the supply sags."
REGIME = "late in long trials"
CONFUSED_WITH = ("sinking", "thrust_loss_with_speed", "wake_reentry")
PARAMETERS = (Parameter("k", "1/s", 0.03, 0.0, 0.3, "share of thrust lost per second"),)


def thrust(rho: float, A: float, f: float, t: float, C_T: float, k: float) -> tuple[float]:
    """Change of thrust (N)."""
    return (-k * t * C_T * 0.5 * rho * A * f * f,)
