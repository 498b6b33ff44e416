"""Thrust that falls during a trial with the supply voltage.

    dT = -k T (f / f_1)^e (1 - exp(-w t)) / w,  t since the start of the trial, f_1 = 3.5 Hz

The change of thrust is -k t T at first (for w = 0 at all times) and approaches -k T / w, because
the voltage settles under load. With e > 0 the loss is larger at a higher flapping frequency. Thrust
is proportional to f^2; therefore a motor log shows half of the relative loss as a falling
frequency.
Source: own statement; terminal voltage falls with charge drawn (Linden, Handbook of Batteries,
ch. 2).
"""

from __future__ import annotations

import math

from ..integrate.branchless import exponential, power
from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge",)
VARIABLES = ("time",)
STATEMENT = "Thrust decreases during a trial because the supply voltage falls."
REGIME = "late in long trials"
CONFUSED_WITH = ("sinking", "thrust_loss_with_speed", "wake_reentry")
PARAMETERS = (
    Parameter("loss_rate", "1/s", 0.03, 0.0, 1.0, "share of thrust lost per second, initially",
              symbol="k"),
    Parameter("settling_rate", "1/s", 0.002, 1e-4, 1.0, "rate at which the sag settles",
              spread=0.3, symbol="w"),
    Parameter("load_exponent", "1", 0.0, 0.0, 3.0, "growth with the flapping frequency",
              spread=1.0, symbol="e"),
)  # fmt: skip


MIDDLE_S = 3.0  # of a usual trial


def frequency_drift(k: float, w: float) -> float:
    """Relative change of the flapping frequency per second (1/s) in the middle of a trial."""
    return -0.5 * k * math.exp(-w * MIDDLE_S)


EVIDENCE = {"frequency_drift": frequency_drift}


def thrust(
    rho: float, A: float, f: float, t: float, C_T: float, k: float, w: float, e: float
) -> tuple[float]:
    """Change of thrust (N)."""
    load = power(max(f, 1e-9) / 3.5, e)
    return (-k * load * (1.0 - exponential(-w * t)) / w * C_T * 0.5 * rho * A * f * f,)
