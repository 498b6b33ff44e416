"""The files of a study."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .filming import LOG_STEP, Take
from .robots import WATER_DENSITY, Array
from .sight import Scene
from .tracker import LABELS

OTHER_NAMES = ("rostrum", "joint", "trunk", "caudal_base", "caudal_tip")


@dataclass(frozen=True)
class Habits:
    """Names of labels; blind sector of the potentiometer (deg), what it shows there, its noise."""

    names: tuple[str, ...]
    logged: bool
    blind_from: float
    blind: float
    shown: str
    noise: float
    water_depth: float


def draw_habits(rng: np.random.Generator, *, logged: bool, water_depth: float) -> Habits:
    """How a laboratory writes its files."""
    names = OTHER_NAMES if rng.random() < 0.3 else LABELS
    return Habits(names, logged, float(rng.uniform(0, 360)), float(rng.uniform(5, 25)),
                  str(rng.choice(["last", "zero", "empty"])), float(rng.uniform(0.2, 1.0)),
                  water_depth)  # fmt: skip


def text_of(value: float, digits: int = 6) -> str:
    """A number without trailing zeros."""
    return f"{float(value):.{digits}f}".rstrip("0").rstrip(".") or "0"


def study_text(scene: Scene, habits: Habits, marks: Array) -> str:
    """study.yaml; marks: pixels of the corners as a person marked them."""
    robot, camera = scene.robot, scene.camera
    fx, fy, cx, cy = (text_of(v, 3) for v in (*camera.focal, *camera.centre))
    corners = ", ".join(f"[{u:.2f}, {v:.2f}]" for u, v in marks)
    distortion = ", ".join(text_of(v) for v in scene.stated_distortion)
    length, width = (text_of(v, 4) for v in scene.stated_pool)
    numbers = {
        "mass_kg": robot.mass, "yaw_inertia_kg_m2": robot.inertia,
        "body_length_m": robot.body_length, "head_length_m": robot.head_length,
        "head_span_m": robot.head_span, "hinge_to_com_m": robot.hinge_to_com,
        "tail_length_m": robot.tail_length, "keypoint_depth_m": scene.stated_depth,
    }  # fmt: skip
    lines = [
        f"pool: {{length_m: {length}, width_m: {width}, depth_m: {text_of(habits.water_depth)}}}",
        f"water: {{density_kg_m3: {WATER_DENSITY}, "
        f"refractive_index: {text_of(scene.stated_index, 4)}}}",
        "robot:",
        *(f"  {key}: {text_of(value, 8)}" for key, value in numbers.items()),
        "camera:",
        f"  model: {camera.model}",
        f"  image_size_px: [{camera.size[0]}, {camera.size[1]}]",
        f"  matrix: [[{fx}, 0, {cx}], [0, {fy}, {cy}], [0, 0, 1]]",
        f"  distortion: [{distortion}]",
        f"  pool_corners_px: [{corners}]",
        f"  pool_corners_height_m: {text_of(scene.mark_height, 4)}",
    ]
    if habits.names != LABELS:
        pairs = zip(LABELS, habits.names, strict=True)
        lines.append("bodyparts: {" + ", ".join(f"{a}: {b}" for a, b in pairs) + "}")
    return "\n".join(lines) + "\n"


def write_keypoints(path: Path, take: Take, names: tuple[str, ...]) -> None:
    """A table of DeepLabCut's layout; empty cells where a label was not found."""
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["scorer", *["DLC_resnet101_plate"] * (3 * len(names))])
        table.writerow(["bodyparts", *(n for name in names for n in (name,) * 3)])
        table.writerow(["coords", *["x", "y", "likelihood"] * len(names)])
        joined = np.concatenate([take.pixels, take.likelihood[..., None]], axis=-1)
        for frame, row in enumerate(joined.reshape(len(joined), -1)):
            table.writerow([frame, *("" if np.isnan(v) else f"{v:.3f}" for v in row)])


def write_log(path: Path, rng: np.random.Generator, take: Take, habits: Habits) -> None:
    """Angle of the shaft with the blind sector of its potentiometer."""
    angle = 360 * take.shaft
    shown = (angle + rng.normal(0, habits.noise, len(angle))) % 360
    blind = (angle - habits.blind_from) % 360 < habits.blind
    blind[0] = False
    lines, last = ["time_s,angle_deg"], ""
    for k, (value, dark) in enumerate(zip(shown, blind, strict=True)):
        if not dark:
            last = f"{value:.2f}"
        text = {"last": last, "zero": "0", "empty": ""}[habits.shown] if dark else last
        lines.append(f"{k * LOG_STEP:.3f},{text}")
    path.write_text("\n".join(lines) + "\n")


def write_trials(path: Path, rows: list[dict[str, str]]) -> None:
    """trials.csv."""
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
