"""Keypoints of a study in the pool frame, as the stages on all trials take them."""

from __future__ import annotations

from collections.abc import Sequence

from ..camera.pool_projection import PoolCamera, map_keypoints
from ..camera.study_camera import pool_camera
from ..data import KeypointPositions
from ..files import read_json
from ..keypoints.deeplabcut import read_detections
from ..pose.gap_filled_frames import without_filled_frames
from ..study import Study, Trial
from .result_paths import ResultPaths
from .status import has_measured_lengths, successful_trials


def trials_with_measured_lengths(study: Study, layout: ResultPaths) -> list[str]:
    """Names of the trials whose keypoints were not placed at stated lengths."""
    ids = [trial.trial_id for trial in study.trials]
    good = successful_trials([layout.detection_status(trial_id) for trial_id in ids])
    return [name for name in good if has_measured_lengths(layout.detection_status(name))]


def trial_camera(study: Study, trial: Trial, layout: ResultPaths) -> PoolCamera:
    """Camera of a trial, for the size of its picture."""
    size = read_json(layout.detection_status(trial.trial_id)).get("size_px")
    return pool_camera(study.setup, (size[0], size[1]) if size else None)


def mapped_keypoint_positions(
    camera: PoolCamera, trials: Sequence[Trial], layout: ResultPaths, depth_m: float
) -> list[KeypointPositions]:
    """Positions in the pool frame, of keypoints at a depth, m; frames that were filled in have no
    likelihood.
    """
    found = (read_detections(layout.keypoints(trial.trial_id), trial) for trial in trials)
    return [map_keypoints(camera, without_filled_frames(one), depth_m) for one in found]
