"""Files of a study: study.yaml, trials.csv, keypoints and motor logs."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .camera import corner_points
from .faults import Fault
from .filming import Campaign, Take
from .labels import LABELS
from .robots import Array

NICKNAMES = dict(zip(LABELS, ("bow", "neck", "mid", "root", "tip"), strict=True))
SCORER = "DLC_mobnet_racetrack"


@dataclass(frozen=True)
class Stated:
    """What study.yaml states, right or wrong."""

    pool: tuple[float, float]
    distortion: tuple[float, ...]
    index: float
    keypoint_depth: float
    corners: Array
    corner_height: float
    renamed: bool


@dataclass(frozen=True)
class ShaftSensor:
    """Potentiometer: blind above `blind_deg`, where it shows `shown`; noise in degrees."""

    blind_deg: float
    shown: str
    noise_deg: float


def stated(
    campaign: Campaign, corner_height: float, corner_noise: Array, *, renamed: bool
) -> Stated:
    """What the study states, with the fault."""
    camera, robot = campaign.camera, campaign.robot
    corners = camera.project(corner_points(campaign.pool, corner_height)) + corner_noise
    (length, width), distortion = campaign.pool, camera.distortion
    index, depth = camera.index, robot.keypoint_depth
    fault = campaign.fault
    name, form = (fault.name, fault.form) if fault else ("", "")
    size = fault.size if fault else 0.0
    if name == "scale_error":
        length *= 1 if form == "width_only" else 1 + size
        width *= 1 if form == "length_only" else 1 + size
    if name == "uncorrected_refraction" and form == "index":
        index = 1.0
    if name == "uncorrected_refraction" and form == "depth":
        depth = max(0.0, depth - abs(size))
    if name == "lens_error":
        distortion = _wrong_lens(distortion, form, size)
    return Stated((length, width), distortion, index, depth, corners, corner_height, renamed)


def _wrong_lens(k: tuple[float, ...], form: str, size: float) -> tuple[float, ...]:
    """Distortion that is off in its first term, in a decentring or fisheye term, or not stated."""
    if form == "none_stated":
        return (k[0] + size, *([0.0] * (len(k) - 1)))
    if form == "tangential" and len(k) == 5:
        return (k[0] + 0.5 * size, k[1], k[2] + 0.1 * size, *k[3:])
    return (k[0] + size, *k[1:])


def true_depth(fault: Fault | None, depth: float) -> float:
    """Depth of the labels (m): refraction left out only matters for labels well below."""
    if fault is None or fault.name != "uncorrected_refraction":
        return depth
    return round(depth + abs(fault.size) if fault.form == "depth" else abs(fault.size), 3)


def number(value: float, digits: int = 6) -> str:
    """A number without trailing zeros."""
    return f"{float(value):.{digits}f}".rstrip("0").rstrip(".") or "0"


def study_text(campaign: Campaign, said: Stated) -> str:
    """study.yaml."""
    robot, camera = campaign.robot, campaign.camera
    length, width = (number(v, 4) for v in said.pool)
    (fx, fy), (cx, cy) = ([number(v, 2) for v in pair] for pair in (camera.focal, camera.centre))
    corners = ", ".join(f"[{number(u, 2)}, {number(v, 2)}]" for u, v in said.corners)
    lengths = {
        "mass_kg": robot.mass, "yaw_inertia_kg_m2": robot.inertia,
        "body_length_m": robot.body_length, "head_length_m": robot.head_length,
        "head_span_m": robot.head_span, "hinge_to_com_m": robot.hinge_to_com,
        "tail_length_m": robot.tail_length, "keypoint_depth_m": said.keypoint_depth,
    }  # fmt: skip
    lines = [
        f"pool: {{length_m: {length}, width_m: {width}, depth_m: {number(campaign.depth, 3)}}}",
        f"water: {{density_kg_m3: 1000.0, refractive_index: {number(said.index, 3)}}}",
        "robot:",
        *(f"  {key}: {number(value)}" for key, value in lengths.items()),
        "camera:",
        f"  model: {camera.model}",
        f"  image_size_px: [{camera.size[0]}, {camera.size[1]}]",
        f"  matrix: [[{fx}, 0, {cx}], [0, {fy}, {cy}], [0, 0, 1]]",
        f"  distortion: [{', '.join(number(k, 6) for k in said.distortion)}]",
        f"  pool_corners_px: [{corners}]",
        f"  pool_corners_height_m: {number(said.corner_height, 3)}",
    ]
    if said.renamed:
        lines.append("bodyparts: {" + ", ".join(f"{a}: {b}" for a, b in NICKNAMES.items()) + "}")
    return "\n".join(lines) + "\n"


def write_keypoints(path: Path, take: Take, *, renamed: bool) -> None:
    """A DeepLabCut table; empty cells where a point was not seen."""
    names = [NICKNAMES[label] if renamed else label for label in LABELS]
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["scorer", *[SCORER] * 15])
        table.writerow(["bodyparts", *(name for name in names for _ in range(3))])
        table.writerow(["coords", *["x", "y", "likelihood"] * 5])
        for frame, (points, weights) in enumerate(zip(take.seen, take.sure, strict=True)):
            cells = [_cells(p, w) for p, w in zip(points, weights, strict=True)]
            table.writerow([frame, *(cell for three in cells for cell in three)])


def _cells(point: Array, weight: float) -> tuple[str, str, str]:
    if np.isnan(point[0]):
        return "", "", ""
    return f"{point[0]:.3f}", f"{point[1]:.3f}", f"{weight:.4f}"


def write_log(path: Path, rng: np.random.Generator, take: Take, sensor: ShaftSensor) -> None:
    """Shaft angle every 5 ms."""
    times, turns = take.log
    true = 360 * turns % 360
    shown = np.round((true + rng.normal(0, sensor.noise_deg, len(true))) % 360, 1)
    lines, last = ["time_s,angle_deg"], shown[0]
    for t, angle, value in zip(times, true, shown, strict=True):
        if angle > sensor.blind_deg:
            text = {"hold": f"{last:.1f}", "zero": "0.0", "empty": ""}[sensor.shown]
        else:
            text, last = f"{value:.1f}", value
        lines.append(f"{t:.3f},{text}")
    path.write_text("\n".join(lines) + "\n")


def write_trials(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """trials.csv."""
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
