"""Scale, lens, pose and depth checked by the rigid distances of all trials: geometry.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..camera.geometry_hypotheses import HypothesisFit
from ..camera.keypoint_displacement_field import remove_keypoint_displacements
from ..camera.pool_projection import PoolCamera
from ..camera.rigid_distances import CameraGeometry, rigid_distances
from ..camera.rigid_length_check import (
    GeometryCheck,
    check_rigid_distances,
    estimate_keypoint_depth,
)
from ..camera.rigid_length_windows import windows_to_columns
from ..camera.smoothing_detection import undo_smoothing_of_lengths
from ..camera.whole_body_length import (
    WHOLE_LENGTH_LABEL,
    systematic_length_error_share,
    whole_body_lengths,
)
from ..data import KeypointPositions
from ..errors import InputError
from ..files import read_json, write_json
from ..study import Study, Trial, load_study
from ..study.keypoint_depth import select_keypoint_depth_m
from .keypoint_errors_file import displacements_of_trial, read_keypoint_errors
from .mapped_keypoints import (
    mapped_keypoint_positions,
    trial_camera,
    trials_with_measured_lengths,
)
from .result_paths import ResultPaths
from .status import successful_trials

LENGTHS_NOT_MEASURED = (
    "the keypoints were placed at the lengths of study.yaml, which say nothing of scale, lens or "
    "depth"
)
TAIL_END_NOT_SEEN = (
    ", and no frame shows the end of the tail near the position given by body_length_m and "
    "tail_length_m: measure both again, or use dots, markers or a network"
)
WHOLE_LENGTH_NOT_MEASURED = (
    ", and no whole length was measured (keypoint files of the silhouette detector hold it in the "
    ".cov.csv beside them)"
)
STATED_LENGTH_ADVICE = (
    "; so would body_length_m or tail_length_m stated wrongly: measure the robot again"
)
WHOLE_LENGTH_SENTENCE_SUBJECT = "the body's whole length, nose to tail, comes out"


def geometry(study: Path, results: Path) -> None:
    """Write geometry.json: scale, depth and the likely error, each with its evidence.

    scale: measured over true lengths, given the robot's lengths in study.yaml, with scale_std
    (trials as clusters), by `measured`: its rigid parts, or its whole length where a silhouette's
    keypoints lie at stated lengths. depth_m: of the keypoints, by the rule of
    study/keypoint_depth.py.
    likely: `nothing`, an error's name, or `unknown`. by_trial: relative error of each trial's
    lengths that the likely error leaves. map: relative error of the distances over the
    pool, and what the likely error predicts there. windows: means of the distances over half a
    second, which the mismatch stage compares errors of the camera with. keypoint_displacements:
    those in the pool, which are subtracted here and in the tracks. keypoint_smoothing:
    the smoothing of the keypoints that lengths of turning parts show. tail_end_seen: False
    where no frame shows the body's whole length; trials_without_tail_end: those of which no frame
    does while most others have such frames.
    """
    loaded, layout = load_study(study), ResultPaths(results)
    ids = [trial.trial_id for trial in loaded.trials]
    good = successful_trials([layout.detection_status(trial_id) for trial_id in ids])
    measured = trials_with_measured_lengths(loaded, layout)
    check = _check_by_whole_lengths if good and not measured else _check_by_rigid_parts
    try:
        found = check(loaded, [loaded.trial(name) for name in measured or good], layout)
    except InputError as error:
        found = _impossible_geometry_check_json(str(error))
    setup = loaded.setup
    errors = read_keypoint_errors(layout)
    usual = {
        "depth_m": setup.robot.keypoint_depth_m,
        "depth_given": setup.robot.keypoint_depth_given,
        "keypoint_displacements": errors["displacements"],
        "keypoint_displacements_visible": errors["displacements_visible"],
        "keypoint_smoothing": errors["smoothing"],
        "least_visible_smoothing_s": errors["least_visible_smoothing_s"],
    }
    write_json(layout.geometry, usual | found)


def _check_by_rigid_parts(study: Study, trials: list[Trial], layout: ResultPaths) -> dict[str, Any]:
    setup, depth = study.setup, study.setup.robot.keypoint_depth_m
    if not trials:
        return _impossible_geometry_check_json("no trial with keypoints")
    camera = trial_camera(study, trials[0], layout)
    lengths = [trial.head_length_m for trial in trials]
    placed = _keypoints_without_displacements(camera, trials, layout, depth)
    estimate, std = (depth, 0.0) if camera.lens is None else estimate_keypoint_depth(
        camera, placed, depth_m=depth, head_lengths_m=lengths, robot=setup.robot
    )  # fmt: skip
    if (used := select_keypoint_depth_m(setup, estimate, std)) != depth:
        depth, placed = used, _keypoints_without_displacements(camera, trials, layout, used)
    distances = rigid_distances(placed, lengths, setup.robot)
    errors = read_keypoint_errors(layout)
    if errors["smoothing"]:
        read = np.array([trial.reads_keypoints for trial in trials])[distances.trial.astype(int)]
        distances = undo_smoothing_of_lengths(distances, read * errors["smoothing"]["variance_s2"])
    check = check_rigid_distances(CameraGeometry(camera, depth), distances)
    found = _geometry_check_json(check, trials)
    if errors["displacements"]:
        found["sentence"] = f"displaced keypoints corrected; {found['sentence']}"
    return {
        **found,
        "measured": "rigid parts",
        "depth_m": depth,
        "depth_estimate_m": estimate if std else None,
        "depth_estimate_std_m": std or None,
        "trials": len(trials),
    }


def _check_by_whole_lengths(
    study: Study, trials: list[Trial], layout: ResultPaths
) -> dict[str, Any]:
    """Scale by the body's whole length, where keypoints lie at stated lengths."""
    setup, depth = study.setup, study.setup.robot.keypoint_depth_m
    recorded = [read_json(layout.detection_status(t.trial_id)).get("length_seen") for t in trials]
    seen = [pairs or [] for pairs in recorded]
    if not any(seen):
        kept = None not in recorded
        why = TAIL_END_NOT_SEEN if kept else WHOLE_LENGTH_NOT_MEASURED
        found = _impossible_geometry_check_json(f"{LENGTHS_NOT_MEASURED}{why}")
        return {**found, "tail_end_seen": False} if kept else found
    unseen = [t.trial_id for t, pairs in zip(trials, recorded, strict=True) if pairs == []]
    camera = trial_camera(study, trials[0], layout)
    distances = whole_body_lengths(
        mapped_keypoint_positions(camera, trials, layout, depth),
        [np.array(pairs, dtype=np.float64) for pairs in seen],
        [trial.head_length_m for trial in trials],
        setup.robot,
    )
    geometry = CameraGeometry(camera, depth)
    min_share = systematic_length_error_share(geometry, distances)
    given = ("keypoint_depth",) if setup.robot.keypoint_depth_given else ()
    check = check_rigid_distances(
        geometry, distances, subject=WHOLE_LENGTH_SENTENCE_SUBJECT, min_share=min_share, given=given
    )
    also = "" if check.best is None else STATED_LENGTH_ADVICE
    return {
        **_geometry_check_json(check, trials),
        "sentence": f"{check.sentence}{also}",
        "measured": WHOLE_LENGTH_LABEL,
        "min_share": min_share,
        "depth_estimate_m": None,
        "depth_estimate_std_m": None,
        "trials": len({int(trial) for trial in distances.trial}),
        "trials_without_tail_end": unseen if 2 * len(unseen) < len(trials) else [],
    }


