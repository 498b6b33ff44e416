"""Files of a study: study.yaml, trials.csv, keypoints and motor logs; the truth apart."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .design import Study
from .dynamics import COEFFICIENTS, Motion
from .form import UNLISTED, Array, Cause
from .labels import detect, shaft_log, true_pixels
from .observe import LABELS

SCORER = "DLC_resnet50_glasstankSep12shuffle1_300000"
OTHER_NAMES = {
    "head_tip": "nose",
    "hinge": "neck",
    "core_center": "com",
    "tail_base": "peduncle",
    "tail_tip": "fin_tip",
}
COLUMNS = "trial_id,source,power_pct,head_angle_deg,head_length_m,fps"


def _plain(value: Any) -> Any:
    """The same with Python's own numbers, lists and dicts only."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value


def study_yaml(study: Study) -> dict[str, Any]:
    """Content of study.yaml: what the experimenters state."""
    robot, camera = study.robot, study.camera
    content: dict[str, Any] = {
        "pool": {
            "length_m": round(float(study.size_stated[0]), 4),
            "width_m": round(float(study.size_stated[1]), 4),
            "depth_m": robot.pool_depth,
        },
        "water": {
            "density_kg_m3": robot.density,
            "refractive_index": round(float(study.index_stated), 4),
        },
        "robot": {
            "mass_kg": robot.mass,
            "yaw_inertia_kg_m2": robot.inertia,
            "body_length_m": robot.body_length,
            "head_length_m": robot.head_length,
            "head_span_m": robot.span,
            "hinge_to_com_m": robot.hinge_to_com,
            "tail_length_m": robot.tail_length,
            "keypoint_depth_m": robot.keypoint_depth,
        },
        "camera": {
            "model": camera.model,
            "image_size_px": list(camera.size),
            "matrix": [[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]],
            "distortion": [float(v) for v in camera.distortion],
            "pool_corners_px": [[round(float(v), 2) for v in row] for row in study.marks],
            "pool_corners_height_m": study.mark_height,
        },
    }
    if study.renamed:
        content["bodyparts"] = dict(OTHER_NAMES)
    return content


def _cells(values: Array, digits: int) -> list[str]:
    """Numbers as text; empty where NaN."""
    return ["" if math.isnan(v) else f"{v:.{digits}f}" for v in values.tolist()]


def write_keypoints(path: Path, names: list[str], found: tuple[Array, Array, Array]) -> None:
    """DeepLabCut's layout. found: x, y and likelihood, each (5, frames)."""
    head = [
        "scorer," + ",".join([SCORER] * 15),
        "bodyparts," + ",".join(name for name in names for _ in range(3)),
        "coords," + ",".join(["x", "y", "likelihood"] * 5),
    ]
    columns = [[str(k) for k in range(found[0].shape[1])]]
    for x, y, likelihood in zip(*found, strict=True):
        columns += [_cells(x, 3), _cells(y, 3), _cells(likelihood, 5)]
    rows = (",".join(row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([*head, *rows]) + "\n")


def _write_log(path: Path, times: Array, angles: Array) -> None:
    """Motor log: times (s) and shaft angles (deg)."""
    pairs = zip(times.tolist(), _cells(angles, 2), strict=True)
    path.write_text(
        "\n".join(["time_s,angle_deg", *(f"{t:.3f},{cell}" for t, cell in pairs)]) + "\n"
    )


def write_study(
    rng: np.random.Generator, study: Study, motion: Motion, durations: Array, folder: Path
) -> None:
    """All files of the study in `folder`. durations: s, by the study's clock."""
    (folder / "keypoints").mkdir(parents=True, exist_ok=True)
    text = yaml.safe_dump(_plain(study_yaml(study)), sort_keys=False)
    (folder / "study.yaml").write_text(text)
    if study.logged:
        (folder / "motor").mkdir(exist_ok=True)
    plan, trials = study.plan, study.trials
    names = [OTHER_NAMES[name] if study.renamed else name for name in LABELS]
    fps = f"{study.fps:.5f}".rstrip("0").rstrip(".")
    rows = [f"{COLUMNS},{'motor_log' if study.logged else 'flap_hz'}"]
    for i in range(study.robot.trials):
        name = f"T{i + 1:02d}"
        found = detect(rng, study, true_pixels(study, motion, i, durations[i]))
        write_keypoints(folder / "keypoints" / f"{name}.csv", names, found)
        cell = f"{trials.flap[i]:.3f}"
        if study.logged:
            cell = f"motor/{name}.csv"
            _write_log(folder / cell, *shaft_log(rng, study, i, durations[i] + 0.1))
        planned = f"{plan.power[i]:g},{plan.angle[i]:g},{trials.head[i]:g}"
        rows.append(f"{name},keypoints/{name}.csv,{planned},{fps},{cell}")
    (folder / "trials.csv").write_text("\n".join(rows) + "\n")


def _entry(cause: Cause, sigma: float) -> dict[str, Any]:
    """The cause as the truth lists it."""
    family, unlisted = cause.family, cause.family.kind == UNLISTED
    entry: dict[str, Any] = {} if unlisted else {"name": family.name, "kind": family.kind}
    entry["form"] = cause.form
    if not unlisted:
        entry["channels"] = list(family.channels)
    entry |= {
        "variable": family.variable,
        "strength": float(f"{cause.strength:.4g}"),
        "unit": family.unit_of(cause.form),
        "parameters": cause.shape,
        "sigma": round(float(sigma), 1),
    }
    if unlisted:
        entry["channel"] = family.channels[0]
    return entry


def truth_of(study: Study, sigma: Array, stability_per_s: float) -> dict[str, Any]:
    """What is hidden in the study; named causes, the fin among them, by falling sigma."""
    causes, unlisted = [], None
    for cause, value in zip(study.causes, sigma, strict=True):
        if cause.family.kind == UNLISTED:
            unlisted = _entry(cause, value)
        else:
            causes.append(_entry(cause, value))
    causes.sort(key=lambda entry: -entry["sigma"])
    truth = {
        "trials": study.robot.trials,
        "causes": causes,
        "unlisted": unlisted,
        "coefficients": dict(zip(COEFFICIENTS, study.coefficients, strict=True)),
        "stability_per_s": round(stability_per_s, 3),
        "noise": study.noise,
        "logged": study.logged,
    }
    return _plain(truth)


def write_truth(path: Path, truth: Mapping[str, Any]) -> None:
    """The truth as json."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
