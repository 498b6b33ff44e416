"""Video, commands and motor log that do not start together.

The thrust begins, at its full value, d seconds after the start of the motor in the motor log.
Without a log, it begins d seconds after the start of the video. A negative d is a video (or log)
that starts after the motor: in the first frame, the robot has the speed that it has gained in the
time -d. This speed is given to it by a pulse of thrust with the impulse C_T 1/2 rho A f^2 (-d).
Only trials that begin at rest show d. If the robot swims in the first frame, d has no effect: the
thrust of the model is a mean over the tail beat, and the initial position and velocity of the trial
are free parameters.

e is the time by which the clock of the motor log is ahead of the video. It is visible only in the
phase of the tail beat (`motor/log_video_delay.py`).

Source: own statement.
"""

from __future__ import annotations

from ..integrate.branchless import smooth_step
from ..integrate.system import Parameter

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("surge",)
EFFECT_DESCRIPTION = "Video, commands and motor log do not start at the same time."
MOST_VISIBLE_WHERE = (
    "the start of every trial; the phase of the tail beat in the video compared with the motor log"
)
SIDE_MEASUREMENT_PREDICTIONS = {"delay": {"log_lead": 1.0}}
STRENGTH_PARAMETER_COUNT = 2
CONFUSED_WITH = ("motor_spin_up", "servo_lag")
EFFECT_PARAMETERS = (
    Parameter("start_delay", "s", 0.3, -1.0, 2.0,
              "time from the start in the motor log (or video) to the thrust", symbol="d"),
    Parameter("log_lead", "s", 0.0, -2.0, 2.0,
              "by how much the motor log's clock is ahead of the video's", symbol="e"),
)  # fmt: skip
STRENGTH_START_VALUES = (-0.4, -0.2, -0.1, 0.15, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3)


def thrust(
    t: float, t_start: float, time_unit: float, rho: float, A: float, f: float, C_T: float,
    d: float,
) -> tuple[float]:  # fmt: skip
    """Thrust that is not there yet, or pulse that stands for earlier thrust (N); 0 where d is 0."""
    since, switched = t - t_start, 0.1 * time_unit
    late = smooth_step(since / switched + 0.5) - smooth_step((since - max(d, 0.0)) / switched + 0.5)
    pulse = smooth_step(since / switched) - smooth_step(since / switched - 1.0)
    early = min(d, 0.0) * pulse / switched
    return (-C_T * 0.5 * rho * A * f * f * (late + early),)
