"""A recording that did not start with the trial.

Times since the start of the motion are off by d; it shows where commands change.
Source: own statement.
"""

from __future__ import annotations

from ..integrate.system import Parameter
from ..integrate.trigonometry import smooth_step

KIND = "measurement"
CHANNELS = ("surge",)
STATEMENT = (
    "Video and commands do not start together: what happens at the start is seen early or late."
)
REGIME = "the start of every trial"
CONFUSED_WITH = ("motor_spin_up", "servo_lag")
PARAMETERS = (
    Parameter("d", "s", 0.1, -2.0, 2.0, "by how much the motion starts after the recording"),
)


def thrust(t: float, rho: float, A: float, f: float, C_T: float, d: float) -> tuple[float]:
    """Thrust that is not there yet (N); nothing where d is 0."""
    late = smooth_step(t * 10.0 + 0.5) - smooth_step((t - d) * 10.0 + 0.5)
    return (-C_T * 0.5 * rho * A * f * f * late,)
