"""Whole studies on disk: study.yaml, trials.csv, videos, motor logs, and the truth apart."""

import csv
import io
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pipeline.files import whole_file, write_json, write_text
from pipeline.synthetic.design import Design
from pipeline.synthetic.encode import write_video
from pipeline.synthetic.motor_log import motor_angles, write_motor_log
from pipeline.synthetic.optics import Camera, pool_corners
from pipeline.synthetic.picture import Planes, Stage, add_light, draw_robot, finish, noise_tiles
from pipeline.synthetic.scene import Scene, build_scene
from pipeline.synthetic.seal import seal
from pipeline.synthetic.trial import Trial, camera_at, frame_truth, generator, prepare, summary

__all__ = ["render_study", "render_trial", "write_study_files", "write_truth"]

Progress = Callable[[str, int, int], None]


def _silent(trial_id: str, done: int, total: int) -> None:
    return None


@lru_cache(maxsize=4)
def _scene(camera: Camera, caustics_of: Any, pool: tuple[float, ...], seed: int) -> Scene:
    return build_scene(camera, caustics_of, pool_m=(pool[0], pool[1]), depth_m=pool[2], seed=seed)


def stage_at(design: Design, time_s: float) -> Stage:
    """Pool, camera, light and noise tiles of a design at a time (they change with the knock)."""
    camera, state = camera_at(design, time_s), design.conditions
    pool = (*design.tank.pool_m, design.pool_depth_m)
    scene = _scene(camera, state, pool, design.seed)
    tiles = noise_tiles(np.random.default_rng([design.seed, 7]), camera.size_px)
    return Stage(scene, camera, state, tiles, None)


def frames_of(design: Design, trial: Trial) -> Iterator[Planes]:
    """The frames of a trial, in order."""
    state = design.conditions
    stages = {False: stage_at(design, -1.0)}
    if state.nudge_at_s is not None:
        stages[True] = stage_at(design, np.inf)
    rng = generator(design, trial.plan.trial_id, "noise")
    begin = int(rng.integers(0, 100))
    offsets = state.exposure_s * ((np.arange(state.sub_frames) + 0.5) / state.sub_frames - 0.5)
    for number, now in enumerate(trial.time_s):
        stage = stages[state.nudge_at_s is not None and now >= state.nudge_at_s]
        planes = add_light(stage, begin + number)
        draw_robot(
            planes,
            stage,
            trial.motion.pose(now + offsets),
            robot=trial.tank.robot,
            head_length_m=trial.plan.head_length_m,
            floor_m=design.pool_depth_m,
        )
        yield finish(planes, stage, rng)


def write_truth(design: Design, trial: Trial, truth_folder: Path) -> None:
    """Write `ID.npz` (per frame) and `ID.json` (steady figures, laws) to the truth folder."""
    name = trial.plan.trial_id
    with whole_file(truth_folder / f"{name}.npz") as path, path.open("wb") as out:
        np.savez_compressed(out, **frame_truth(design, trial))
    laws = {"tank": asdict(trial.tank), "run": asdict(trial.run)}
    write_json(truth_folder / f"{name}.json", {**summary(trial), **laws})


def render_trial(
    design: Design, trial_id: str, folder: Path, truth_folder: Path, *, threads: int = 1
) -> Path:
    """The path of the trial's video, written with its motor log and its truth."""
    trial, state = prepare(design, trial_id), design.conditions
    video = folder / "videos" / f"{trial_id}.mp4"
    video.parent.mkdir(parents=True, exist_ok=True)
    write_video(
        video,
        frames_of(design, trial),
        size_px=state.size_px,
        codec=state.codec,
        mbit_s=state.mbit_s,
        preset=state.preset,
        threads=threads,
    )
    _write_motor(design, trial, folder)
    write_truth(design, trial, truth_folder)
    return video


def _write_motor(design: Design, trial: Trial, folder: Path) -> None:
    rng = generator(design, trial.plan.trial_id, "motor")
    rows = motor_angles(trial.motion, float(trial.time_s[-1]), rng)
    write_motor_log(folder / "motor" / f"{trial.plan.trial_id}.csv", rows)


def _study(design: Design) -> dict[str, Any]:
    camera, tank = camera_at(design, -1.0), design.tank
    (fx, fy), (cx, cy) = camera.focal_px, camera.middle_px
    corners = pool_corners(camera, tank.pool_m)
    length, width = tank.pool_m
    return {
        "pool": {"length_m": length, "width_m": width, "depth_m": design.pool_depth_m},
        "water": {
            "density_kg_m3": tank.density_kg_m3,
            "refractive_index": camera.index_water,
        },
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


def write_study_files(design: Design, folder: Path, *, source: str, fps: float | None) -> None:
    """Write study.yaml and trials.csv; `source` is e.g. `videos/{}.mp4`, `fps` for keypoints."""
    write_text(folder / "study.yaml", yaml.safe_dump(_study(design), sort_keys=False))
    header = ["trial_id", "source", "power_pct", "head_angle_deg", "head_length_m", "motor_log"]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header + (["fps"] if fps else []))
    for plan in design.plans:
        name = plan.trial_id
        row = [name, source.format(name), plan.power_pct, plan.head_angle_deg]
        row += [plan.head_length_m, f"motor/{name}.csv"]
        writer.writerow(row + ([f"{fps:.5f}"] if fps else []))
    write_text(folder / "trials.csv", text.getvalue())


def seal_truth(design: Design, folder: Path, truth_folder: Path) -> str:
    """Hash of the study's whole truth, written as `truth.sha256`; the truth as `truth.json`."""
    trials = [summary(prepare(design, plan.trial_id)) for plan in design.plans]
    digest, content = seal({"design": asdict(design), "trials": trials})
    with whole_file(truth_folder / "truth.json") as path:
        path.write_bytes(content)
    write_text(folder / "truth.sha256", digest + "\n")
    return digest


def render_study(
    design: Design,
    folder: Path,
    truth_folder: Path,
    *,
    workers: int = 2,
    progress: Progress = _silent,
) -> str:
    """Hash of the sealed truth of a whole study, rendered to a folder; truth goes elsewhere."""
    write_study_files(design, folder, source="videos/{}.mp4", fps=None)
    names = [plan.trial_id for plan in design.plans]
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        jobs = {pool.submit(render_trial, design, n, folder, truth_folder): n for n in names}
        for done, job in enumerate(as_completed(jobs), start=1):
            job.result()
            progress(jobs[job], done, len(names))
    return seal_truth(design, folder, truth_folder)
