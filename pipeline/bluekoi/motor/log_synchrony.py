"""Trials whose tail beat has another phase against the motor log than in the other trials.

The beat is behind the shaft by a lag that is alike in all trials. If log and video of a trial do
not begin together, or the log is another trial's, its lag is arbitrary. A clock that is wrong
by the same time in all trials is measured from the lags of several powers (`log_video_delay`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..data import Float
from ..study import Trial
from .log_video_delay import REPEAT_FREQUENCY_TOLERANCE_SHARE, are_repeats
from .shaft_angle import wrap_angle

LAG_TOLERANCE_RAD = 0.7
"""Lags within this of each other are alike. Of 1302 lags in 68 simulated studies, 90 % are within
0.02 and 98 % within 0.7 of the mean of their study; a lag by chance is so in 22 % of all cases."""
MIN_TRIALS_WITH_EQUAL_LAG = 3
"""Two trials out of step are alike by chance in 22 % of all cases, three in 5 %."""
MIN_DEVIATING_TRIALS = 2
"""Besides `MIN_TRIALS_WITH_EQUAL_LAG` that are alike; a single trial is out of step by itself. With
98 % of the lags alike and the others arbitrary, two groups appear by chance in 0.05 % of all cases
with five trials and in 0.4 % with twelve (20,000 draws each; a test repeats the latter). If all
lags are arbitrary, they appear in 10 % with five and in 84 % with eight, mostly beside further
lags.
"""
HALF_BEAT_TOLERANCE_BEATS = 0.05
"""Lags within this of half a beat have a second explanation."""
HALF_BEAT_REMEDY = (
    " A lag of half a beat is also that of a mirrored picture, and of keypoints that were averaged "
    "over more than a beat."
)
LOG_SYNCHRONY_REMEDY = (
    "Do video and log begin together, is the beginning of the video cut off, and is the log this "
    "trial's? Check motor_log and start_s."
)


def log_synchrony_warnings(
    trials: Mapping[str, Trial], statuses: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    """A sentence for each motor log that several recordings share, for each trial whose tail beat
    is out of step with its log, and for trials of one frequency that are out of step with each
    other.

    statuses: content of status/ID.json by trial id, or what `check` knows of it.
    """
    seen = {name: status.get("flapping") or {} for name, status in statuses.items()
            if status.get("ok")}  # fmt: skip
    beats = {name: beat for name, beat in seen.items() if _is_lag_meaningful(beat)}
    return [
        *_shared_log_warnings(trials),
        *_deviating_lag_warnings(beats),
        *_several_lags_warnings(beats),
    ]


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


def _deviating_lag_warnings(beats: Mapping[str, Mapping[str, Any]]) -> list[str]:
    off = lag_deviations_from_majority(*_frequencies_and_lags(beats))
    return [
        f"Trial {name}: the tail beats {abs(by) / (2 * np.pi * beat['flap_hz']) * 1e3:.0f} ms "
        f"{'before' if by < 0 else 'after'} the time at which the motor log and the other trials "
        f"have it, or that and whole beats of {1e3 / beat['flap_hz']:.0f} ms. "
        f"{LOG_SYNCHRONY_REMEDY}"
        f"{_half_beat_remedy(by / (2.0 * np.pi))}"
        for (name, beat), by in zip(beats.items(), off, strict=True)
        if by != 0.0
    ]


def _several_lags_warnings(beats: Mapping[str, Mapping[str, Any]]) -> list[str]:
    names, (hz, lag) = np.array(list(beats)), _frequencies_and_lags(beats)
    return [
        _scattered_delays_warning(names, hz, groups) if groups.is_scattered
        else _two_delays_warning(names, hz, groups)
        for groups in lag_groups_of_repeats(hz, lag)
    ]  # fmt: skip


def _two_delays_warning(names: np.ndarray, flap_hz: Float, groups: LagGroups) -> str:
    beat_ms = 1e3 / flap_hz[groups.largest].mean()
    later_ms = beat_ms * groups.lag_difference_beats
    return (
        f"Trials {', '.join(names[groups.largest])} and trials {', '.join(names[groups.second])} "
        f"flap at the same frequency, {1e3 / beat_ms:.2f} Hz, but against their motor logs the "
        f"tails of the second group beat {abs(later_ms):.0f} ms "
        f"{'earlier' if later_ms < 0 else 'later'}, or by that plus a whole number of "
        f"beats of {beat_ms:.0f} ms: in one of these groups, log and video do not begin "
        "together. Check time_s in the motor logs, and start_s."
        f"{_half_beat_remedy(groups.lag_difference_beats)}"
    )


def _half_beat_remedy(lag_beats: float) -> str:
    return HALF_BEAT_REMEDY if abs(abs(lag_beats) - 0.5) < HALF_BEAT_TOLERANCE_BEATS else ""


def _scattered_delays_warning(names: np.ndarray, flap_hz: Float, groups: LagGroups) -> str:
    trials = np.sort(np.concatenate([groups.largest, groups.second, groups.others]))
    return (
        f"Trials {', '.join(names[trials])} flap at the same frequency, "
        f"{flap_hz[trials].mean():.2f} Hz, but their tails beat at different times after their "
        "motor logs: most of these logs do not begin together with their videos. Check time_s in "
        "the motor logs, and start_s."
    )


def _frequencies_and_lags(beats: Mapping[str, Mapping[str, Any]]) -> tuple[Float, Float]:
    hz, lag = (np.array([b[key] for b in beats.values()]) for key in ("flap_hz", "beat_lag_rad"))
    return hz, lag


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
    alike = _lags_agree(lag_rad)
    most = alike[int(np.argmax(alike.sum(axis=1)))] if len(lag_rad) else alike
    if most.sum() < MIN_TRIALS_WITH_EQUAL_LAG or 2 * most.sum() <= len(lag_rad):
        return np.zeros(len(lag_rad))
    off = wrap_angle(lag_rad - np.angle(np.exp(1j * lag_rad[most]).sum()))
    confirmed = (alike & are_repeats(flap_hz)).sum(axis=1) > 1
    return np.where((np.abs(off) > LAG_TOLERANCE_RAD) & ~confirmed, off, 0.0)


def _lags_agree(lag_rad: Float) -> np.ndarray:
    """Whether lags are within `LAG_TOLERANCE_RAD` of each other, (n, n)."""
    apart = wrap_angle(lag_rad[None, :] - lag_rad[:, None])
    return np.asarray(np.abs(apart) <= LAG_TOLERANCE_RAD)


@dataclass(frozen=True)
class LagGroups:
    """Trials of one frequency in groups of alike lags, as indices among all trials.

    lag_difference_beats: how much later the second group's tails beat, in beats from -0.5 to 0.5.
    others: trials in neither of the two.
    """

    largest: np.ndarray
    second: np.ndarray
    others: np.ndarray
    lag_difference_beats: float

    @property
    def is_scattered(self) -> bool:
        """Whether there are more than two lags, and none of them is that of most trials."""
        total = len(self.largest) + len(self.second) + len(self.others)
        return len(self.others) >= MIN_DEVIATING_TRIALS and 2 * len(self.largest) <= total


def lag_groups_of_repeats(flap_hz: Float, lag_rad: Float) -> list[LagGroups]:
    """Trials of one frequency whose lags (n,) differ: at least `MIN_TRIALS_WITH_EQUAL_LAG` are
    alike, and at least `MIN_DEVIATING_TRIALS` others.

    One delay of all logs, or a tail that bends, changes all lags at a frequency alike.
    """
    alike, repeats = _lags_agree(lag_rad), are_repeats(flap_hz)
    left, found = np.ones(len(lag_rad), dtype=bool), []
    while left.any():
        near = repeats & left
        same = near[int(np.argmax(near.sum(axis=1) * left))]
        left &= ~same
        pairs = alike & same & same[:, None]
        largest = pairs[int(np.argmax(pairs.sum(axis=1)))]
        rest = pairs & ~largest & ~largest[:, None]
        second = rest[int(np.argmax(rest.sum(axis=1)))]
        if largest.sum() >= MIN_TRIALS_WITH_EQUAL_LAG and second.sum() >= MIN_DEVIATING_TRIALS:
            mean, other = (np.exp(1j * lag_rad[some]).sum() for some in (largest, second))
            found.append(LagGroups(
                largest=np.flatnonzero(largest), second=np.flatnonzero(second),
                others=np.flatnonzero(same & ~largest & ~second),
                lag_difference_beats=float(np.angle(other / mean)) / (2 * np.pi),
            ))  # fmt: skip
    return found
