"""Files of a study in the layout of the contract."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .camera import Camera
from .robots import ParallelTrials, Robot
from .scene import KEYPOINT_NAMES, StatedSetup

Array = NDArray[np.float64]
SCORER = "coupled_bodies_net"


@dataclass(frozen=True)
class Potentiometer:
    """Dead zone, deg, up to 360, how it reads there, mounting, deg, and noise, deg."""

    dead: float
    reads: str
    mount: float
    noise: float


def draw_potentiometer(rng: np.random.Generator) -> Potentiometer:
    """A sensor of one turn."""
    return Potentiometer(rng.uniform(6, 20), str(rng.choice(["hold", "zero", "empty"])),
                         rng.uniform(0, 360), rng.uniform(0.2, 0.8))  # fmt: skip


def _formatted_row(values: Array, digits: int) -> str:
    return "[" + ", ".join(f"{v:.{digits}f}" for v in np.ravel(values)) + "]"


def write_study_yaml(path: Path, robot: Robot, camera: Camera, said: StatedSetup, marks: Array,
                *, height: float) -> None:  # fmt: skip
    """study.yaml; marks: the clicked corners, px."""
    rows = ", ".join(_formatted_row(row, 4) for row in said.matrix)
    spots = ", ".join(_formatted_row(mark, 2) for mark in marks)
    L, W, depth = said.pool
    path.write_text(f"""\
pool:
  length_m: {L:.4f}
  width_m: {W:.4f}
  depth_m: {depth:.3f}
water:
  density_kg_m3: 1000.0
  refractive_index: {said.index:.4f}
robot:
  mass_kg: {robot.mass}
  yaw_inertia_kg_m2: {robot.inertia}
  body_length_m: {robot.body_length}
  head_length_m: {robot.head_length}
  head_span_m: {robot.span}
  hinge_to_com_m: {robot.hinge_to_com}
  tail_length_m: {robot.tail_length}
  keypoint_depth_m: {said.depth:.4f}
camera:
  model: {"fisheye" if camera.fisheye else "pinhole"}
  image_size_px: [{camera.size[0]}, {camera.size[1]}]
  matrix: [{rows}]
  distortion: {_formatted_row(said.distortion, 7)}
  pool_corners_px: [{spots}]
  pool_corners_height_m: {height}
""")


def write_trials(path: Path, lanes: ParallelTrials, fps: float, flap_hz: Array | None) -> None:
    """trials.csv, with a motor log for each trial or the flapping frequencies."""
    last = "motor_log" if flap_hz is None else "flap_hz"
    lines = [f"trial_id,source,power_pct,head_angle_deg,head_length_m,fps,{last}"]
    for k in range(lanes.count):
        name = f"T{k + 1:02d}"
        drive = f"motor/{name}.csv" if flap_hz is None else f"{flap_hz[k]:.4f}"
        lines.append(
            f"{name},keypoints/{name}.csv,{lanes.power[k]:g},"
            f"{np.rad2deg(lanes.command[k]):.1f},{lanes.head[k]:.4f},{fps:g},{drive}"
        )
    path.write_text("\n".join(lines) + "\n")


def write_keypoints(path: Path, found: Array) -> None:
    """u, v, likelihood of (frames, 5, 3) in DeepLabCut's layout."""
    parts = [p for p in KEYPOINT_NAMES for _ in range(3)]
    head = [",".join(["scorer"] + [SCORER] * 15), ",".join(["bodyparts", *parts]),
            ",".join(["coords"] + ["x", "y", "likelihood"] * 5)]  # fmt: skip
    rows = [f"{i}," + ",".join("" if np.isnan(v) else f"{v:.3f}" for v in row)
            for i, row in enumerate(found.reshape(len(found), -1))]  # fmt: skip
    path.write_text("\n".join(head + rows) + "\n")


def logged_angles(rng: np.random.Generator, sensor: Potentiometer, turns: Array) -> Array:
    """Angle, deg, of the motor's shaft as logged; NaN where it is empty."""
    true = (360 * turns + sensor.mount) % 360
    angle = (true + sensor.noise * rng.normal(size=len(turns))) % 360
    dead = true > 360 - sensor.dead
    if sensor.reads == "hold":
        last = np.maximum.accumulate(np.where(dead, 0, np.arange(len(turns))))
        return np.asarray(angle[last])
    return np.where(dead, 0.0 if sensor.reads == "zero" else np.nan, angle)


def write_motor(path: Path, times: Array, angles: Array) -> None:
    """time_s, angle_deg."""
    rows = [f"{t:.3f}," + ("" if np.isnan(a) else f"{a:.2f}")
            for t, a in zip(times, angles, strict=True)]  # fmt: skip
    path.write_text("time_s,angle_deg\n" + "\n".join(rows) + "\n")
