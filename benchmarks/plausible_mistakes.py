"""Second round of plausible mistakes: what a run says of each, in a study of twelve trials.

    python benchmarks/plausible_mistakes.py [--no-search] [NAME ...]

One line a mistake: `refused` by check, `trial lost`, `named` (the verdict is a measurement error or
unexplained), `open` (no warning, not searched), `warned` beside the verdict, `harmless`
(coefficients and speeds within three standard deviations of the right study's), or `SILENT`.
The first round, and hostile files, are in `invalid_inputs.py`.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
import traceback
from pathlib import Path

import numpy as np
from invalid_inputs import (
    CORNERS_KEY,
    RIGHT_CORNERS_PX,
    Change,
    change_keypoints,
    change_motor_log,
    check_outcome,
    combine_changes,
    search_outcome,
    set_cell,
    set_column,
    set_yaml_key,
    steady_speeds,
    swap_files,
)

from bluekoi.errors import InputError
from bluekoi.stages.geometry import geometry
from bluekoi.stages.keypoints import keypoints
from bluekoi.stages.mismatch import mismatch
from bluekoi.stages.outcome import outcome
from bluekoi.stages.steady import steady
from bluekoi.stages.tracks import tracks
from bluekoi.stages.tuning import tuning
from bluekoi.study import load_study
from small_studies import published_model_design
from validation.tracking_noise import keypoint_study

ALL_TRIALS = tuple(f"T{k:02d}" for k in range(1, 13))
"""At 50, 75 and 100 %: straight, 30 and -45 degrees, and 45 degrees with a long head."""


def exchange_keypoint_names(*order: int) -> Change:
    """Keypoints under each other's names, in all trials."""
    return change_keypoints(lambda p: p[:, list(order)], ALL_TRIALS)


def mirror_keypoints(p: np.ndarray) -> np.ndarray:
    return np.array([1920.0, 0.0, 0.0]) + p * [-1, 1, 1]


PLAUSIBLE_MISTAKES: dict[str, Change] = {
    "mass in pounds": set_yaml_key("robot.mass_kg", 1.5),
    "inertia in kg cm2": set_yaml_key("robot.yaw_inertia_kg_m2", 95.0),
    "inertia about the nose": set_yaml_key("robot.yaw_inertia_kg_m2", 0.0269),
    "hinge to mass centre measured from the nose": set_yaml_key("robot.hinge_to_com_m", 0.16),
    "tail length measured from the hinge": set_yaml_key("robot.tail_length_m", 0.277),
    "head span of the core, half": set_yaml_key("robot.head_span_m", 0.0345),
    "long head stated as the short one": set_column("head_length_m", lambda _: "0.12"),
    "keypoint depth in cm": set_yaml_key("robot.keypoint_depth_m", 0.4),
    "outer size of the pool": combine_changes(
        set_yaml_key("pool.length_m", 2.7), set_yaml_key("pool.width_m", 1.7)
    ),
    "corners from a short side": set_yaml_key(
        CORNERS_KEY, [*RIGHT_CORNERS_PX[1:], RIGHT_CORNERS_PX[0]]
    ),
    "matrix of another lens mode": set_yaml_key(
        "camera.matrix", [[1150.0, 0.0, 958.3], [0.0, 1152.0, 543.9], [0.0, 0.0, 1.0]]
    ),
    "sign of k1": set_yaml_key("camera.distortion", [0.031, -0.012, 0.0004, -0.0003, 0.002]),
    "one trial at half the picture size": change_keypoints(lambda p: p * [0.5, 0.5, 1], ("T10",)),
    "one trial mirrored": change_keypoints(mirror_keypoints, ("T10",)),
    "one turn mirrored, angle negated": combine_changes(
        change_keypoints(mirror_keypoints, ("T10",)), set_cell("head_angle_deg", "-30")
    ),
    "one straight run mirrored": change_keypoints(mirror_keypoints, ("T09",)),
    "every second frame of one trial": change_keypoints(lambda p: p[::2], ("T10",)),
    "one trial's frames in reverse": change_keypoints(lambda p: p[::-1], ("T09",)),
    "motor log in radians": change_motor_log(
        lambda r: np.column_stack([r[:, 0], np.radians(r[:, 1])]), ALL_TRIALS
    ),
    "motor before a gearbox of 2": change_motor_log(lambda r: r * [1, 2], ALL_TRIALS),
    "motor logs of two powers exchanged": swap_files("motor", "T01", "T09"),
    "files of two conditions exchanged": swap_files("keypoints", "T02", "T03"),
    "files of two powers exchanged": combine_changes(
        swap_files("keypoints", "T02", "T10"), swap_files("motor", "T02", "T10")
    ),
    "one file copied over another": lambda s: shutil.copy(
        s / "keypoints/T10.csv", s / "keypoints/T06.csv"
    ),
    "head and tail exchanged in all": exchange_keypoint_names(3, 1, 2, 0, *range(4, 5)),
    "hinge and core exchanged in all": exchange_keypoint_names(0, 2, 1, 3, *range(4, 5)),
    "sea water": set_yaml_key("water.density_kg_m3", 1025.0),
}


def measure_study(study: Path, results: Path) -> None:
    for trial in load_study(study).trials:
        keypoints(study, results, trial.trial_id)
        tracks(study, results, trial.trial_id)


def reported_about(
    change: Change, base: Path, right: Path, folder: Path, *, search: bool
) -> tuple[str, str]:
    study, results = folder / "study", folder / "results"
    shutil.copytree(base, study)
    change(study)
    found, said = check_outcome(study)
    if found:
        return found, said
    measure_study(study, results)
    try:
        last, sentence = search_outcome(study, results, right) if search else ("open", "")
    except (InputError, ValueError) as error:
        last, sentence = "refused", str(error)
    lines = [line.replace(str(study), "") for line in outcome(study, results)]
    done = results / "outcome.json"
    warnings = json.loads(done.read_text())["warnings"] if done.exists() else []
    lost = [line for line in lines if not line.startswith("Warning")]
    causes = []
    if (results / "mismatch.json").exists():
        causes = [c["name"] for c in json.loads((results / "mismatch.json").read_text())["causes"]]
    kind = "trial lost" if lost else last
    if last in ("SILENT", "harmless", "open") and not lost and (warnings or lines):
        kind = "warned"
    return kind, " / ".join([f"{len(lost)} lost", *lost[:1], *warnings[:3], ",".join(causes),
                             sentence])  # fmt: skip


def main() -> None:
    search = "--no-search" not in sys.argv
    names = [name for name in sys.argv[1:] if name != "--no-search"]
    with tempfile.TemporaryDirectory() as root:
        base, right = Path(root) / "base", Path(root) / "right"
        keypoint_study(published_model_design(), base, Path(root) / "truth")
        measure_study(base, right)
        if search:
            for stage in (geometry, steady, tuning, mismatch):
                stage(base, right)
            print(
                f"| right | {len(steady_speeds(right))} trials | "
                f"{json.loads((right / 'mismatch.json').read_text())['sentence']} |",
                flush=True,
            )
        for name, change in PLAUSIBLE_MISTAKES.items():
            if names and name not in names:
                continue
            with tempfile.TemporaryDirectory() as folder:
                try:
                    found, said = reported_about(change, base, right, Path(folder), search=search)
                except Exception as error:  # the next mistake is tried as well
                    traceback.print_exc()
                    found, said = "CRASH", repr(error)
            text = " ".join(said.replace("|", "/").split())
            print(f"| {name} | {found} | {text} |", flush=True)


if __name__ == "__main__":
    main()
