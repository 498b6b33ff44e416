"""A head that takes time to turn.

    phi(t) = phi (1 - k exp(-(t / tau)^n)),  t since the start of the trial

n = 1 is a first-order lag, larger n a servo that turns at a limited rate and then stands.
Source: Nise, Control Systems Engineering (2015), sec. 4.3 (first-order response).
"""

from __future__ import annotations

import math

from ..integrate.system import Parameter

KIND = "physics"
CHANNELS = ("yaw", "sway")
STATEMENT = (
    "The head does not stand at its angle from the start: the servo takes time to turn it."
)
REGIME = "the first second of turns"
CONFUSED_WITH = ("motor_spin_up", "lift_lag", "time_offset")
PARAMETERS = (
    Parameter("k", "1", 0.5, 0.0, 1.2, "share of the angle missing at the start"),
    Parameter("tau", "s", 0.4, 0.05, 3.0, "time constant"),
    Parameter("n", "1", 1.2, 0.7, 4.0, "1: lag of first order, larger: limited rate"),
)


def drive(t: float, head_angle: float, k: float, tau: float, n: float) -> tuple[float, float]:
    """Change of head angle (rad) and flapping frequency (Hz)."""
    return -head_angle * k * math.exp(-((max(t, 1e-9) / tau) ** n)), 0.0
