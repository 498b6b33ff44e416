"""What status/stages/keypoint_errors.json says, for the stages that correct these errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..camera.keypoint_displacement_field import KeypointDisplacementField
from ..files import read_json_if_present
from ..study import Trial
from .result_paths import ResultPaths

NO_ERRORS: Mapping[str, Any] = {
    "displacements": [],
    "displacements_visible": True,
    "smoothing": None,
    "least_visible_smoothing_s": None,
}


def read_keypoint_errors(layout: ResultPaths) -> Mapping[str, Any]:
    """Content of status/stages/keypoint_errors.json; no errors in a study of videos alone, which
    has no such file.
    """
    return read_json_if_present(layout.keypoint_errors) or NO_ERRORS


def displacements_of_trial(
    trial: Trial, layout: ResultPaths
) -> dict[str, KeypointDisplacementField]:
    """Keypoint -> displacement in the pool frame, in the keypoints of a trial."""
    if not trial.reads_keypoints:
        return {}
    parts = read_keypoint_errors(layout)["displacements"]
    return {
        name: KeypointDisplacementField(one["x_m"], one["y_m"], one.get("parallax", 0.0))
        for part in parts
        if trial.trial_id in part["trials"]
        for name, one in part["keypoints"].items()
    }
