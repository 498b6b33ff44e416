"""Write one study folder in the layout of STUDY.md."""

import math
import os
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from numpy.typing import NDArray

from validation.generators.strip_theory.detector import ObservationScene
from validation.generators.strip_theory.noise import shaft_log, tracked_keypoints
from validation.generators.strip_theory.optics import (
    KEYPOINT_NAMES,
    StatedSetup,
    keypoint_pixels,
    labelled_keypoints,
    stated_optics,
)
from validation.generators.strip_theory.parameters import KEYS
from validation.generators.strip_theory.tank import SimulatedTrial

Floats = NDArray[np.float64]
ALTERNATIVE_PART_NAMES = ("nose", "neck", "body", "peduncle", "fluke")


def keypoints_with_recoil(
    run: SimulatedTrial, scene: ObservationScene, phase: float
) -> NDArray[np.complex128]:
    """World keypoints (frames, 5) with tail-beat recoil and the wag of the tail."""
    Y, noise = run.Y.copy(), scene.noise
    phi = run.phi[:: 2 * run.sub]
    f = run.freq[:: 2 * run.sub]
    steps = 0.5 * (run.freq[1:] + run.freq[:-1]) * 0.5 * run.dt
    turns = np.concatenate([[0.0], np.cumsum(steps)])[:: 2 * run.sub]
    beat = np.minimum(f / 4.0, 1.0) * np.sin(2 * np.pi * turns + phase)
    lagging = np.minimum(f / 4.0, 1.0) * np.sin(2 * np.pi * turns + phase - 1.2)
    side = 1j * np.exp(1j * (Y[:, 4] + phi))
    Y[:, 4] += noise.recoil_heading_rad * beat
    sway = noise.recoil_sway_m * lagging * side
    Y[:, 0], Y[:, 1] = Y[:, 0] + sway.real, Y[:, 1] + sway.imag
    points = labelled_keypoints(run, Y, phi)
    points[:, 3] += 0.1 * noise.tail_wag_m * lagging * side
    points[:, 4] += noise.tail_wag_m * lagging * side
    return points


