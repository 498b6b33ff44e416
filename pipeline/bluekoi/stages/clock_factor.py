"""Frame rates that are wrong by a factor, found from tail beat and motor log and corrected.

With a frame rate stated r times too high the tail beats r times as fast in the video as the motor
does. The ratio is a direct measurement of the clock. Where the trials of one stated frame rate
agree on a ratio far from 1, or trials that deviate from most others agree on one, both fits run in
true time,

    t_true = r t_recording,    speed_true = speed_recording / r,

and the search reports `clock_error` with k = r - 1. A ratio near 1 stays with the search. Files of
tracks, steady states and model paths keep the time of the recording.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ..campaign import Campaign
from ..data import FlappingFrequency, Pose, SteadyState, Track
from ..measurement import clock_error
from ..mismatch.measured_cause import measured_cause_json, with_measured_cause
from ..mismatch.wrong_clock import CLOCK_CAUSE
from ..motor import (
    common_clock_ratio,
    flapping_compared_with_video,
    trials_with_deviating_clock,
)
from ..motor.clock_comparison import CLOCK_AGREEMENT_SIGMAS, MAX_RELATIVE_CLOCK_ERROR
from ..study import Study

MIN_CLOCK_RATIO_STD_SHARE = 0.003  # ASSUME tail beat and motor log are compared to 0.3 % at best

MIN_TRIALS_THAT_SHARE_A_CLOCK_FACTOR = 3
"""Trials, of two powers or more, whose ratios must agree for a clock to be wrong in a part of the
trials. Logs that belong to other trials give equal ratios only at one power."""


@dataclass(frozen=True)
class ClockFactor:
    """Stated over true frame rate, with its standard deviation."""

    value: float
    std: float

    @property
    def sigmas_from_one(self) -> float:
        """Distance from 1 in standard deviations."""
        return abs(self.value - 1.0) / self.std


def clock_factors(
    study: Study, flapping: Mapping[str, FlappingFrequency]
) -> dict[str, ClockFactor]:
    """Trial -> factor of its frame rate, for trials whose clock is wrong by more than 25 %, and for
    those that deviate from the clock of most others and agree with each other.

    A factor of more than 25 % counts where most trials with one `fps` in trials.csv whose motor
    frequency is logged, or stated where no trial has a log, agree on it, or, failing that, most of
    all trials. It then holds for all trials of that `fps`.
    """
    groups: dict[float | None, list[str]] = {}
    for name in flapping:
        groups.setdefault(study.trial(name).fps, []).append(name)
    every = _common_factor(flapping, list(flapping))
    found = {fps: _common_factor(flapping, names) or every for fps, names in groups.items()}
    wrong = {
        fps: f for fps, f in found.items() if f and abs(f.value - 1) > MAX_RELATIVE_CLOCK_ERROR
    }
    by_rate = {name: factor for fps, factor in wrong.items() for name in groups[fps]}
    others = {name: f for name, f in flapping.items() if name not in by_rate}
    return by_rate | _factor_of_deviating_trials(study, others)


def _factor_of_deviating_trials(
    study: Study, flapping: Mapping[str, FlappingFrequency]
) -> dict[str, ClockFactor]:
    """The factor that trials with a log share whose clock is not that of most others, which is
    right: else it is not known which ones are wrong.
    """
    common = common_clock_ratio(flapping.values())
    if common is None or abs(common[0] - 1.0) > CLOCK_AGREEMENT_SIGMAS * MIN_CLOCK_RATIO_STD_SHARE:
        return {}
    logged = [n for n in trials_with_deviating_clock(flapping)
              if flapping[n].source == "motor_log" and np.isfinite(flapping[n].ratio)]  # fmt: skip
    factor = _common_factor(flapping, logged)
    if factor is None:
        return {}
    tolerance = CLOCK_AGREEMENT_SIGMAS * np.hypot(
        [flapping[n].ratio_std for n in logged], MIN_CLOCK_RATIO_STD_SHARE * factor.value
    )
    alike = [n for n, limit in zip(logged, tolerance, strict=True)
             if abs(flapping[n].ratio - factor.value) < limit]  # fmt: skip
    powers = {study.trial(n).power_pct for n in alike}
    enough = len(alike) >= MIN_TRIALS_THAT_SHARE_A_CLOCK_FACTOR and len(powers) > 1
    return dict.fromkeys(alike, factor) if enough else {}


def _common_factor(
    flapping: Mapping[str, FlappingFrequency], names: list[str]
) -> ClockFactor | None:
    known = [f for n in names if (f := flapping[n]).source != "video"]
    common = common_clock_ratio([f for f in known if f.source == "motor_log"] or known)
    return (
        ClockFactor(common[0], float(np.hypot(common[1], MIN_CLOCK_RATIO_STD_SHARE * common[0])))
        if common
        else None
    )


def correct_clock(
    campaign: Campaign, flapping: Mapping[str, FlappingFrequency]
) -> tuple[Campaign, dict[str, FlappingFrequency], dict[str, ClockFactor]]:
    """Campaign and flapping frequencies with the factors of `clock_factors` taken out."""
    factors = clock_factors(campaign.study, flapping)
    if not factors:
        return campaign, dict(flapping), factors
    r = {name: factor.value for name, factor in factors.items()}
    corrected = replace(
        campaign,
        tracks={n: _track_in_true_time(v, r.get(n, 1.0)) for n, v in campaign.tracks.items()},
        poses={n: _pose_in_true_time(v, r.get(n, 1.0)) for n, v in campaign.poses.items()},
        steady={n: _steady_in_true_time(v, r.get(n, 1.0)) for n, v in campaign.steady.items()},
    )
    beats = {n: _flapping_in_true_time(f, r[n]) if n in r else f for n, f in flapping.items()}
    return corrected, beats, factors


def _track_in_true_time(track: Track, r: float) -> Track:
    rates = [f.name for f in fields(Track) if f.name.startswith(("speed", "vx", "vy", "yaw_rate"))]
    changed: dict[str, Any] = {name: getattr(track, name) / r for name in rates}
    return replace(track, time_s=r * track.time_s, **changed)


def _pose_in_true_time(pose: Pose, r: float) -> Pose:
    return replace(pose, time_s=r * pose.time_s)


def _steady_in_true_time(row: SteadyState, r: float) -> SteadyState:
    return replace(
        row,
        speed_m_s=row.speed_m_s / r,
        speed_std_m_s=row.speed_std_m_s / r,
        steady_from_s=r * row.steady_from_s,
        steady_to_s=r * row.steady_to_s,
    )


def _flapping_in_true_time(flapping: FlappingFrequency, r: float) -> FlappingFrequency:
    """Frequencies with the ratio of clocks divided by r; the beat's lag is unknown after that."""
    bare = replace(flapping, ratio=np.nan, ratio_std=np.nan, video_hz=np.nan, video_hz_std=np.nan,
                   beat_lag_rad=np.nan, beat_lag_std_rad=np.nan, agrees=True)  # fmt: skip
    return flapping_compared_with_video(bare, flapping.ratio / r, flapping.ratio_std / r)


