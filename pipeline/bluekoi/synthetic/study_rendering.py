"""Whole studies on disk: study.yaml, trials.csv, videos, motor logs, and the truth apart."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bluekoi.files import atomic_write, read_json, write_json, write_rows, write_text
from bluekoi.synthetic.encode import write_video
from bluekoi.synthetic.footage import render_frames, visible_keypoints
from bluekoi.synthetic.motor_log import motor_angles, write_motor_log
from bluekoi.synthetic.optics import pool_corners
from bluekoi.synthetic.synthetic_study_design import StudyDesign
from bluekoi.synthetic.trial import (
    SolvedTrial,
    camera_of_design_at_time,
    frame_truth,
    solve_trial,
    steady_summary,
    trial_rng,
    true_path_without_recoil,
)


def write_trial_truth(design: StudyDesign, trial: SolvedTrial, truth_folder: Path) -> None:
    """Write `ID.npz` (per frame) and `ID.json` (steady figures, laws) to the truth folder."""
    name = trial.plan.trial_id
    with atomic_write(truth_folder / f"{name}.npz") as path, path.open("wb") as out:
        truth = frame_truth(design, trial)
        seen = visible_keypoints(design, trial, truth["keypoints_px"])
        np.savez_compressed(out, **{**truth, "visible": seen})  # type: ignore[arg-type]
    write_json(truth_folder / f"{name}.json", trial_truth(trial))


def trial_truth(trial: SolvedTrial) -> dict[str, Any]:
    """What is true of one trial: steady figures, mean path, laws."""
    laws = {"tank": asdict(trial.tank), "run": asdict(trial.run)}
    return {**steady_summary(trial), "mean_path": true_path_without_recoil(trial), **laws}


def study_truth(design: StudyDesign, trials: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """A study's whole truth, ready for json, from the truths of its trials.

    `hidden`: what the paper's model lacks, by cause; `coefficients`: by name, or by power and name.
    """
    tank = design.tank
    slope_area = tank.fin.area_m2 * tank.fin.lift_slope if tank.fin else 0.0
    fin = {"lift_area": slope_area, "arm": tank.fin.arm_m} if tank.fin else {}
    common = {power: asdict(c) for power, c in design.coefficients_at.items()}
    damping = {"N_r": tank.yaw_damping_n_m_s} if tank.yaw_damping_n_m_s else {}
    lacking = {"tail_fin_lift": fin, "linear_yaw_damping": damping}
    return {
        "hidden": {name: values for name, values in lacking.items() if values},
        "coefficients": common or asdict(tank.coefficients),
        "design": asdict(design),
        "trials": list(trials),
    }


def render_trial(
    design: StudyDesign, trial_id: str, folder: Path, truth_folder: Path, *, threads: int = 1
) -> Path:
    """The path of the trial's video, written with its motor log and its truth."""
    trial, state = solve_trial(design, trial_id), design.conditions
    video = folder / "videos" / f"{trial_id}.mp4"
    video.parent.mkdir(parents=True, exist_ok=True)
    write_video(
        video,
        render_frames(design, trial),
        size_px=state.size_px,
        codec=state.codec,
        mbit_s=state.mbit_s,
        preset=state.preset,
        threads=threads,
    )
    write_trial_motor_log(design, trial, folder)
    write_trial_truth(design, trial, truth_folder)
    return video


def write_trial_motor_log(design: StudyDesign, trial: SolvedTrial, folder: Path) -> None:
    """Write `motor/ID.csv` of a trial."""
    rng = trial_rng(design, trial.plan.trial_id, "motor")
    rows = motor_angles(trial.motion, float(trial.time_s[-1]), rng)
    write_motor_log(folder / "motor" / f"{trial.plan.trial_id}.csv", rows)


def study_yaml_content(design: StudyDesign) -> dict[str, Any]:
    """Content of study.yaml: pool, water, robot, camera with the corners it sees."""
    camera, tank = camera_of_design_at_time(design, -1.0), design.tank
    (fx, fy), (cx, cy) = camera.focal_px, camera.middle_px
    corners = pool_corners(camera, tank.pool_m)
    length, width = tank.pool_m
    return {
        "pool": {"length_m": length, "width_m": width, "depth_m": design.pool_depth_m},
        "water": {"density_kg_m3": tank.density_kg_m3, "refractive_index": camera.index_water},
        "robot": asdict(tank.robot),
        "camera": {
            "model": camera.lens,
            "image_size_px": list(camera.size_px),
            "matrix": [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]],
            "distortion": list(camera.distortion),
            "pool_corners_px": [[round(float(v), 4) for v in corner] for corner in corners],
            "pool_corners_height_m": 0.0,
        },
    }


def write_study_files(design: StudyDesign, folder: Path, *, source: str, fps: float | None) -> None:
    """Write study.yaml and trials.csv; `source` is e.g. `videos/{}.mp4`, `fps` for keypoints."""
    write_text(folder / "study.yaml", yaml.safe_dump(study_yaml_content(design), sort_keys=False))
    header = ["trial_id", "source", "power_pct", "head_angle_deg", "head_length_m", "motor_log"]
    rows: list[list[Any]] = [header + (["fps"] if fps else [])]
    for plan in design.plans:
        name = plan.trial_id
        row = [name, source.format(name), plan.power_pct, plan.head_angle_deg]
        row += [plan.head_length_m, f"motor/{name}.csv"]
        rows.append(row + ([f"{fps:.5f}"] if fps else []))
    write_rows(folder / "trials.csv", rows)


def write_study_truth(design: StudyDesign, truth_folder: Path) -> None:
    """Write truth.json, the study's whole truth, from the trials' json in the truth folder."""
    trials = [read_json(truth_folder / f"{plan.trial_id}.json") for plan in design.plans]
    write_json(truth_folder / "truth.json", study_truth(design, trials))


def render_study(
    design: StudyDesign, folder: Path, truth_folder: Path, *, workers: int = 2
) -> None:
    """Render a whole study to a folder; its truth goes elsewhere."""
    write_study_files(design, folder, source="videos/{}.mp4", fps=None)
    names = [plan.trial_id for plan in design.plans]
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        jobs = [pool.submit(render_trial, design, n, folder, truth_folder) for n in names]
        for job in as_completed(jobs):
            job.result()
    write_study_truth(design, truth_folder)
