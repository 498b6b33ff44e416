"""Trials whose tail beat has another phase against the motor log than in the other trials.

The beat is behind the shaft by a lag that is alike in all trials. If log and video of a trial do
not begin together, or the log is another trial's, its lag is arbitrary. A clock that is wrong
by the same time in all trials is measured from the lags of several powers (`log_video_delay`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..data import Float
from ..study import Trial
from .log_video_delay import REPEAT_FREQUENCY_TOLERANCE_SHARE
from .shaft_angle import wrap_angle

LAG_TOLERANCE_RAD = 0.7
"""Lags within this of each other are alike. Of 1302 lags in 68 simulated studies, 90 % are within
0.02 and 98 % within 0.7 of the mean of their study; a lag by chance is so in 22 % of all cases."""
MIN_ALIKE_TRIALS = 3
"""Two trials out of step are alike by chance in 22 % of all cases, three in 5 %."""
REMEDY = (
    "Do video and log begin together, is the beginning of the video cut off, and is the log this "
    "trial's? Check motor_log and start_s."
)


def log_synchrony_warnings(
    trials: Mapping[str, Trial], statuses: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    """A sentence for each motor log that several recordings share, and for each trial whose tail
    beat is out of step with its log.

    statuses: content of status/ID.json by trial id, or what `check` knows of it.
    """
    return [*_shared_log_warnings(trials), *_out_of_step_warnings(statuses)]


def _shared_log_warnings(trials: Mapping[str, Trial]) -> list[str]:
    users: dict[str, list[Trial]] = {}
    for trial in trials.values():
        if trial.motor_log:
            users.setdefault(trial.motor_log, []).append(trial)
    return [
        f"Trials {', '.join(t.trial_id for t in some)} have the same motor_log, {log}, and "
        "different recordings: a log begins with the recording that it belongs to."
        for log, some in users.items()
        if len({t.source for t in some}) > 1
    ]


def _out_of_step_warnings(statuses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    seen = {name: status.get("flapping") or {} for name, status in statuses.items()
            if status.get("ok")}  # fmt: skip
    beats = {name: beat for name, beat in seen.items() if _is_lag_meaningful(beat)}
    hz, lag = (np.array([b[key] for b in beats.values()]) for key in ("flap_hz", "beat_lag_rad"))
    off = lag_deviations_from_majority(hz, lag)
    return [
        f"Trial {name}: the tail beats {abs(by) / (2 * np.pi * beat['flap_hz']) * 1e3:.0f} ms "
        f"{'before' if by < 0 else 'after'} the time at which the motor log and the other trials "
        f"have it, or that and whole beats of {1e3 / beat['flap_hz']:.0f} ms. {REMEDY}"
        for (name, beat), by in zip(beats.items(), off, strict=True)
        if by != 0.0
    ]


def _is_lag_meaningful(beat: Mapping[str, Any]) -> bool:
    """Whether the lag of a trial has a meaning: log and video have about the same frequency."""
    if beat.get("beat_lag_rad") is None or not beat.get("flap_hz"):
        return False
    ratio = (beat.get("video_hz") or np.nan) / beat["flap_hz"]
    return bool(beat.get("agrees")) or abs(ratio - 1) < REPEAT_FREQUENCY_TOLERANCE_SHARE


def lag_deviations_from_majority(flap_hz: Float, lag_rad: Float) -> Float:
    """By how much the lag of each trial (n,) differs from that of most trials, rad; 0 where it is
    alike, and for all trials where no more than half of them are alike. Trials of one frequency
    that agree with each other have a common delay, or a tail that bends: they are not out of step.
    """
    apart = wrap_angle(lag_rad[None, :] - lag_rad[:, None])
    alike = np.abs(apart) <= LAG_TOLERANCE_RAD
    most = alike[int(np.argmax(alike.sum(axis=1)))] if len(lag_rad) else alike
    if most.sum() < MIN_ALIKE_TRIALS or 2 * most.sum() <= len(lag_rad):
        return np.zeros(len(lag_rad))
    off = wrap_angle(lag_rad - np.angle(np.exp(1j * lag_rad[most]).sum()))
    repeats = np.abs(np.log(flap_hz[:, None] / flap_hz)) < REPEAT_FREQUENCY_TOLERANCE_SHARE
    confirmed = (alike & repeats).sum(axis=1) > 1
    return np.where((np.abs(off) > LAG_TOLERANCE_RAD) & ~confirmed, off, 0.0)
