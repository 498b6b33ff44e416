"""Files of a study: tracked keypoints, motor logs, trials.csv and study.yaml."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from validation.generators.quasi_steady import observation as obs
from validation.generators.quasi_steady.effects import Effect
from validation.generators.quasi_steady.trials import (
    KEYPOINT_NAMES,
    Lab,
    Trial,
    actual_head_angle,
    body_points,
    simulate_trial,
    trial_inputs,
)

ALTERNATIVE_PART_NAMES = {
    "head_tip": "nose",
    "hinge": "neck",
    "core_center": "com",
    "tail_base": "peduncle",
    "tail_tip": "caudal_tip",
}


def shaft_turns(schedule: np.ndarray, dt: float) -> np.ndarray:
    """Turns of the motor on the schedule's grid."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (schedule[1:, 1] + schedule[:-1, 1]) * dt)])


def with_recoil(
    lab: Lab, trial: Trial, states: np.ndarray, beat: np.ndarray, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """States with heading and sideways recoil at the beat's phase (rad), and the tail's swing.

    Recoil builds up over the first beats and shrinks a little with power.
    """
    size = (1 - np.exp(-times / 0.3)) * (75 / trial.power) ** 0.3
    out = states.copy()
    out[:, 2] += lab.noise.recoil_rad * size * np.sin(beat)
    side = lab.noise.recoil_m * size * np.sin(beat - 0.8)
    out[:, 0] -= side * np.sin(states[:, 2])
    out[:, 1] += side * np.cos(states[:, 2])
    return out, 0.35 * size * np.sin(beat + 1.9)


def true_keypoints(
    lab: Lab, trial: Trial, effects: Sequence[Effect]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frame times (n,), keypoints (n, 5, 2) with recoil and static label errors, states."""
    times, states, _ = simulate_trial(lab, trial, effects, lab.fps)
    given = trial_inputs(lab, trial, effects)
    turns = shaft_turns(given[2], 0.005)
    beat = 2 * np.pi * np.interp(times, np.arange(len(turns)) * 0.005, turns)
    moved, swing = with_recoil(lab, trial, states, beat, times)
    phi = actual_head_angle(given, times)
    points = body_points(moved, phi, given[0])
    tail = (points[:, 4] - points[:, 3]) @ [1, 1j] * np.exp(1j * swing)
    points[:, 4] = points[:, 3] + np.column_stack([tail.real, tail.imag])
    turn = np.exp(1j * (moved[:, 2] + phi))[:, None] * (lab.label_m @ [1, 1j])
    return times, points + np.stack([turn.real, turn.imag], axis=2), states


def tracked_keypoints(
    rng: np.random.Generator, lab: Lab, clean: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Tracked pixels (n, 5, 2) and likelihoods (n, 5): drift, white noise, outliers, gaps."""
    n, noise = len(clean), lab.noise
    keep = np.exp(-1 / (lab.fps * noise.drift_s))
    drift = np.empty_like(clean)
    drift[0] = rng.normal(0, 1, (5, 2))
    for i in range(1, n):
        drift[i] = keep * drift[i - 1] + np.sqrt(1 - keep**2) * rng.normal(0, 1, (5, 2))
    seen = clean + noise.drift_px * drift + rng.normal(0, noise.white_px, clean.shape)
    sure = 1 - rng.beta(1.2, 25, (n, 5))
    wild = rng.uniform(0, 1, (n, 5)) < noise.outlier_share
    seen[wild] += rng.normal(0, 40, (wild.sum(), 2))
    sure[wild] = np.where(
        rng.uniform(0, 1, wild.sum()) < 0.8, rng.uniform(0, 0.5, wild.sum()), 0.93
    )
    blank = rng.uniform(0, 1) < 0.5
    for i, j in np.argwhere(rng.uniform(0, 1, (n, 5)) < noise.gap_share / 2):
        rows = slice(i, i + rng.integers(1, 11))
        sure[rows, j] = rng.uniform(0, 0.09, len(sure[rows, j]))
        if blank:
            seen[rows, j] = np.nan
    return seen, sure


def recorded_frames(rng: np.random.Generator, effects: Sequence[Effect], n: int) -> np.ndarray:
    """Indices of recorded frames; a recorder that loses frames drops a share of them."""
    lost = obs.strength_of(effects, "clock_error", 1)
    return np.flatnonzero(rng.uniform(0, 1, n) >= lost / (1 + lost))


def write_keypoints(
    path: Path, seen: np.ndarray, sure: np.ndarray, names: Sequence[str], *, multi: bool
) -> None:
    """A DeepLabCut CSV file; `multi` adds the row of individuals."""
    n = len(seen)
    data = np.concatenate([seen, sure[:, :, None]], axis=2).reshape(n, -1)
    head = [("scorer", ["DLC_tank"] * 15)]
    head += [("individuals", ["koi"] * 15)] if multi else []
    head += [("bodyparts", [p for p in names for _ in range(3)])]
    head += [("coords", ["x", "y", "likelihood"] * 5)]
    lines = [",".join([label, *row]) for label, row in head]
    body = pd.DataFrame(data, index=range(n)).to_csv(header=False, float_format="%.4f")
    path.write_text("\n".join(lines) + "\n" + body)


def write_motor(
    rng: np.random.Generator,
    path: Path,
    trial: Trial,
    schedule: np.ndarray,
    *,
    late: float,
    fill: str,
) -> None:
    """Shaft angle every 5 ms with a dead zone of 18 degrees filled by `hold`, `zero` or `empty`.

    The log starts `late` seconds into the motor's schedule and states the flapping frequency
    without its hidden error.
    """
    stated = schedule.copy()
    stated[:, 1] /= 1 + trial.flap_error
    turns = shaft_turns(stated, 0.005)[round(late / 0.005) :]
    rows = min(len(turns), int((trial.seconds + rng.uniform(0.05, 0.2)) / 0.005))
    angle = (360 * (turns[:rows] - turns[0]) + rng.uniform(0, 360)) % 360
    angle = np.round((angle + rng.normal(0, 0.3, rows)) % 360 / 0.3516) * 0.3516
    dead = angle > 342
    angle = pd.Series(np.where(dead, 0.0 if fill == "zero" else np.nan, angle))
    if fill == "hold":
        angle = angle.ffill().fillna(0.0)
    times = np.arange(rows) * 0.005
    pd.DataFrame({"time_s": times, "angle_deg": angle}).to_csv(
        path, index=False, float_format="%.4f"
    )


def log_delay(trial: Trial, effects: Sequence[Effect]) -> float:
    """Seconds by which the log's zero lies after the first frame (time_offset)."""
    k, scattered = (obs.strength_of(effects, "time_offset", v) for v in (0, 1))
    return k + scattered * trial.late


def study_yaml(lab: Lab, effects: Sequence[Effect], *, renamed: bool, homography: bool) -> str:
    """study.yaml: what the lab states."""
    stated, robot = obs.stated_setup(lab, effects), lab.robot
    c = stated.camera
    camera: dict = {"image_size_px": list(c.size)}
    if not homography:
        fx, fy = (float(f) for f in c.focal)
        cx, cy = (float(x) for x in c.centre)
        camera |= {"model": c.model, "matrix": [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]],
                   "distortion": [float(x) for x in c.distortion]}  # fmt: skip
    camera |= {"pool_corners_px": np.round(stated.corners_px, 3).tolist(),
               "pool_corners_height_m": lab.mark_height}  # fmt: skip
    content = {
        "pool": {"length_m": round(float(stated.length), 5),
                 "width_m": round(float(stated.width), 5),
                 "depth_m": 0.3},
        "water": {"density_kg_m3": robot.rho, "refractive_index": round(float(c.index), 4)},
        "robot": {
            "mass_kg": robot.mass, "yaw_inertia_kg_m2": robot.inertia, "body_length_m": lab.body,
            "head_length_m": robot.head, "head_span_m": robot.span, "hinge_to_com_m": robot.hinge,
            "tail_length_m": robot.tail, "keypoint_depth_m": lab.depth,
        },
        "camera": camera,
    }  # fmt: skip
    if renamed:
        content["bodyparts"] = dict(ALTERNATIVE_PART_NAMES)
    return yaml.safe_dump(content, sort_keys=False)


def write_trial(
    rng: np.random.Generator,
    folder: Path,
    lab: Lab,
    trial: Trial,
    effects: Sequence[Effect],
    *,
    layout: dict,
) -> dict:
    """Keypoints and motor log of a trial; its row of trials.csv."""  # fmt: skip
    times, points, _ = true_keypoints(lab, trial, effects)
    seen, sure = tracked_keypoints(
        rng, lab, obs.keypoint_pixels(lab, trial, effects, times, points)
    )
    rows = recorded_frames(rng, effects, len(times))
    source = f"keypoints/{trial.name}.csv"
    names = (
        [ALTERNATIVE_PART_NAMES[p] for p in KEYPOINT_NAMES] if layout["renamed"] else KEYPOINT_NAMES
    )
    write_keypoints(folder / source, seen[rows], sure[rows], names, multi=layout["multi"])
    row = {
        "trial_id": trial.name, "source": source, "power_pct": trial.power,
        "head_angle_deg": round(float(np.degrees(trial.head_angle)), 3),
        "head_length_m": trial.head,
        "fps": round(lab.fps * (1 + obs.strength_of(effects, "clock_error", 0)), 6),
    }  # fmt: skip
    schedule = trial_inputs(lab, trial, effects)[2]
    if layout["motor"]:
        row["motor_log"] = f"motor/{trial.name}.csv"
        delay = log_delay(trial, effects)
        write_motor(
            rng, folder / row["motor_log"], trial, schedule, late=delay, fill=layout["fill"]
        )
    else:
        used = schedule[: int(trial.seconds / 0.005), 1]
        row["flap_hz"] = round(float(np.median(used)) / (1 + trial.flap_error), 4)
    return row


def write_study(
    rng: np.random.Generator, folder: Path, lab: Lab, effects: Sequence[Effect], layout: dict
) -> None:
    """The whole study folder."""
    for sub in ("keypoints", *(["motor"] if layout["motor"] else [])):
        (folder / sub).mkdir(parents=True)
    rows = [write_trial(rng, folder, lab, trial, effects, layout=layout) for trial in lab.trials]
    pd.DataFrame(rows).to_csv(folder / "trials.csv", index=False)
    text = study_yaml(lab, effects, renamed=layout["renamed"], homography=layout["homography"])
    (folder / "study.yaml").write_text(text)
