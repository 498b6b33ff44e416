"""Study files: study.yaml, trials.csv, DeepLabCut keypoints, motor logs."""

from __future__ import annotations

from pathlib import Path as Folder
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import yaml
from scipy.interpolate import CubicSpline

from validation.generators.manoeuvring import measurement, noise
from validation.generators.manoeuvring.camera import project
from validation.generators.manoeuvring.dynamics import Array, HiddenEffect, SimulatedPath

if TYPE_CHECKING:
    from validation.generators.manoeuvring.studies import StudyTank

KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
ALTERNATIVE_PART_NAMES = ("snout", "neck_joint", "com_mark", "peduncle", "fluke_tip")


def effect_by_name(effs: list[HiddenEffect], name: str) -> HiddenEffect | None:
    """The effect of that name, if it is hidden here."""
    return next((e for e in effs if e.name == name), None)


def shaft_phases(tank: StudyTank, effs: list[HiddenEffect], seconds: float) -> tuple[Array, Array]:
    """Times (K,) every 5 ms and shaft phase (K, n), rad."""
    t = np.arange(0, seconds + 0.2, 0.005)
    f, _ = tank.actuation(t, effs)
    return t, 2 * np.pi * np.cumsum(f, axis=0) * 0.005


def true_pixels(
    tank: StudyTank, path: SimulatedPath, effs: list[HiddenEffect], j: int, clock: tuple
) -> Array:
    """Noise-free raw pixels (frames, 5, 2) of trial j at its frame times."""
    stretch = effect_by_name(effs, "clock_error")
    c = 1.0 if stretch is None else measurement.time_stretch(stretch, np.array(j), tank.trials)
    n = int((tank.frames[j] - 1) / max(c, 1e-6)) + 1
    t = np.arange(n) / tank.fps * c
    series = np.stack([a[:, j] for a in path.core(tank.robot, tank.drive.head)])
    x, y, psi = CubicSpline(path.t, series, axis=1)(t) if stretch else series[:, :n]
    phi = tank.actuation(t, effs)[1][:, j]
    phase = np.interp(t, clock[0], clock[1][:, j])
    z = noise.keypoint_positions(
        tank.robot, tank.drive.head[j], np.stack([x, y, psi, phi]), phase, tank.noise
    )
    if bias := effect_by_name(effs, "keypoint_bias"):
        z = measurement.keypoint_bias(bias, z, phi, psi)
    depth = tank.robot.depth + tank.added_depth(path, effs)[:, j]
    depth = np.repeat(np.interp(t, path.t, depth), 5)
    px = project(tank.camera, z.reshape(-1, 2), depth)
    if moved := effect_by_name(effs, "camera_shift"):
        share = np.repeat(np.arange(n) / n, 5)
        px = measurement.camera_shift(moved, px, np.full(5 * n, j), tank.trials, share)
    return px.reshape(n, 5, 2)


def keypoint_table(
    px: Array, like: Array, names: tuple[str, ...], individual: bool
) -> pd.DataFrame:
    """DeepLabCut's table of px (frames, p, 2) and likelihood (frames, p)."""
    values = np.concatenate([np.round(px, 3), np.round(like, 4)[..., None]], axis=2)
    keys = [["DLC_tank"], ["fish"], list(names), ["x", "y", "likelihood"]]
    levels = ["scorer", "individuals", "bodyparts", "coords"]
    if not individual:
        del keys[1], levels[1]
    columns = pd.MultiIndex.from_product(keys, names=levels)
    return pd.DataFrame(values.reshape(len(px), -1), columns=columns)


def write_log(
    file: Folder,
    tank: StudyTank,
    effs: list[HiddenEffect],
    j: int,
    clock: tuple,
    *,
    rng: np.random.Generator,
    look: tuple,
) -> None:
    """One motor log; its frequency has the trial's small error, its time the hidden offset."""
    offset = effect_by_name(effs, "time_offset")
    late = (
        0.0 if offset is None else float(measurement.log_offset(offset, np.array(j), tank.trials))
    )
    t = np.arange(0, tank.frames[j] / tank.fps, 0.005)
    slip = 1 + rng.normal(0, tank.noise.flap_pct / 100)
    step = 2 * np.pi * np.interp(t - late, clock[0], clock[1][:, j]) / (2 * np.pi)
    if late < 0:  # beyond the simulated end the motor turns on
        rate = clock[1][-1, j] - clock[1][-2, j]
        step = step + np.maximum(t - late - clock[0][-1], 0) * rate / 0.005
    angle = noise.motor_log(rng, t, slip * step, *look)
    frame = pd.DataFrame({"time_s": np.round(t, 4), "angle_deg": np.round(angle, 2)})
    frame.to_csv(file, index=False)


