"""Files of a study: study.yaml, trials.csv, keypoints and motor logs; the truth apart."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .footage import PARTS
from .form import Array
from .robots import DENSITY, Robot
from .view_faults import View

LOG_STEP_S = 0.005


def _floats(values: Sequence[float], digits: int) -> list[float]:
    return [round(float(v), digits) for v in values]


def write_study(folder: Path, view: View, robot: Robot) -> None:
    """study.yaml with the stated values (view with its faults)."""
    lens = view.lens
    (fx, fy), (cx, cy) = _floats(lens.focal, 3), _floats(lens.middle, 3)
    length, width = _floats(view.stated_pool, 5)
    content = {
        "pool": {"length_m": length, "width_m": width, "depth_m": 1.2},
        "water": {"density_kg_m3": DENSITY, "refractive_index": round(view.stated_index, 5)},
        "robot": {
            "mass_kg": robot.mass,
            "yaw_inertia_kg_m2": robot.inertia,
            "body_length_m": robot.body_length,
            "head_length_m": robot.head_length,
            "head_span_m": robot.span,
            "hinge_to_com_m": robot.hinge_to_com,
            "tail_length_m": robot.tail_length,
            "keypoint_depth_m": round(view.stated_depth, 5),
        },
        "camera": {
            "model": "pinhole",
            "image_size_px": list(lens.size),
            "matrix": [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]],
            "distortion": _floats(lens.distortion, 6),
            "pool_corners_px": [_floats((z.real, z.imag), 2) for z in view.marks],
            "pool_corners_height_m": view.marks_height,
        },
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "study.yaml").write_text(yaml.safe_dump(content, sort_keys=False))


def write_trials(folder: Path, rows: Sequence[Mapping[str, str]]) -> None:
    """trials.csv; rows have the same keys."""
    lines = [",".join(rows[0]), *(",".join(row.values()) for row in rows)]
    (folder / "trials.csv").write_text("\n".join(lines) + "\n")


def write_keypoints(path: Path, found: Mapping[str, tuple[Array, Array]]) -> None:
    """DeepLabCut's layout. found: part -> pixels (complex, NaN if missing), likelihoods."""
    path.parent.mkdir(parents=True, exist_ok=True)
    names = [name for name in PARTS for _ in range(3)]
    head = [
        "scorer" + ",flume" * len(names),
        "bodyparts," + ",".join(names),
        "coords" + ",x,y,likelihood" * len(PARTS),
    ]
    columns = [c for name in PARTS for z, p in [found[name]] for c in (z.real, z.imag, p)]
    for k, row in enumerate(np.column_stack(columns)):
        cells = ("" if np.isnan(v) else f"{v:.5g}" if j % 3 == 2 else f"{v:.3f}"
                 for j, v in enumerate(row))  # fmt: skip
        head.append(f"{k}," + ",".join(cells))
    path.write_text("\n".join(head) + "\n")


def motor_log(
    rng: np.random.Generator, grid: Array, turns: Array, end: float
) -> tuple[Array, Array]:
    """Time (s) and shaft angle (deg) with noise, 12-bit steps and a dead zone.

    The last value is repeated in the dead zone. turns: revolutions since the start at the grid.
    """
    t = np.arange(0, end, LOG_STEP_S)
    shaft = np.interp(t, grid, turns) + rng.random()
    shaft = shaft + rng.uniform(0.001, 0.006) * np.sin(2 * np.pi * shaft + rng.uniform(0, 6))
    angle = 360 * (shaft % 1)
    dead = angle > 360 - rng.uniform(6, 20)
    read = np.clip(np.round((angle + rng.normal(0, 0.4, t.size)) * 4096 / 360), 0, 4095)
    last = np.maximum.accumulate(np.where(dead, 0, np.arange(t.size)))
    return t, (read * 360 / 4096)[last]


def write_log(path: Path, t: Array, angle: Array) -> None:
    """A motor log."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = (f"{a:.3f},{b:.2f}" for a, b in zip(t, angle, strict=True))
    path.write_text("\n".join(["time_s,angle_deg", *rows]) + "\n")


def write_truth(folder: Path, truth: Mapping[str, Any]) -> None:
    """FOLDER/truth/STUDY.json."""
    path = folder / "truth" / f"{truth['study']}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(truth, indent=1) + "\n")