def with_clock_cause(
    content: Mapping[str, Any], factors: Mapping[str, ClockFactor], trials: int
) -> dict[str, Any]:
    """mismatch.json with `clock_error` as its first cause; unchanged where no factor is known.

    factors: of the fitted trials, which are `trials` in number. The factor is that of most of
    these; what the search found of the clock besides is included.
    """
    if not factors:
        return dict(content)
    factor = max(factors.values(), key=list(factors.values()).count)
    alike = sorted(n for n, f in factors.items() if f == factor)
    fine = next((c for c in content["causes"] if c["name"] == CLOCK_CAUSE), None)
    value = factor.value * (1 + (fine["parameters"]["rate_error"]["value"] if fine else 0.0))
    all_trials = len(alike) == trials
    of = "" if all_trials else f" in {len(alike)} of {trials} trials"
    said = f"fps is {value:.4g} times the true frame rate{of}"
    gear, turns = "", ""
    if all_trials:
        gear = (" If fps is right, the shaft of the log is not that of the tail (a gear between "
                "them).")  # fmt: skip
        turns = (f" (or the motor log counts {1 / factor.value:.4g} turns a tail beat: check "
                 "both)")  # fmt: skip
    cause = measured_cause_json(
        clock_error,
        {"rate_error": {"value": value - 1, "std": factor.std, "unit": "1"}},
        regime=clock_error.MOST_VISIBLE_WHERE if all_trials else f"trials {', '.join(alike)}",
        sigmas=factor.sigmas_from_one,
        sentence=f"The frame rate is wrong by a factor: {said}. The tail beats "
        f"{factor.value:.4g} times as fast in the video as the motor does.{gear}",
    )
    sentence = f"Measurement error: clock_error, {said}{turns}. In true time: {content['sentence']}"
    named = with_measured_cause(content, cause, sentence=sentence, replaces=[fine] if fine else [])
    return {**named, "clock_factor": {n: f.value for n, f in sorted(factors.items())}}
