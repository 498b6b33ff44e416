"""Flapping frequency of a trial by the best source that it has, and what the others say of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..data import FlappingFrequency, KeypointPositions
from ..errors import input_error
from ..study import Study, Trial
from .clock_comparison import flapping_compared_with_video, flapping_from_stated_frequency
from .motor_log import MIN_LOGGED_SHARE, flapping_from_log, motor_log_coverage
from .tail_beat import (
    MAX_BEAT_STD_SHARE,
    tail_beat_from_video,
    tail_beat_lag,
    video_to_motor_frequency_ratio,
)
from .tail_beat_drift import tail_beat_drift


def trial_flapping(study: Study, trial: Trial, positions: KeypointPositions) -> FlappingFrequency:
    """Flapping frequency by motor log, else as given, else from the tail in the video.

    Raises: InputError where none of the three gives it.
    """
    log = study.motor_path(trial)
    if log is not None:
        flapping = _with_coverage_remark(log, flapping_from_log(log), positions)
    elif trial.flap_hz is not None:
        flapping = flapping_from_stated_frequency(trial.flap_hz)
    else:
        return _flapping_from_video(study, trial, positions)
    if flapping.flap_hz <= 0:
        return _with_beat_of_stopped_motor(flapping, positions)
    found = flapping_compared_with_video(
        flapping, *video_to_motor_frequency_ratio(positions, flapping)
    )
    if not np.isfinite(found.video_hz):
        return found
    if log is None:
        return _with_drift_in_video(found, positions)
    lag, std = tail_beat_lag(positions, flapping)
    return replace(found, beat_lag_rad=lag, beat_lag_std_rad=std)


def _with_drift_in_video(
    flapping: FlappingFrequency, positions: KeypointPositions
) -> FlappingFrequency:
    """Flapping without a motor log, with the drift of the tail beat that the video shows."""
    drift, std = tail_beat_drift(positions, flapping.video_hz)
    return replace(flapping, drift_per_s=drift, drift_std_per_s=std)


def _with_beat_of_stopped_motor(
    flapping: FlappingFrequency, positions: KeypointPositions
) -> FlappingFrequency:
    """A frequency of 0, which a clear tail beat contradicts."""
    hz, std = tail_beat_from_video(positions)
    if not std < MAX_BEAT_STD_SHARE * hz:
        return flapping
    remark = (
        f"flap_hz is 0, but the tail beats at {hz:.3g} Hz in the video: state that frequency, or "
        "leave flap_hz empty"
    )
    return replace(flapping, video_hz=hz, video_hz_std=std, agrees=False, remarks=(remark,))


def _with_coverage_remark(
    log: Path, flapping: FlappingFrequency, positions: KeypointPositions
) -> FlappingFrequency:
    share = motor_log_coverage(log, flapping, (positions.time_s[0], positions.time_s[-1]))
    if share >= MIN_LOGGED_SHARE:
        return flapping
    remark = (
        f"the motor log covers {100 * share:.0f} % of the recording; its frequency is used for all"
    )
    return replace(flapping, remarks=(*flapping.remarks, remark))


def _flapping_from_video(
    study: Study, trial: Trial, positions: KeypointPositions
) -> FlappingFrequency:
    hz, std = tail_beat_from_video(positions)
    if not hz > 0:
        raise input_error(
            study.root / "trials.csv",
            f"trial {trial.trial_id}",
            "neither motor_log nor flap_hz, and no tail beat seen in the video",
            "a flapping frequency",
            "Give motor_log or flap_hz.",
        )
    remark = "no motor log and no flap_hz: flapping frequency taken from the tail in the video"
    seen = FlappingFrequency(hz, std, "video", video_hz=hz, video_hz_std=std, remarks=(remark,))
    return _with_drift_in_video(seen, positions)


def flapping_as_json(flapping: FlappingFrequency) -> dict[str, Any]:
    """What status/ID.json says of the flapping frequency, by the names of `FlappingFrequency`."""
    names = ("flap_hz", "flap_hz_std", "source", "video_hz", "video_hz_std", "ratio", "ratio_std",
             "beat_lag_rad", "beat_lag_std_rad", "start_s", "lost_time_s", "drift_per_s",
             "drift_std_per_s", "agrees")  # fmt: skip
    return {name: getattr(flapping, name) for name in names}
