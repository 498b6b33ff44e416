"""Errors of keypoint files that the rigid lengths of all trials show.

This is not part of the stage `geometry`, because the tracks need these errors, but not the rest of
the geometry check.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..camera.displacement_change_point import displacements_by_session_part
from ..camera.keypoint_displacement import displacement_fields, displacements_identifiable
from ..camera.keypoint_displacement_field import remove_keypoint_displacements
from ..camera.rigid_distances import rigid_distances
from ..camera.smoothing_detection import estimate_keypoint_smoothing
from ..errors import InputError
from ..files import write_json
from ..study import Study, Trial, load_study
from .keypoint_errors_file import NO_ERRORS
from .mapped_keypoints import (
    mapped_keypoint_positions,
    trial_camera,
    trials_with_measured_lengths,
)
from .result_paths import ResultPaths


def keypoint_errors(study: Path, results: Path) -> None:
    """Write status/stages/keypoint_errors.json, of the trials whose keypoints are read from files:
    `displacements` by part of the session and keypoint, whether there are enough lengths to show
    them, `smoothing`, and the duration of the shortest smoothing that would be seen. Silhouettes
    and dots are found by BlueKoi itself.
    """
    loaded, layout = load_study(study), ResultPaths(results)
    read = [trial for name in trials_with_measured_lengths(loaded, layout)
            if (trial := loaded.trial(name)).reads_keypoints]  # fmt: skip
    try:
        found = _errors_of_trials(loaded, read, layout) if read else dict(NO_ERRORS)
    except InputError:  # no rigid length was seen, which the geometry check reports
        found = dict(NO_ERRORS)
    write_json(layout.keypoint_errors, found)


def _errors_of_trials(study: Study, trials: list[Trial], layout: ResultPaths) -> dict[str, Any]:
    robot, lengths = study.setup.robot, [trial.head_length_m for trial in trials]
    camera = trial_camera(study, trials[0], layout)
    mapped = mapped_keypoint_positions(camera, trials, layout, robot.keypoint_depth_m)
    displaced, placed = displacements_by_session_part(mapped, lengths, robot), list(mapped)
    for part, found in displaced:
        for k in part:
            placed[k] = remove_keypoint_displacements(mapped[k], displacement_fields(found))
    distances = rigid_distances(placed, lengths, robot)
    smoothing = estimate_keypoint_smoothing(distances)
    return {
        "displacements_visible": displacements_identifiable(distances),
        "displacements": [
            {
                "trials": [trials[k].trial_id for k in part],
                "keypoints": {name: asdict(one) for name, one in found.items()},
            }
            for part, found in displaced
        ],
        "smoothing": asdict(smoothing) if smoothing and smoothing.is_found else None,
        "least_visible_smoothing_s": smoothing.least_duration_s if smoothing else None,
    }
