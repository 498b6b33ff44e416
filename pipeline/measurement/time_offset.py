"""A recording that did not start with the trial.

The motion starts d after the recording, at once and with all its thrust (k = 1). A recording that
starts in the motion does no harm: each trial's first state is free.
Source: own statement.
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

KIND = "measurement"
CHANNELS = ("surge",)
STATEMENT = (
    "Video and commands do not start together: what happens at the start is seen early or late."
)
REGIME = "the start of every trial"
CONFUSED_WITH = ("motor_spin_up", "servo_lag")
PARAMETERS = (
    Parameter("k", "1", 1.0, 0.0, 1.2, "share of the thrust that is late"),
    Parameter("d", "s", 0.3, 0.0, 2.0, "by how much the motion starts after the recording"),
)


def thrust(
    t: float, rho: float, A: float, f: float, C_T: float, k: float, d: float
) -> tuple[float]:
    """Thrust that is not there yet (N); nothing where k is 0."""
    late = smooth_step(t * 10.0 + 0.5) - smooth_step((t - d) * 10.0 + 0.5)
    return (-k * C_T * 0.5 * rho * A * f * f * late,)
