"""Files of a study: study.yaml, trials.csv, keypoints, motor logs; and its truth, apart."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .camera import Camera
from .faults import ViewingConditions
from .filming import BODY_PARTS, Scene
from .form import Array
from .robots import DENSITY, Robot

LOG_STEP = 0.005
"""Interval of a motor log, s."""


def write_study(folder: Path, scene: Scene, view: ViewingConditions, robot: Robot) -> None:
    """study.yaml with the stated values of the camera, the pool and the robot."""
    camera: Camera = scene.camera
    length, width = view.pool
    fx, fy = (f * view.focal for f in camera.focal)
    content = {
        "pool": {"length_m": round(length, 5), "width_m": round(width, 5), "depth_m": 0.9},
        "water": {"density_kg_m3": DENSITY, "refractive_index": round(view.index, 5)},
        "robot": {
            "mass_kg": robot.mass,
            "yaw_inertia_kg_m2": robot.inertia,
            "body_length_m": robot.body_length,
            "head_length_m": robot.head_length,
            "head_span_m": robot.span,
            "hinge_to_com_m": robot.hinge_to_com,
            "tail_length_m": robot.tail_length,
            "keypoint_depth_m": round(view.depth, 5),
        },
        "camera": {
            "model": camera.model,
            "image_size_px": list(camera.size),
            "matrix": [[fx, 0.0, camera.centre[0]], [0.0, fy, camera.centre[1]], [0.0, 0.0, 1.0]],
            "distortion": [float(k) for k in view.distortion],
            "pool_corners_px": scene.corner_pixels.tolist(),
            "pool_corners_height_m": scene.corner_height,
        },
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "study.yaml").write_text(yaml.safe_dump(content, sort_keys=False))


def write_trials(folder: Path, rows: list[dict[str, Any]]) -> None:
    """trials.csv."""
    lines = [",".join(rows[0])] + [",".join(str(v) for v in row.values()) for row in rows]
    (folder / "trials.csv").write_text("\n".join(lines) + "\n")


def write_keypoints(path: Path, found: Mapping[str, tuple[Array, Array]]) -> None:
    """Detections in DeepLabCut's layout, raw pixels; what was not seen is empty."""
    path.parent.mkdir(exist_ok=True)
    columns, head = [], ["scorer", "bodyparts", "coords"]
    for name in BODY_PARTS:
        pixels, likelihood = found[name]
        columns += [pixels[:, 0], pixels[:, 1], likelihood]
        for j, text in enumerate(("basin", name)):
            head[j] += f",{text}" * 3
        head[2] += ",x,y,likelihood"
    rows = [
        f"{j}," + ",".join("" if np.isnan(v) else f"{v:.4f}" for v in values)
        for j, values in enumerate(np.column_stack(columns))
    ]
    path.write_text("\n".join([*head, *rows]) + "\n")


def motor_log(
    rng: np.random.Generator, times: Array, cycles: Array, end: float
) -> tuple[Array, Array]:
    """Time (s) and shaft angle (deg) of a potentiometer with noise, ripple and a dead zone.

    cycles: beats since the start at `times`. The load of the beat makes the shaft speed ripple
    twice a turn. In the dead zone the angle holds, reads 0, or is NaN.
    """
    t = np.arange(0, end, LOG_STEP)
    turns = np.interp(t, times, cycles) + rng.uniform(0, 1)
    turns = turns + 0.004 * np.sin(4 * np.pi * turns)
    angle = 360 * (turns % 1)
    dead = rng.uniform(8, 25)
    noisy = np.mod(angle + rng.normal(0, rng.uniform(0.3, 1.0), t.size), 360)
    noisy = np.round(noisy / 0.3516) * 0.3516  # a converter of ten bits
    kind, gone = rng.integers(3), angle > 360 - dead
    if kind == 0:
        last = np.maximum.accumulate(np.where(gone, 0, np.arange(t.size)))
        noisy = noisy[last]
    else:
        noisy[gone] = 0.0 if kind == 1 else np.nan
    return t, noisy


def write_log(path: Path, t: Array, angle: Array) -> None:
    """A motor log."""
    path.parent.mkdir(exist_ok=True)
    rows = [
        f"{a:.3f}," + ("" if np.isnan(b) else f"{b:.3f}") for a, b in zip(t, angle, strict=True)
    ]
    path.write_text("\n".join(["time_s,angle_deg", *rows]) + "\n")


def write_truth(folder: Path, truth: Mapping[str, Any]) -> None:
    """FOLDER/truth/STUDY.json, apart from the study."""
    path = folder / "truth" / f"{truth['study']}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