def _keypoints_without_displacements(
    camera: PoolCamera, trials: Sequence[Trial], layout: ResultPaths, depth_m: float
) -> list[KeypointPositions]:
    """Positions without the displacements that the rigid lengths showed."""
    return [
        remove_keypoint_displacements(one, displacements_of_trial(trial, layout))
        for trial, one in zip(
            trials, mapped_keypoint_positions(camera, trials, layout, depth_m), strict=True
        )
    ]


def _geometry_check_json(check: GeometryCheck, trials: Sequence[Trial]) -> dict[str, Any]:
    pool = next((fit for fit in check.fits if fit.hypothesis.name == "scale_error"), None)
    scale = 1 / (1 + pool.values[0]) if pool else None
    return {
        "scale": scale,
        "scale_std": pool.stds[0] * scale**2 if pool and scale else None,
        "likely": check.outcome,
        "rivals": check.rivals,
        "sentence": check.sentence,
        "mean_excess": check.mean_excess,
        "mean_excess_std": check.mean_excess_std,
        "estimates": [_hypothesis_json(fit) for fit in check.fits],
        "map": asdict(check.map),
        "by_trial": {
            trials[number].trial_id: {"excess": mean, "std": std, "number": number}
            for number, (mean, std) in check.by_trial.items()
        },
        "windows": windows_to_columns(check.windows),
    }


def _hypothesis_json(fit: HypothesisFit) -> dict[str, Any]:
    names = ("values", "stds", "gain", "p_value", "share", "detectable", "text")
    about = {name: getattr(fit.hypothesis, name) for name in ("name", "parameters", "units")}
    return about | {name: getattr(fit, name) for name in names}


def _impossible_geometry_check_json(reason: str) -> dict[str, Any]:
    return {
        "scale": None,
        "scale_std": None,
        "likely": "unknown",
        "rivals": [],
        "sentence": f"the geometry could not be checked: {reason}",
        "estimates": [],
        "map": None,
        "windows": None,
    }
