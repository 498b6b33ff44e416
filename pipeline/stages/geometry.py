"""What the rigid distances of all trials say about scale, lens, pose and depth."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..camera import map_keypoints, pool_camera
from ..camera.distances import Geometry
from ..camera.geometry import GeometryCheck, check_distances, check_geometry, estimate_depth
from ..camera.pool import PoolCamera
from ..camera.suspects import Estimate
from ..camera.whole_length import WHOLE, systematic, whole_lengths
from ..data import Positions
from ..faults import Fault
from ..files import read_json, write_json
from ..keypoints.deeplabcut import read
from ..study import Setup, Study, Trial, load_study
from .layout import Layout
from .status import good_trials, lengths_measured

STATED = (
    "the keypoints were placed at the lengths of study.yaml, which say nothing of scale, lens or "
    "depth, and too few frames show nose and tail's end; dots, markers or a network would tell"
)
STATED_WRONGLY = "; so would body_length_m or tail_length_m stated wrongly: measure the robot again"
COMES_OUT = "the body's whole length, nose to tail, comes out"
USEFUL_DEPTH_STD_M = 0.01
"""An estimated depth less certain than this is worth less than the usual one."""


def geometry(study: Path, results: Path) -> None:
    """Write geometry.json: scale, depth and the likely error, each with what speaks for it.

    scale: measured over true lengths, given the robot's lengths in study.yaml, with scale_std
    (trials as clusters), by `measured`: its rigid parts, or its whole length where a silhouette's
    keypoints lie at stated lengths. depth_m: of the keypoints, estimated where study.yaml does not
    give it and the distances tell it to 10 mm. likely: `nothing`, an error's name, or `unknown`.
    map: relative error of the distances over the pool, and what the likely error predicts there.
    """
    loaded, layout = load_study(study), Layout(results)
    ids = [trial.trial_id for trial in loaded.trials]
    good = good_trials([layout.detection(trial_id) for trial_id in ids])
    measured = [name for name in good if lengths_measured(layout.detection(name))]
    try:
        if good and not measured:
            told = _told_whole(loaded, [loaded.trial(name) for name in good], layout)
        else:
            told = _told(loaded, [loaded.trial(name) for name in measured], layout)
    except Fault as nothing:
        told = _unknown(loaded.setup, str(nothing))
    write_json(layout.geometry, told)


def _told(study: Study, trials: list[Trial], layout: Layout) -> dict[str, Any]:
    setup, depth = study.setup, study.setup.robot.keypoint_depth_m
    if not trials:
        return _unknown(setup, "no trial with keypoints")
    camera = _camera(study, trials[0], layout)
    lengths = [trial.head_length_m for trial in trials]
    placed = _placed(camera, trials, layout, depth)
    found, std = (depth, 0.0) if camera.lens is None else estimate_depth(
        camera, placed, depth_m=depth, head_lengths_m=lengths, robot=setup.robot
    )  # fmt: skip
    if _taken(setup, found, std):
        depth = found
        placed = _placed(camera, trials, layout, depth)
    check = check_geometry(camera, placed, depth_m=depth, head_lengths_m=lengths, robot=setup.robot)
    return {
        **_evidence(check),
        "measured": "rigid parts",
        "depth_m": depth,
        "depth_given": setup.robot.depth_given,
        "depth_estimate_m": found if std else None,
        "depth_estimate_std_m": std or None,
        "trials": len(trials),
    }


def _told_whole(study: Study, trials: list[Trial], layout: Layout) -> dict[str, Any]:
    """What the body's whole length tells where keypoints lie at stated lengths."""
    setup, depth = study.setup, study.setup.robot.keypoint_depth_m
    seen = [read_json(layout.detection(t.trial_id)).get("length_seen") or [] for t in trials]
    if not any(seen):
        return _unknown(setup, STATED)
    camera = _camera(study, trials[0], layout)
    distances = whole_lengths(
        _placed(camera, trials, layout, depth),
        [np.array(pairs, dtype=np.float64) for pairs in seen],
        [trial.head_length_m for trial in trials],
        setup.robot,
    )
    geometry = Geometry(camera, depth)
    least = systematic(geometry, distances)
    given = ("keypoint_depth",) if setup.robot.depth_given else ()
    check = check_distances(geometry, distances, what=COMES_OUT, least=least, given=given)
    also = "" if check.best is None else STATED_WRONGLY
    return {
        **_evidence(check),
        "sentence": f"{check.sentence}{also}",
        "measured": WHOLE,
        "least": least,
        "depth_m": depth,
        "depth_given": setup.robot.depth_given,
        "depth_estimate_m": None,
        "depth_estimate_std_m": None,
        "trials": len({int(trial) for trial in distances.trial}),
    }


def _camera(study: Study, trial: Trial, layout: Layout) -> PoolCamera:
    size = read_json(layout.detection(trial.trial_id)).get("size_px")
    return pool_camera(study.setup, (size[0], size[1]) if size else None)


def _placed(
    camera: PoolCamera, trials: list[Trial], layout: Layout, depth_m: float
) -> list[Positions]:
    def place(trial: Trial) -> Positions:
        whole = trial.model_copy(update={"start_s": None, "end_s": None, "fps": trial.fps or 30.0})
        return map_keypoints(camera, read(layout.keypoints(trial.trial_id), whole, {}), depth_m)

    return [place(trial) for trial in trials]


def _taken(setup: Setup, depth_m: float, std_m: float) -> bool:
    inside = 0 <= depth_m < setup.pool.depth_m
    return not setup.robot.depth_given and 0 < std_m < USEFUL_DEPTH_STD_M and inside


def _evidence(check: GeometryCheck) -> dict[str, Any]:
    pool = next((e for e in check.estimates if e.suspect.name == "scale_error"), None)
    seen = 1 / (1 + pool.values[0]) if pool else None
    return {
        "scale": seen,
        "scale_std": pool.stds[0] * seen**2 if pool and seen else None,
        "likely": check.outcome,
        "rivals": check.rivals,
        "sentence": check.sentence,
        "mean_excess": check.mean_excess,
        "mean_excess_std": check.mean_excess_std,
        "estimates": [_row(estimate) for estimate in check.estimates],
        "map": asdict(check.map),
    }


def _row(estimate: Estimate) -> dict[str, Any]:
    return {
        "name": estimate.suspect.name,
        "parameters": estimate.suspect.parameters,
        "units": estimate.suspect.units,
        "values": estimate.values,
        "stds": estimate.stds,
        "gain": estimate.gain,
        "p_value": estimate.p_value,
        "share": estimate.share,
        "seen": estimate.seen,
        "text": estimate.text,
    }


def _unknown(setup: Setup, why: str) -> dict[str, Any]:
    return {
        "scale": None,
        "scale_std": None,
        "likely": "unknown",
        "rivals": [],
        "sentence": f"the geometry could not be checked: {why}",
        "depth_m": setup.robot.keypoint_depth_m,
        "depth_given": setup.robot.depth_given,
        "estimates": [],
        "map": None,
    }
