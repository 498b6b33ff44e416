"""Video, commands and motor log that do not start together.

The thrust begins, at its full value, d seconds after the start of the motor in the motor log.
Without a log, it begins d seconds after the start of the video.

If d is negative, the video (or log) starts after the motor, and the robot already has a speed in
the first frame. A pulse of thrust in the first 0.1 s (for the published robot) gives it this speed.
With the thrust T = C_T 1/2 rho A f^2, the impulse of the pulse is T (-d); the drag during the time
-d is neglected. If d is small and positive, the same pulse is subtracted, so that the force is a
smooth function of d at d = 0.

Only trials that begin at rest show the delay d of the thrust. If the robot already swims in the
first frame, d has no effect: the thrust of the model is a mean over the tail beat, and the initial
position and velocity of the trial are free parameters.

The parameter e is the time by which the clock of the motor log is ahead of that of the video. It is
visible only in the phase of the tail beat (`motor/log_video_delay.py`).

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
    switched = 0.1 * time_unit
    since, delay = (t - t_start) / switched, d / switched
    begun = min(max(since, 0.0), 1.0)
    pulse = delay * 6.0 * begun * (1.0 - begun)
    absent = smooth_step(since + 0.5) - smooth_step(since - max(delay, 0.0) + 0.5)
    long = smooth_step(delay)
    return (-C_T * 0.5 * rho * A * f * f * ((1.0 - long) * pulse + long * absent),)
