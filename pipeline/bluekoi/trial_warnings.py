"""What to check in study.yaml and in trials that were used: for `check`, a run and the report."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .camera.pool_edge_check import deviating_edge_warnings
from .camera.rigid_length_warnings import rigid_length_warnings
from .camera.turned_picture import turned_picture_warnings
from .motor.log_synchrony import log_synchrony_warnings
from .motor.power_consistency import power_warnings
from .motor.stated_frequency import rounded_frequency_warnings
from .motor.swimming_plausibility import (
    clock_and_length_warnings,
    tail_length_warnings,
    trial_list_text,
)
from .pose.head_tail_swap import head_tail_swap_warnings
from .pose.trial_comparison import comparison_warnings
from .study import Study
from .study.setup_warnings import inertia_warnings, setup_warnings

UNCHECKED_FRAME_RATE_NOTE = (
    "No trial has a motor_log or flap_hz: nothing can check fps. A frame rate that is wrong by a "
    "factor of two makes all speeds wrong by that factor, without a message."
)

UNCHECKED_FLAPPING_FREQUENCY_NOTE = (
    "flap_hz is stated, no trial has a motor_log, and the keypoints of no trial show the tail "
    "beat: nothing can check flap_hz and fps. C_T is inversely proportional to the square of "
    "flap_hz. Label tail_tip, or record the motor."
)


def unchecked_frame_rate_notes(
    study: Study, statuses: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    """A note where nothing checks the frame rate: no trial states a flapping frequency, or no trial
    has a log and none shows the tail beat.

    statuses: content of status/ID.json by trial id, or what `check` knows of it.
    """
    if any(t.motor_log is not None for t in study.trials):
        return []
    if all(t.flap_hz is None for t in study.trials):
        return [UNCHECKED_FRAME_RATE_NOTE]
    found = [f for s in statuses.values() if (f := s.get("flapping"))]
    seen = any(np.isfinite(f["video_hz"]) for f in found if f.get("video_hz") is not None)
    return [UNCHECKED_FLAPPING_FREQUENCY_NOTE] if found and not seen else []


def trial_warnings(study: Study, statuses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A sentence for each doubt about robot, clocks, speeds, powers, head angles and lengths.

    statuses: content of status/ID.json by trial id, or what `check` knows of it.
    """
    trials = {trial.trial_id: trial for trial in study.trials}
    powers = {trial.trial_id: trial.power_pct for trial in study.trials}
    return [
        *setup_warnings(study.setup),
        *clock_and_length_warnings(statuses),
        *tail_length_warnings(statuses, study.setup.robot.tail_length_m),
        *power_warnings(statuses, powers),
        *rounded_frequency_warnings(
            t.flap_hz for t in study.trials if t.flap_hz is not None and t.motor_log is None
        ),
        *log_synchrony_warnings(trials, statuses),
        *head_tail_swap_warnings(trials, statuses),
        *turned_picture_warnings(trials, statuses),
        *deviating_edge_warnings(statuses, study.setup.pool),
        *comparison_warnings(study, statuses),
        *_picture_size_warnings(statuses),
    ]


def _picture_size_warnings(statuses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A sentence for each size of pictures that is not that of more than half of the trials."""
    trials: dict[tuple[int, ...], list[str]] = {}
    for name, status in statuses.items():
        if size := status.get("size_px"):
            trials.setdefault(tuple(size), []).append(name)
    usual = max(trials, key=lambda size: len(trials[size]), default=())
    if not trials or 2 * len(trials[usual]) <= sum(map(len, trials.values())):
        return []
    return [
        f"{trial_list_text(names, len(statuses))}: pictures of {size[0]} x {size[1]} px, in most "
        f"other trials of {usual[0]} x {usual[1]} px. In another mode a camera shows another part "
        "of the scene; then neither pool_corners_px nor matrix holds for these pictures."
        for size, names in trials.items()
        if size != usual
    ]


def warnings_after_run(
    study: Study,
    statuses: Mapping[str, Mapping[str, Any]],
    geometry: Mapping[str, Any] | None,
    mismatch: Mapping[str, Any] | None,
) -> list[str]:
    """`trial_warnings`, and a sentence for each doubt about clocks, lengths and inertia that only
    the results of a run show.

    statuses: content of status/ID.json by trial id. geometry, mismatch: content of geometry.json
    and mismatch.json.
    """
    failed = [name for name, status in statuses.items() if not status.get("ok")]
    if (geometry or {}).get("keypoint_smoothing"):
        statuses = {i: _without_smoothing_distorted_values(one) for i, one in statuses.items()}
    return [
        *trial_warnings(study, statuses),
        *unchecked_frame_rate_notes(study, statuses),
        *rigid_length_warnings(
            geometry, mismatch, study.setup.water.refractive_index, failed=failed
        ),
        *inertia_warnings(study.setup.robot, mismatch),
    ]


def _without_smoothing_distorted_values(status: Mapping[str, Any]) -> dict[str, Any]:
    """Status of a trial without the numbers that smoothed keypoints distort: the excursion of the
    tail tip, and lengths in turns.
    """
    swimming = {k: v for k, v in (status.get("swimming") or {}).items() if k != "strouhal"}
    return {**status, "swimming": swimming, "turned_picture": {}}
