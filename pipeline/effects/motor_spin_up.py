"""A motor that takes time to reach its speed.

    f(t) = f (1 - k ((1 - w) exp(-t / tau) + w max(1 - t / (2 tau), 0))),  t since the start

First order (w = 0), or a ramp that a controller makes, as long as twice tau (w = 1).

Source: Nise (2015), sec. 2.8 (motor with load, first order).
"""

from __future__ import annotations

from ..integrate.branchless import exponential
from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("surge",)
STATEMENT = (
    "The tail does not beat at full frequency from the start: the motor takes time to spin up."
)
REGIME = "the first second of every trial"
CONFUSED_WITH = ("added_mass", "time_offset", "thrust_loss_with_speed")
PARAMETERS = (
    Parameter("k", "1", 0.5, 0.0, 1.0, "share of the frequency missing at the start"),
    Parameter("tau", "s", 0.4, 0.05, 3.0, "time constant, half the length of a ramp"),
    Parameter("w", "1", 0.5, 0.0, 1.0, "part that is a ramp"),
)


def drive(t: float, flap_hz: float, k: float, tau: float, w: float) -> tuple[float, float]:
    """Change of head angle (rad) and flapping frequency (Hz)."""
    ramp = max(1.0 - 0.5 * t / tau, 0.0)
    return 0.0, -flap_hz * k * ((1.0 - w) * exponential(-t / tau) + w * ramp)
