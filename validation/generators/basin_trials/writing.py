"""Files of a study: study.yaml, trials.csv, keypoints and motor logs."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .camera import Camera
from .faults import StatedSetup
from .form import Array
from .keypoints import LABELS
from .robots import Robot

OTHER_NAMES = {
    "head_tip": "nose",
    "hinge": "neck",
    "core_center": "body_mid",
    "tail_base": "peduncle",
    "tail_tip": "fluke",
}
LOG_NOISE_DEG = 0.6


@dataclass(frozen=True)
class DeadZone:
    """Shaft angles above `first_deg`, where the sensor is blind; shown: hold, zero or empty."""

    first_deg: float
    shown: str


def number(value: float, digits: int = 6) -> str:
    """Text of a number, without trailing zeros."""
    return f"{float(value):.{digits}f}".rstrip("0").rstrip(".") or "0"


def _numbers(values: Iterable[float], digits: int) -> str:
    """Text of a YAML list of numbers."""
    return "[" + ", ".join(number(v, digits) for v in values) + "]"


def write_study(path: Path, robot: Robot, camera: Camera, stated: StatedSetup) -> None:
    """study.yaml with what the study states, which may be wrong."""
    (fx, fy), (cx, cy) = ([number(v, 3) for v in pair] for pair in (camera.focal, camera.center))
    length, width = (number(v, 4) for v in stated.pool)
    corners = ", ".join(_numbers(corner, 2) for corner in stated.corners)
    lines = [
        "# Basin trials: keypoint study",
        f"pool: {{length_m: {length}, width_m: {width}, depth_m: 0.3}}",
        f"water: {{density_kg_m3: 1000.0, refractive_index: {number(stated.index, 3)}}}",
        "robot:",
        f"  mass_kg: {number(robot.mass, 4)}",
        f"  yaw_inertia_kg_m2: {number(robot.inertia)}",
        f"  body_length_m: {number(robot.body_length)}",
        f"  head_length_m: {number(robot.head_length)}",
        f"  head_span_m: {number(robot.head_span)}",
        f"  hinge_to_com_m: {number(robot.hinge_to_com)}",
        f"  tail_length_m: {number(robot.tail_length)}",
        f"  keypoint_depth_m: {number(stated.keypoint_depth, 4)}",
        "camera:",
        f"  model: {camera.model}",
        f"  image_size_px: [{camera.size[0]}, {camera.size[1]}]",
        f"  matrix: [[{fx}, 0, {cx}], [0, {fy}, {cy}], [0, 0, 1]]",
        f"  distortion: {_numbers(stated.distortion, 7)}",
        f"  pool_corners_px: [{corners}]",
        f"  pool_corners_height_m: {number(stated.corner_height, 4)}",
    ]
    if stated.renamed:
        lines.append("bodyparts: {" + ", ".join(f"{k}: {v}" for k, v in OTHER_NAMES.items()) + "}")
    path.write_text("\n".join(lines) + "\n")


def write_keypoints(path: Path, seen: Array, sure: Array, *, renamed: bool) -> None:
    """A DeepLabCut table; points that were not seen are empty cells."""
    names = [OTHER_NAMES[label] if renamed else label for label in LABELS]
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["scorer"] + ["DLC_resnet50_basin"] * 15)
        table.writerow(["bodyparts"] + [n for n in names for _ in range(3)])
        table.writerow(["coords"] + ["x", "y", "likelihood"] * 5)
        for k, (points, weights) in enumerate(zip(seen, sure, strict=True)):
            row = [str(k)]
            for (u, v), w in zip(points, weights, strict=True):
                row += ["", "", ""] if np.isnan(u) else [f"{u:.3f}", f"{v:.3f}", f"{w:.4f}"]
            table.writerow(row)


def write_log(
    path: Path, rng: np.random.Generator, times: Array, turns: Array, dead: DeadZone
) -> None:
    """A motor log of the shaft angle, with noise and a dead zone."""
    angle = 360 * turns % 360
    shown = np.round((angle + rng.normal(0, LOG_NOISE_DEG, len(angle))) % 360, 1)
    last = shown[0]
    with path.open("w") as file:
        file.write("time_s,angle_deg\n")
        for t, true, value in zip(times, angle, shown, strict=True):
            text = f"{value:.1f}"
            if true > dead.first_deg:
                text = {"hold": f"{last:.1f}", "zero": "0", "empty": ""}[dead.shown]
            else:
                last = value
            file.write(f"{t:.3f},{text}\n")


def write_trials(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """trials.csv; all rows have the same keys."""
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
