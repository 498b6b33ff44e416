"""A motor that takes time to reach its speed.

    f(t) = f (1 - k exp(-t / tau)),  t since the start of the trial

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
    Parameter("k", "1", 0.5, 0.0, 1.2, "share of the frequency missing at the start"),
    Parameter("tau", "s", 0.4, 0.05, 3.0, "time constant"),
)


def drive(t: float, flap_hz: float, k: float, tau: float) -> tuple[float, float]:
    """Change of head angle (rad) and flapping frequency (Hz)."""
    return 0.0, -flap_hz * k * exponential(-t / tau)
