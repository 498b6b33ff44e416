"""The files of a study folder, as STUDY.md describes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from .craft import Robot
from .fisher import StudyRun
from .impulse import STEP_S, Motion
from .lanes import FLAP_ERROR, ParallelTrials
from .tracker import KEYPOINT_NAMES, Potentiometer, shaft_log

CORNER_STD_PX = 0.1
"""Standard deviation of a clicked corner, px."""


def write_study_yaml(path: Path, craft: Robot, said, corners: np.ndarray) -> None:
    """study.yaml: pool, water, robot and camera as the study states them."""
    camera, (L, W, d) = said.camera, said.pool
    u, v = (float(c) for c in camera.centre)
    f = float(camera.focal)
    robot = {
        "mass_kg": craft.mass, "yaw_inertia_kg_m2": craft.inertia,
        "body_length_m": craft.body_length, "head_length_m": craft.head_length,
        "head_span_m": craft.span, "hinge_to_com_m": craft.hinge_to_com,
        "tail_length_m": craft.tail_length, "keypoint_depth_m": round(float(camera.depth), 5),
    }  # fmt: skip
    lens = {
        "model": "fisheye" if camera.fisheye else "pinhole", "image_size_px": list(camera.size),
        "matrix": [[f, 0.0, u], [0.0, f, v], [0.0, 0.0, 1.0]],
        "distortion": [float(k) for k in camera.distortion],
        "pool_corners_px": [[round(float(x), 2) for x in c] for c in corners],
        "pool_corners_height_m": 0.0,
    }  # fmt: skip
    content = {
        "pool": {"length_m": round(float(L), 5), "width_m": round(float(W), 5),
                 "depth_m": float(d)},
        "water": {"density_kg_m3": 1000.0, "refractive_index": round(float(camera.index), 5)},
        "robot": robot, "camera": lens,
    }  # fmt: skip
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")


def write_trials(
    path: Path, lanes: ParallelTrials, fps: float, hertz: np.ndarray, logged: bool
) -> None:
    """trials.csv with either motor logs or reported frequencies `hertz` (trials,)."""
    last = "motor_log" if logged else "flap_hz"
    lines = [f"trial_id,source,power_pct,head_angle_deg,head_length_m,fps,{last}"]
    for k in range(len(lanes)):
        name = f"P{k + 1:02d}"
        drive = f"motor/{name}.csv" if logged else f"{hertz[k]:.4f}"
        angle = np.rad2deg(lanes.command[k]) + 0.0
        lines.append(f"{name},keypoints/{name}.csv,{lanes.power[k]:g},{angle:.1f},"
                     f"{lanes.head[k]:.3f},{fps:g},{drive}")  # fmt: skip
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_keypoints(path: Path, found: np.ndarray) -> None:
    """DeepLabCut's layout; (frames, 5, 3) x, y (px), likelihood."""
    scorer = "DLC_potential_flow"
    heads = [["scorer"] + [scorer] * 15,
             ["bodyparts", *(p for p in KEYPOINT_NAMES for _ in range(3))],
             ["coords", *("x", "y", "likelihood") * 5]]  # fmt: skip
    lines = [",".join(h) for h in heads]
    digits = (2, 2, 4) * 5
    for i, row in enumerate(found.reshape(len(found), -1)):
        cells = ("" if np.isnan(v) else f"{v:.{d}f}" for v, d in zip(row, digits, strict=True))
        lines.append(f"{i}," + ",".join(cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_motor_log(rng: np.random.Generator, path: Path, sensor: Potentiometer, phase) -> None:
    """Shaft angles every 5 ms; `phase` (rad) at these times."""
    cells = shaft_log(rng, sensor, phase)
    lines = [f"{0.005 * i:.3f},{cell}" for i, cell in enumerate(cells)]
    path.write_text("\n".join(["time_s,angle_deg", *lines]) + "\n", encoding="utf-8")


def shaft_phase(rng: np.random.Generator, motion: Motion, trial: int, seconds: float) -> np.ndarray:
    """Phase (rad) at the log's times, whose clock errs by FLAP_ERROR; `seconds` of the trial."""
    logged = np.arange(0, seconds, 0.005)
    true = logged * (1 + FLAP_ERROR * rng.normal())
    times = STEP_S * np.arange(len(motion.phase))
    return np.interp(true, times, motion.phase[:, trial]) + rng.uniform(0, 0.3)


def reported_flap_hz(rng: np.random.Generator, run: StudyRun, motion: Motion) -> np.ndarray:
    """(trials,) mean frequency of the last third of each trial with the error FLAP_ERROR, Hz."""
    out = np.empty(len(run.lanes))
    for k, frames in enumerate(run.frames):
        last = min(int(frames / run.fps / STEP_S), len(motion.phase) - 1)
        first = 2 * last // 3
        cycles = (motion.phase[last, k] - motion.phase[first, k]) / (2 * np.pi)
        out[k] = cycles / (STEP_S * (last - first)) * (1 + FLAP_ERROR * rng.normal())
    return out