def recorded_frames(run: SimulatedTrial, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Frames that reach the file: all, or those left when frames were dropped unnoticed."""
    kept = np.ones(len(run.Y), dtype=bool)
    if run.P[KEYS.CLOCK_FORM] == 2:
        kept[1:] = rng.random(len(kept) - 1) >= abs(run.P[KEYS.CLOCK])
    return kept


def stated_fps(run: SimulatedTrial) -> float:
    """Frames per second as trials.csv states them."""
    wrong = run.P[KEYS.CLOCK] if run.P[KEYS.CLOCK_FORM] == 1 else 0.0
    return run.trial.fps * (1.0 + wrong)


def keypoint_table(pixels: Floats, likelihood: Floats, names: tuple[str, ...], animal: str | None
                   ) -> pd.DataFrame:  # fmt: skip
    """DeepLabCut's table; with `animal` the multi-animal layout."""
    n = len(pixels)
    data = np.concatenate([pixels, likelihood[:, :, None]], axis=2).reshape(n, -1)
    levels = [["DLC_strip"], [animal] if animal else None, list(names), ["x", "y", "likelihood"]]
    labels = ["scorer", "individuals" if animal else None, "bodyparts", "coords"]
    columns = pd.MultiIndex.from_product(
        [level for level in levels if level], names=[label for label in labels if label]
    )
    return pd.DataFrame(np.round(data, 3), columns=columns)


def study_yaml(
    P: Floats, stated: StatedSetup, depth_pool: float, names: tuple[str, ...], plain: bool
) -> dict:
    """Content of study.yaml."""
    camera = stated.camera
    (fx, fy), (cx, cy) = camera.focal, camera.center
    lens = {} if plain else {
        "model": camera.model,
        "matrix": [[round(fx, 3), 0.0, round(cx, 3)], [0.0, round(fy, 3), round(cy, 3)],
                   [0.0, 0.0, 1.0]],
        "distortion": [round(float(k), 7) for k in camera.distortion],
    }  # fmt: skip
    keys = {"mass_kg": KEYS.MASS, "yaw_inertia_kg_m2": KEYS.INERTIA, "body_length_m": KEYS.BODY,
            "head_length_m": KEYS.HEAD_1X, "head_span_m": KEYS.SPAN, "hinge_to_com_m": KEYS.HINGE,
            "tail_length_m": KEYS.TAIL}  # fmt: skip
    pool = [round(float(side), 4) for side in stated.pool]
    out: dict = {
        "pool": {"length_m": pool[0], "width_m": pool[1], "depth_m": depth_pool},
        "water": {"density_kg_m3": 1000.0, "refractive_index": round(float(camera.index), 4)},
        "robot": {key: float(P[k]) for key, k in keys.items()}
        | {"keypoint_depth_m": round(float(stated.depth), 4)},
        "camera": lens
        | {"image_size_px": list(camera.size),
           "pool_corners_px": [[round(float(u), 2), round(float(v), 2)]
                               for u, v in stated.corners_px],
           "pool_corners_height_m": 0.0},
    }  # fmt: skip
    if names != KEYPOINT_NAMES:
        out["bodyparts"] = dict(zip(KEYPOINT_NAMES, names, strict=True))
    return out


def write_trial(
    folder: Path,
    run: SimulatedTrial,
    scene: ObservationScene,
    style: dict,
    rng: np.random.Generator,
) -> dict[str, object]:
    """Write keypoints and motor log of one trial; return its row of trials.csv."""
    name, fps = run.trial.name, stated_fps(run)
    kept = recorded_frames(run, rng)
    points = keypoints_with_recoil(run, scene, rng.uniform(0, 2 * np.pi))
    pixels, likelihood = tracked_keypoints(
        keypoint_pixels(run, points, run.times, scene.camera, scene.depth),
        run.trial.fps,
        scene.noise,
        rng,
    )
    table = keypoint_table(pixels[kept], likelihood[kept], style["names"], style["animal"])
    table.to_csv(folder / "keypoints" / f"{name}.csv")
    row: dict[str, object] = {
        "trial_id": name, "source": f"keypoints/{name}.csv", "power_pct": run.trial.power_pct,
        "head_angle_deg": round(math.degrees(run.trial.command), 6),
        "head_length_m": run.trial.head_length, "fps": round(fps, 5),
    }  # fmt: skip
    logged = run.freq / (1.0 + run.trial.flap_error)  # as the log shows it, without the gear's slip
    late = round(
        run.P[KEYS.TIME] / (0.5 * run.dt)
    )  # half steps that the log runs ahead of the video
    logged = np.concatenate([logged[late:], np.full(late, logged[-1])])
    if style["log"]:
        t, angle = shaft_log(logged, 0.5 * run.dt, style["dead_zone"], rng)
        log = pd.DataFrame({"time_s": np.round(t, 4), "angle_deg": np.round(angle, 3)})
        log.to_csv(folder / "motor" / f"{name}.csv", index=False)
        return row | {"motor_log": f"motor/{name}.csv"}
    return row | {"flap_hz": round(float(np.median(logged[len(logged) // 2 :])), 4)}


def write_study(
    folder: Path,
    runs: list[SimulatedTrial],
    P: Floats,
    scene: ObservationScene,
    *,
    plain: bool,
    rng: np.random.Generator,
) -> dict[str, object]:
    """Write the whole folder, or nothing; return the layout for the truth file."""
    corner_error = np.zeros((4, 2)) if plain else rng.normal(0.0, 0.25, (4, 2))
    stated = stated_optics(scene.camera, scene.depth, P, corner_error)
    shows_start = P[KEYS.TIME] != 0.0 or runs[0].trial.lead_in > 0.0
    style = {
        "names": ALTERNATIVE_PART_NAMES if rng.random() < 0.2 else KEYPOINT_NAMES,
        "animal": "koi1" if rng.random() < 0.15 else None,
        "log": bool(rng.random() < 0.8 or shows_start),
        "dead_zone": (float(rng.uniform(8, 30)), str(rng.choice(["hold", "zero", "empty"]))),
    }
    part = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    (part / "keypoints").mkdir(parents=True)
    if style["log"]:
        (part / "motor").mkdir()
    rows = [write_trial(part, run, scene, style, rng) for run in runs]
    pd.DataFrame(rows).to_csv(part / "trials.csv", index=False)
    text = yaml.safe_dump(study_yaml(P, stated, 0.3, style["names"], plain), sort_keys=False)
    (part / "study.yaml").write_text(text)
    shutil.rmtree(folder, ignore_errors=True)
    os.replace(part, folder)
    return {
        "motor_log": style["log"],
        "homography_only": plain,
        "multi_animal": bool(style["animal"]),
    }
