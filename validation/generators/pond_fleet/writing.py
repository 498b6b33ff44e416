"""Files of a study: study.yaml, trials.csv, keypoints, motor logs."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .camera import corner_points
from .faults import Stated
from .filming import Campaign, Take
from .robots import WATER_DENSITY, Array
from .tracker import LABELS

OTHER_NAMES = dict(zip(LABELS, ("snout", "neck", "body_mid", "peduncle", "fluke"), strict=True))
SCORER = "DLC_resnet50_pondfleet"


@dataclass(frozen=True)
class Sensor:
    """Potentiometer: blind between two angles (deg), what it then shows; noise (deg)."""

    blind_from: float
    blind_to: float
    shown: str
    noise: float


@dataclass(frozen=True)
class Habits:
    """How a laboratory writes its studies. corner_noise: (4, 2) px."""

    other_names: bool
    logged: bool
    sensor: Sensor
    corner_noise: Array
    water_depth: float


def draw_habits(rng: np.random.Generator, *, logged: bool, water_depth: float) -> Habits:
    """Names of body parts, logs and marking of corners."""
    start = rng.uniform(0, 360)
    sensor = Sensor(start, start + rng.uniform(6, 28),
                    str(rng.choice(["hold", "zero", "empty"])), rng.uniform(0.2, 1.2))  # fmt: skip
    corner_noise = rng.normal(0, 0.25, (4, 2))
    return Habits(bool(rng.random() < 0.25), logged, sensor, corner_noise, water_depth)


def number(value: float, digits: int = 6) -> str:
    """A number without trailing zeros."""
    return f"{float(value):.{digits}f}".rstrip("0").rstrip(".") or "0"


def _listed(values: Array | tuple[float, ...], digits: int = 6) -> str:
    return ", ".join(number(v, digits) for v in values)


def study_text(campaign: Campaign, stated: Stated, habits: Habits) -> str:
    """study.yaml."""
    scene = campaign.scene
    robot, camera = scene.robot, scene.camera
    marks = camera.project(corner_points(scene.pool, scene.mark_height)) + habits.corner_noise
    corners = ", ".join(f"[{_listed(mark, 2)}]" for mark in marks)
    (fx, fy), (cx, cy) = ([number(v, 2) for v in pair] for pair in (camera.focal, camera.centre))
    values = {
        "mass_kg": robot.mass, "yaw_inertia_kg_m2": robot.inertia,
        "body_length_m": robot.body_length, "head_length_m": robot.head_length,
        "head_span_m": robot.head_span, "hinge_to_com_m": robot.hinge_to_com,
        "tail_length_m": robot.tail_length, "keypoint_depth_m": stated.depth,
    }  # fmt: skip
    length, width = (number(v, 4) for v in stated.pool)
    depth = number(habits.water_depth, 3)
    lines = [
        f"pool: {{length_m: {length}, width_m: {width}, depth_m: {depth}}}",
        f"water: {{density_kg_m3: {WATER_DENSITY}, refractive_index: {number(stated.index, 3)}}}",
        "robot:",
        *(f"  {key}: {number(value, 7)}" for key, value in values.items()),
        "camera:",
        f"  model: {camera.model}",
        f"  image_size_px: [{camera.size[0]}, {camera.size[1]}]",
        f"  matrix: [[{fx}, 0, {cx}], [0, {fy}, {cy}], [0, 0, 1]]",
        f"  distortion: [{_listed(stated.distortion)}]",
        f"  pool_corners_px: [{corners}]",
        f"  pool_corners_height_m: {number(scene.mark_height, 3)}",
    ]
    if habits.other_names:
        lines.append("bodyparts: {" + ", ".join(f"{a}: {b}" for a, b in OTHER_NAMES.items()) + "}")
    return "\n".join(lines) + "\n"


def write_keypoints(path: Path, take: Take, habits: Habits) -> None:
    """A DeepLabCut table; empty cells where a point was not seen."""
    names = [OTHER_NAMES[label] if habits.other_names else label for label in LABELS]
    head = [
        ["scorer", *[SCORER] * 3 * len(names)],
        ["bodyparts", *np.repeat(names, 3).tolist()],
        ["coords", *["x", "y", "likelihood"] * len(names)],
    ]
    values = np.concatenate([take.seen, take.likelihood[..., None]], axis=-1)
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerows(head)
        for frame, row in enumerate(values.reshape(len(values), -1)):
            table.writerow([frame, *("" if np.isnan(v) else f"{v:.3f}" for v in row)])


def write_log(path: Path, rng: np.random.Generator, take: Take, sensor: Sensor) -> None:
    """Shaft angle every 5 ms, wrapping at 360 degrees."""
    true = 360 * take.log_turns % 360
    shown = (true + rng.normal(0, sensor.noise, len(true))) % 360
    blind = (true - sensor.blind_from) % 360 < sensor.blind_to - sensor.blind_from
    lines, last = ["time_s,angle_deg"], float(shown[0])
    for time, value, unseen in zip(take.log_times, shown, blind, strict=True):
        last = last if unseen else float(value)
        text = {"hold": f"{last:.2f}", "zero": "0", "empty": ""}[sensor.shown]
        lines.append(f"{time:.3f},{text if unseen else f'{last:.2f}'}")
    path.write_text("\n".join(lines) + "\n")


def write_trials(path: Path, rows: list[dict[str, str]]) -> None:
    """trials.csv."""
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
