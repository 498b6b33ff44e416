"""Making a study: hidden causes, trials, film, files and truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import writing
from .camera import Camera, corner_points
from .catalogue import PLACE_DEPENDENT
from .design import StudySetup, draw_hidden
from .faults import Fault, StatedSetup, clock_rate, draw_fault, misstated
from .filming import film, shaft_turns
from .form import POOL_LENGTH, POOL_WIDTH, Array, HiddenLaw
from .keypoints import detected
from .plan import draw_plan
from .robots import straight_growth
from .trials import draw_starts
from .truth import truth_of

GENERATOR = "basin_trials"
STREAM = 90210
"""Number that sets the random draws of this generator apart."""
FRAME_RATES = {30000 / 1001: 0.3, 30.0: 0.3, 25.0: 0.15, 50.0: 0.15, 60000 / 1001: 0.1}
"""Frames per second, with the share of the studies."""
LOGGED_FAULTS = ("time_offset", "clock_error")
"""Errors that only a motor log shows."""


@dataclass(frozen=True)
class Recording:
    """How a study is recorded. fps: true frame rate. stated: what study.yaml states."""

    logged: bool
    fps: float
    stated: StatedSetup
    dead: writing.DeadZone


def generate(seed: int, index: int, folder: Path) -> dict[str, Any]:
    """Write study `index` of the series `seed` into FOLDER/studies and its truth into FOLDER/truth.

    The truth is returned.
    """
    rng = np.random.default_rng([seed, index, STREAM])
    plan = draw_plan(seed, index)
    setup, laws = draw_hidden(rng, plan)
    fault = draw_fault(rng, plan.fault, setup.trials) if plan.fault else None
    if fault and fault.name == "uncorrected_refraction":
        deep = replace(setup.robot, keypoint_depth=round(fault.size, 3))
        setup = replace(setup, robot=deep)
    if laws and not any(law.name in PLACE_DEPENDENT for law in laws):
        start = draw_starts(rng, setup.robot, setup.runs, setup.duration, laws=laws)
        setup = replace(setup, start=start)
    name = f"{GENERATOR}-{seed}-{index:03d}"
    recording = _draw_recording(rng, setup, fault)
    study = Path(folder) / "studies" / name
    trials = _write_files(rng, study, setup, laws, fault=fault, recording=recording)
    truth = {"study": name, "generator": GENERATOR, "seed": seed, "index": index}
    truth |= truth_of(plan, setup, laws, fault)
    truth["conditions"] = _conditions(setup, recording, trials)
    path = Path(folder) / "truth" / f"{name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
    return truth


def _draw_recording(rng: np.random.Generator, setup: StudySetup, fault: Fault | None) -> Recording:
    """Frame rate, marks, names and motor log of a study."""
    logged, renamed = rng.random() < 0.65, rng.random() < 0.25
    fps = float(rng.choice(list(FRAME_RATES), p=list(FRAME_RATES.values())))
    height = float(rng.choice([0.0, 0.02, 0.05]))
    camera = setup.camera
    corners = camera.project(corner_points(height)) + rng.normal(0, 0.25, (4, 2))
    true = StatedSetup(
        (POOL_LENGTH, POOL_WIDTH), camera.distortion, camera.index, setup.robot.keypoint_depth,
        corners, height, bool(renamed),
    )  # fmt: skip
    dead = writing.DeadZone(360 - rng.uniform(12, 28), str(rng.choice(["hold", "zero", "empty"])))
    needs_log = fault is not None and fault.name in LOGGED_FAULTS
    return Recording(bool(logged) or needs_log, fps, misstated(fault, true), dead)


def _write_files(
    rng: np.random.Generator, study: Path, setup: StudySetup, laws: Sequence[HiddenLaw],
    *, fault: Fault | None, recording: Recording,
) -> list[dict[str, Any]]:  # fmt: skip
    """Write the folder of the study; the hidden errors of the trials are returned."""
    for part in ("keypoints", "motor"):
        (study / part).mkdir(parents=True, exist_ok=True)
    writing.write_study(study / "study.yaml", setup.robot, setup.camera, recording.stated)
    size, fps, renamed = setup.camera.size, recording.fps, recording.stated.renamed
    rows, trials = [], []
    for k, (pixels, times) in enumerate(film(rng, setup, laws, fault, fps)):
        trial_id = f"B{k + 1:02d}"
        seen, sure = detected(rng, pixels, setup.noise, fps, size)
        writing.write_keypoints(study / f"keypoints/{trial_id}.csv", seen, sure, renamed=renamed)
        row = _trial_row(setup, trial_id, k, fps * clock_rate(fault, k))
        if recording.logged:
            clock, turned = shaft_turns(setup, laws, k, times[-1] + 0.4)
            turns = setup.first_turn[k] + turned
            row["motor_log"] = f"motor/{trial_id}.csv"
            writing.write_log(study / row["motor_log"], rng, clock, turns, recording.dead)
        else:
            row["flap_hz"] = writing.number(setup.runs.flap[k], 4)
        rows.append(row)
        trials.append(_trial_truth(setup, trial_id, k, times))
    writing.write_trials(study / "trials.csv", rows)
    return trials


def _trial_row(setup: StudySetup, trial_id: str, trial: int, fps: float) -> dict[str, str]:
    """Row of trials.csv without the motor."""
    runs = setup.runs
    return {
        "trial_id": trial_id,
        "source": f"keypoints/{trial_id}.csv",
        "power_pct": writing.number(setup.power[trial]),
        "head_angle_deg": writing.number(np.degrees(runs.phi[trial]), 3),
        "head_length_m": writing.number(runs.head[trial]),
        "fps": writing.number(fps, 5),
    }


def _trial_truth(setup: StudySetup, trial_id: str, trial: int, times: Array) -> dict[str, Any]:
    """Hidden errors, duration and start of a trial."""
    return {
        "trial_id": trial_id,
        "servo_error_deg": float(np.degrees(setup.servo_error[trial])),
        "flap_error": float(setup.flap_error[trial]),
        "duration_s": round(float(times[-1]), 3),
        "start": [float(v) for v in setup.start[:3, trial]],
    }


def _conditions(
    setup: StudySetup, recording: Recording, trials: Sequence[dict[str, Any]]
) -> dict[str, Any]:
    """Camera, trials and recording for the truth."""
    return {
        "camera": _camera_truth(setup.camera),
        "trials": trials,
        "straight_growth_per_s": straight_growth(setup.robot, setup.robot.fin),
        "fps": recording.fps,
        "motor_log": recording.logged,
        "renamed": recording.stated.renamed,
        "keypoint_depth_m": setup.robot.keypoint_depth,
    }


def _camera_truth(camera: Camera) -> dict[str, Any]:
    return {
        "model": camera.model,
        "size": list(camera.size),
        "focal": list(camera.focal),
        "center": list(camera.center),
        "distortion": list(camera.distortion),
        "position": camera.position.tolist(),
        "rotation": camera.rotation.tolist(),
        "index": camera.index,
    }
