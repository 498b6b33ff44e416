"""Errors of keypoint files that the rigid lengths of all trials show.

A stage of its own, because the tracks need it, and do not need the rest of the geometry check.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..camera.keypoint_displacement import (
    keypoint_displacements,
    vectors_m,
    without_displacements,
)
from ..camera.keypoint_smoothing import keypoint_smoothing
from ..camera.rigid_distances import rigid_distances
from ..errors import InputError
from ..files import read_json_if_present, write_json
from ..study import Study, Trial, load_study
from .layout import ResultPaths
from .mapped_keypoints import (
    mapped_keypoint_positions,
    trial_camera,
    trials_with_measured_lengths,
)

NO_ERRORS: Mapping[str, Any] = {"displacements": {}, "smoothing": None}


def keypoint_errors(study: Path, results: Path) -> None:
    """Write status/stages/keypoint_errors.json: `displacements` by keypoint and `smoothing`, of the
    trials whose keypoints are read from files. Silhouettes and dots are found by BlueKoi itself.
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
    displaced = keypoint_displacements(mapped, lengths, robot)
    placed = [without_displacements(one, vectors_m(displaced)) for one in mapped]
    smoothing = keypoint_smoothing(rigid_distances(placed, lengths, robot))
    return {
        "displacements": {name: asdict(one) for name, one in displaced.items()},
        "smoothing": asdict(smoothing) if smoothing else None,
    }


def read_keypoint_errors(layout: ResultPaths) -> Mapping[str, Any]:
    """Content of status/stages/keypoint_errors.json; no errors in a study of videos alone, which
    has no such file.
    """
    return read_json_if_present(layout.keypoint_errors) or NO_ERRORS


def displacement_vectors_m(trial: Trial, layout: ResultPaths) -> dict[str, tuple[float, float]]:
    """Keypoint -> displacement (x, y) in the pool frame, m, in the keypoints of a trial."""
    found = read_keypoint_errors(layout)["displacements"] if trial.reads_keypoints else {}
    return {name: (one["x_m"], one["y_m"]) for name, one in found.items()}
