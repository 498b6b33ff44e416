"""Whether a trial's results are up to date: what they were made from, and whether they are whole.

The status file of a trial holds the hash of all that its results depend on (`inputs`) and the size
of each result (`products`). A stage skips trials for which both agree with what is there.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..files import read_json
from ..study import Study, Trial
from .depth import keypoint_depth
from .keypoint_errors_file import displacements_of_trial
from .result_paths import ResultPaths

MAX_BYTES_COMPARED_BY_CONTENT = 2**20
"""Files up to this size are compared by content, larger ones (videos) by size and date."""
MAX_FILES_READ = 20
"""Source files of a trial whose content is read to compare them; more are pictures."""
COLUMNS_WITHOUT_EFFECT_ON_KEYPOINTS = (
    "role",
    "power_pct",
    "head_angle_deg",
    "head_length_m",
    "motor_log",
    "flap_hz",
)
"""Columns of trials.csv without meaning for the reading of a keypoint file."""


def status_file_path(stage: str, layout: ResultPaths, trial_id: str) -> Path:
    """File in which a stage reports on one trial."""
    known = {
        "keypoints": layout.detection_status,
        "tracks": layout.status,
        "overlay": layout.overlay_status,
    }
    return known[stage](trial_id)


def trial_inputs_hash(
    stage: str, study: Study, trial: Trial, layout: ResultPaths, code: str
) -> str:
    """Hash of all that the results of a stage for one trial depend on.

    code: hash of the source files that the stage runs.
    """
    depends = {
        "keypoints": _detection_inputs,
        "tracks": _motion_inputs,
        "overlay": _overlay_inputs,
    }[stage]
    return short_hash(code, depends(study, trial, layout))


def is_fresh(status: Path, results: Path, inputs: str) -> bool:
    """Whether a trial's results were made from these inputs and are all there, whole."""
    if not status.is_file():
        return False
    try:
        found = read_json(status)
    except InputError:
        return False
    whole = all(
        _file_size(results / name) == size for name, size in found.get("products", {}).items()
    )
    return whole and found.get("inputs") == inputs


def _detection_inputs(study: Study, trial: Trial, _: ResultPaths) -> list[Any]:
    files, setup = file_fingerprints(study.paths(trial)), study.setup
    if not trial.reads_keypoints:
        return [
            without_keys(trial_row_as_dict(trial), "role"),
            setup.model_dump(mode="json"),
            files,
        ]
    return [
        without_keys(trial_row_as_dict(trial), *COLUMNS_WITHOUT_EFFECT_ON_KEYPOINTS),
        setup.bodyparts,
        setup.detection.model_dump(),
        files,
    ]


def _motion_inputs(study: Study, trial: Trial, layout: ResultPaths) -> list[Any]:
    setup = without_keys(study.setup.model_dump(mode="json"), "detection")
    log = study.motor_path(trial)
    depth_m = keypoint_depth(study.setup, layout)
    given = study.setup.robot.keypoint_depth_given
    displaced = displacements_of_trial(trial, layout)
    files = [
        file_fingerprint(path) for path in (layout.detection_status(trial.trial_id), log) if path
    ]
    return [without_keys(trial_row_as_dict(trial), "role"), setup, given, depth_m, displaced, files]


def _overlay_inputs(study: Study, trial: Trial, layout: ResultPaths) -> list[Any]:
    films = [] if trial.reads_keypoints else list(study.paths(trial))
    fits = (layout.status(trial.trial_id), layout.coefficients, layout.mismatch)
    return [
        _motion_inputs(study, trial, layout),
        [*file_fingerprints(films), *map(file_fingerprint, fits)],
    ]


def file_fingerprints(paths: Sequence[Path]) -> list[str]:
    """State of each source file; of many pictures, one hash of their names, sizes and dates."""
    if len(paths) <= MAX_FILES_READ:
        return [file_fingerprint(path) for path in paths]
    found = [(path, path.stat()) for path in paths if path.is_file()]
    return [short_hash([[path.name, one.st_size, one.st_mtime_ns] for path, one in found])]


def file_fingerprint(path: Path) -> str:
    """Hash of a small file's content; of a large one's size and date; empty where there is none."""
    try:
        found = path.stat()
    except OSError:
        return ""
    return _size_and_date_hash(path, found.st_size, found.st_mtime_ns)


@cache
def _size_and_date_hash(path: Path, size: int, changed_ns: int) -> str:
    large = size > MAX_BYTES_COMPARED_BY_CONTENT or not path.is_file()
    content = f"{size} {changed_ns}".encode() if large else path.read_bytes()
    return hashlib.sha256(content).hexdigest()[:12]


def trial_row_as_dict(trial: Trial) -> dict[str, Any]:
    """A row of trials.csv as plain values."""
    return trial.model_dump(mode="json")


def without_keys(content: Mapping[str, Any], *names: str) -> dict[str, Any]:
    """A mapping without some of its keys."""
    return {key: value for key, value in content.items() if key not in names}


def short_hash(*content: Any) -> str:
    """Short hash of plain values."""
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _file_size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else -1
