"""A wrong frame rate.

At the recorded time t, the true time runs faster than t by the factor

    1 + p k (1 + d (t - 3 s) / 3 s)

- k: relative error of the frame rate at t = 3 s;
- d: change of this error in 3 s, relative to k (unsteady clock);
- p: 1 in the trials whose frame rate is taken to be wrong, 0 in the others.

The finder takes the frame rate to be wrong in all trials (p = 1), unless the tail beat in the
video, compared with the motor log, shows in which trials it is wrong.

Without a motor log, the clock is taken to be steady (d = 0), because the quartz of a camera is
steady. If the tail beat in the video drifts, the finder therefore attributes the drift to the
motor.

Source: own statement (30 for 29.97, or a frame rate typed in wrongly).
"""

from __future__ import annotations

from ..integrate.system import Parameter

EFFECT_KIND = "measurement"
AFFECTED_CHANNELS = ("surge", "sway", "yaw")
EFFECT_DESCRIPTION = (
    "The frame rate is wrong: all motion appears too slow or too fast by the same factor."
)
MOST_VISIBLE_WHERE = (
    "all motion, in proportion to speed; tail beats in the video compared with the motor log"
)
CONFUSED_WITH = ("scale_error",)
EFFECT_PARAMETERS = (
    Parameter("rate_error", "1", 0.01, -0.6, 1.5,
              "relative error of the frame rate; above 0, true time runs faster", symbol="k"),
    Parameter("drift", "1", 0.0, -1.0, 1.0, "change of the error in 3 s, relative to the error",
              spread=0.5, symbol="d"),
)  # fmt: skip
FUNCTIONAL_FORMS = {
    "constant": {},
    "growing": {"drift": 1.0},
}


def predicted_tail_beat_drift(time_unit: float, k: float, d: float) -> float:
    """Relative change of the tail beat's frequency in the video per second (1/s)."""
    return k * d / (3.0 * time_unit)


def relative_clock_error(t: float, time_unit: float, k: float, d: float) -> float:
    """Relative difference of the tail beat in the video from the motor's, at the time t."""
    return k * (1.0 + d * (t / time_unit - 3.0) / 3.0)


SIDE_MEASUREMENT_PREDICTIONS = {
    "clock_ratio": relative_clock_error,
    "stated_ratio": relative_clock_error,
    "tail_beat_drift": predicted_tail_beat_drift,
}


def true_time_rate(
    t: float, time_unit: float, clock_part: float, k: float, d: float
) -> tuple[float]:
    """Change of the rate of true time."""
    return (clock_part * k * (1.0 + d * (t / time_unit - 3.0) / 3.0),)