def stated_lab(tank: StudyTank, effs: list[HiddenEffect]) -> measurement.StatedLab:
    """The lab's statement with the hidden error, if any, in it."""
    lab = tank.lab
    for e in effs:
        if e.name in measurement.STATED_ERRORS:
            lab = measurement.STATED_ERRORS[e.name](lab, e.strength, e.form)
    return lab


def study_yaml(tank: StudyTank, effs: list[HiddenEffect], names: tuple[str, ...]) -> dict[str, Any]:
    """Content of study.yaml."""
    lab, rb = stated_lab(tank, effs), tank.robot
    camera: dict[str, Any] = {"image_size_px": list(lab.camera.size)}
    if tank.layout != "homography":
        camera["model"] = lab.camera.model
        camera["matrix"] = np.round(lab.camera.K, 3).tolist()
        camera["distortion"] = [round(float(d), 6) for d in lab.camera.distortion]
    camera["pool_corners_px"] = np.reshape(lab.corner_px, (4, 2)).tolist()
    camera["pool_corners_height_m"] = lab.corner_height
    content: dict[str, Any] = {
        "pool": {"length_m": round(lab.length, 4), "width_m": round(lab.width, 4), "depth_m": 0.3},
        "water": {"density_kg_m3": 1000.0, "refractive_index": round(lab.camera.index, 4)},
        "robot": {
            "mass_kg": rb.mass,
            "yaw_inertia_kg_m2": rb.yaw_inertia,
            "body_length_m": rb.body_length,
            "head_length_m": rb.head_1x,
            "head_span_m": rb.span,
            "hinge_to_com_m": rb.hinge_to_com,
            "tail_length_m": rb.tail_length,
            "keypoint_depth_m": round(lab.depth, 4),
        },
        "camera": camera,
    }
    if names != KEYPOINT_NAMES:
        content["bodyparts"] = dict(zip(KEYPOINT_NAMES, names, strict=True))
    return content


def write_study(
    folder: Folder,
    tank: StudyTank,
    path: SimulatedPath,
    effs: list[HiddenEffect],
    rng: np.random.Generator,
) -> None:
    """All files of one study."""
    for sub in ("keypoints", "motor") if tank.has_log else ("keypoints",):
        (folder / sub).mkdir(parents=True)
    names = ALTERNATIVE_PART_NAMES if rng.random() < 0.2 else KEYPOINT_NAMES
    individual, look = (
        bool(rng.random() < 0.15),
        (float(rng.uniform(8, 25)), str(rng.choice(["hold", "zero", "empty"]))),
    )
    clock = shaft_phases(tank, effs, path.t[-1])
    rows = []
    for j in range(tank.trials):
        trial = f"R{j + 1:02d}"
        px, like = noise.tracked_keypoints(
            rng, true_pixels(tank, path, effs, j, clock), tank.fps, tank.noise
        )
        table = keypoint_table(px, like, names, individual)
        table.to_csv(folder / "keypoints" / f"{trial}.csv", index_label=None)
        row = {
            "trial_id": trial,
            "source": f"keypoints/{trial}.csv",
            "power_pct": int(tank.power[j]),
            "head_angle_deg": round(float(np.degrees(tank.command[j])), 1),
            "head_length_m": tank.drive.head[j],
            "fps": round(tank.fps, 5),
        }
        if tank.has_log:
            row["motor_log"] = f"motor/{trial}.csv"
            write_log(folder / row["motor_log"], tank, effs, j, clock, rng=rng, look=look)
        else:
            f = np.diff(clock[1][:, j])[-200:].mean() / (2 * np.pi * 0.005)
            row["flap_hz"] = round(float(f * (1 + rng.normal(0, tank.noise.flap_pct / 100))), 4)
        rows.append(row)
    pd.DataFrame(rows).to_csv(folder / "trials.csv", index=False)
    text = yaml.safe_dump(study_yaml(tank, effs, names), sort_keys=False)
    (folder / "study.yaml").write_text(text)
