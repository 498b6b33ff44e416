"""Small keypoint studies for tests of the stages and of the workflow."""

from __future__ import annotations

import atexit
import csv
import shutil
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

from bluekoi.camera import map_keypoints, pool_camera
from bluekoi.data import KeypointPositions
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial
from bluekoi.study import Study, Trial
from bluekoi.synthetic.ground_truth_physics import (
    Coefficients,
    GroundTruthPhysics,
    published_model_physics,
)
from bluekoi.synthetic.synthetic_study_design import StudyDesign, full_factorial_trial_plans
from validation.tracking_noise import keypoint_study

TABLE_1 = {
    50: Coefficients(C_Da=0.3, C_Md=0.145),
    75: Coefficients(C_Da=2.5, C_Md=0.130),
    100: Coefficients(C_Da=4.0, C_Md=0.104),
}
SMALL_STUDY_TRIALS = (
    "T09",
    "T10",
    "T11",
)  # full power, so the shortest: straight, 30 degrees, -45 degrees


def published_model_design(seed: int = 12, *, table_1: bool = False) -> StudyDesign:
    """12 trials of the paper's bare model in still water; Table I per power if asked.

    With the common coefficients the radii do not depend on power (docs/paper.md, Audit: Power).
    """
    settings = ((0.0, 0.12), (30.0, 0.12), (-45.0, 0.12), (45.0, 0.175))
    plans = full_factorial_trial_plans((50, 75, 100), settings)
    at = TABLE_1 if table_1 else {}
    name = "table_1" if table_1 else "bare"
    return StudyDesign(
        name, plans, published_model_physics(GroundTruthPhysics()), seed, coefficients_at=at
    )


def small_study(folder: Path) -> Path:
    """A study of three keypoint trials, simulated from the bare model, in `folder`."""
    for made, place in zip(
        _simulated_small_study(), (folder, folder.with_name("truth")), strict=True
    ):
        shutil.copytree(made, place, dirs_exist_ok=True)
    return folder


@cache
def _simulated_small_study() -> tuple[Path, Path]:
    """The small study and its truth, simulated once in a process; half a second."""
    root = tempfile.mkdtemp(prefix="bluekoi-small-study-")
    atexit.register(shutil.rmtree, root, ignore_errors=True)
    made = Path(root, "study"), Path(root, "truth")
    design = published_model_design()
    plans = tuple(plan for plan in design.plans if plan.trial_id in SMALL_STUDY_TRIALS)
    keypoint_study(replace(design, plans=plans), *made)
    return made


def edit_trials_csv(study: Path, **cells: dict[str, str]) -> None:
    """Change cells of trials.csv: `edit_trials_csv(study, T09={"fps": "30"})`."""
    with (study / "trials.csv").open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    names = list(dict.fromkeys([*rows[0], *(n for change in cells.values() for n in change)]))
    with (study / "trials.csv").open("w", newline="") as out:
        writer = csv.DictWriter(out, names, restval="")
        writer.writeheader()
        writer.writerows([row | cells.get(row["trial_id"], {}) for row in rows])


def mapped_turn(study: Study) -> tuple[Study, Trial, KeypointPositions]:
    """A small study, its turn T10 (30 degrees, 1x head), and that trial's keypoints in the pool."""
    trial = study.trial("T10")
    found = read_keypoints_of_trial(study.paths(trial)[0], trial, study.setup.bodyparts)
    depth = study.setup.robot.keypoint_depth_m
    return study, trial, map_keypoints(pool_camera(study.setup), found, depth)
