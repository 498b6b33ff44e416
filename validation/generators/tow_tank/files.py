"""Files of a study."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .faults import KEYPOINT_NAMES
from .filming import GAP_LIKELIHOOD, FilmSetup
from .optics import StatedSetup
from .robots import Array, ParallelTrials, Robot


@dataclass(frozen=True)
class Potentiometer:
    """Shaft sensor: errors in degrees; in the dead zone it holds, reads 0 or is silent."""

    dead_from: float
    dead_width: float
    error: float
    dead: str


def draw_potentiometer(rng: np.random.Generator) -> Potentiometer:
    """A sensor with a dead zone of 10 to 35 degrees."""
    return Potentiometer(rng.uniform(0, 320), rng.uniform(10, 35), rng.uniform(0.3, 1.2),
                         str(rng.choice(["hold", "zero", "empty"])))  # fmt: skip


def write_motor_log(
    rng: np.random.Generator, path: Path, sensor: Potentiometer, t: Array, turns: Array
) -> None:
    """Shaft angle every 5 ms."""
    true = 360 * turns
    angle = np.round((true + sensor.error * rng.normal(size=len(t))) % 360 / 0.0879) * 0.0879
    angle = np.minimum(angle, 359.99)
    dead = (true - sensor.dead_from) % 360 < sensor.dead_width
    last = np.maximum.accumulate(np.where(dead, 0, np.arange(len(t))))
    value = angle[last] if sensor.dead == "hold" else np.where(dead, 0.0, angle)
    silent = dead & (sensor.dead == "empty")
    rows = [f"{a:.3f}," if s else f"{a:.3f},{b:.2f}" for a, b, s in
            zip(t.tolist(), value.tolist(), silent.tolist(), strict=True)]  # fmt: skip
    path.write_text("time_s,angle_deg\n" + "\n".join(rows) + "\n")


def write_keypoints(path: Path, scorer: str, found: Array) -> None:
    """Keypoints in DeepLabCut's layout, (frames, labels, 3)."""
    columns = [(label, kind) for label in KEYPOINT_NAMES for kind in ("x", "y", "likelihood")]
    head = [["scorer"] + [scorer] * len(columns), ["bodyparts"] + [c[0] for c in columns],
            ["coords"] + [c[1] for c in columns]]  # fmt: skip
    lines = [",".join(row) for row in head]
    for i, frame in enumerate(found.tolist()):
        cells = [",," if p == GAP_LIKELIHOOD else f"{x:.3f},{y:.3f},{p:.4f}" for x, y, p in frame]
        lines.append(f"{i}," + ",".join(cells))
    path.write_text("\n".join(lines) + "\n")


def write_study(
    path: Path, robot: Robot, film: FilmSetup, said: StatedSetup, corners: Array
) -> None:
    """study.yaml."""
    body = {"mass_kg": robot.mass, "yaw_inertia_kg_m2": robot.inertia,
            "body_length_m": robot.body_length, "head_length_m": robot.head_length,
            "head_span_m": robot.span, "hinge_to_com_m": robot.hinge_to_com,
            "tail_length_m": robot.tail_length, "keypoint_depth_m": said.depth}  # fmt: skip
    camera = {"model": "fisheye" if said.fisheye else "pinhole",
              "image_size_px": [int(n) for n in film.camera.size],
              "matrix": said.matrix, "distortion": said.distortion,
              "pool_corners_px": corners, "pool_corners_height_m": said.corner_height}  # fmt: skip
    pool = dict(zip(("length_m", "width_m", "depth_m"), said.pool, strict=True))
    water = {"density_kg_m3": robot.density, "refractive_index": said.index}
    content = {"pool": pool, "water": water, "robot": body, "camera": camera}
    path.write_text(yaml.safe_dump(_builtin_types(content), sort_keys=False))


def write_trials(path: Path, lanes: ParallelTrials, stated_fps: float) -> None:
    """trials.csv."""
    rows = ["trial_id,source,power_pct,head_angle_deg,head_length_m,fps,motor_log"]
    for k, (power, angle, head) in enumerate(
        zip(lanes.power, np.rad2deg(lanes.head_angle), lanes.head, strict=True)
    ):
        name = f"T{k + 1:02d}"
        rows.append(f"{name},keypoints/{name}.csv,{power:.0f},{angle:.0f},{head:.6f},"
                    f"{stated_fps:.6g},motor/{name}.csv")  # fmt: skip
    path.write_text("\n".join(rows) + "\n")


def _builtin_types(value: Any) -> Any:
    """Lists and rounded floats instead of arrays."""
    if isinstance(value, dict):
        return {k: _builtin_types(v) for k, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_builtin_types(v) for v in value]
    return round(float(value), 7) if isinstance(value, float | np.floating) else value
