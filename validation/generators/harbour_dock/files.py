"""The files of a study: study.yaml, trials.csv, labels and motor logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.random import Generator

from .labels import Footage, Style, Take, draw_style, write_labels, write_log
from .view import POINTS, View


def _study(view: View, style: Style) -> dict[str, Any]:
    """study.yaml."""
    lens = view.lens_written
    k = [float(value) for value in lens.k]
    study: dict[str, Any] = {
        "pool": {
            "length_m": round(float(view.pool_written[0]), 4),
            "width_m": round(float(view.pool_written[1]), 4),
            "depth_m": view.trials.pool[2],
        },
        "water": {
            "density_kg_m3": 1000.0,
            "refractive_index": round(float(view.index_written), 4),
        },
        "robot": view.robot.study() | {"keypoint_depth_m": round(view.depth_written, 5)},
        "camera": {
            "model": lens.model,
            "image_size_px": list(view.camera.size),
            "matrix": [[k[0], 0.0, k[2]], [0.0, k[1], k[3]], [0.0, 0.0, 1.0]],
            "distortion": [round(float(value), 7) for value in lens.dist],
            "pool_corners_px": view.corner_px().tolist(),
            "pool_corners_height_m": float(view.height_written),
        },
    }
    if any(style.names[name] != name for name in POINTS):
        study["bodyparts"] = dict(style.names)
    return study


def write(rng: Generator, folder: Path, footage: Footage, has_log: bool) -> list[float]:
    """All files; returns the flapping frequencies (Hz) of the trials."""
    for sub in ("keypoints", "motor") if has_log else ("keypoints",):
        (folder / sub).mkdir(parents=True, exist_ok=True)
    view, trials, track = footage.view, footage.view.trials, footage.track
    style = draw_style(rng)
    (folder / "study.yaml").write_text(yaml.safe_dump(_study(view, style), sort_keys=False))
    states_flap = (has_log and rng.random() < 0.5) or not has_log
    columns = ["trial_id", "source", "power_pct", "head_angle_deg", "head_length_m", "fps"]
    columns += ["motor_log"] if has_log else []
    columns += ["flap_hz"] if states_flap else []
    rows, flap = [columns], []
    for trial in range(len(trials.phi)):
        name = f"H{trial + 1:02d}"
        take = Take(trial, phase=float(rng.random()))
        write_labels(rng, folder / "keypoints" / f"{name}.csv", footage, style, take)
        end = float(view.true_time(trials.duration[[trial]], trial)[0])
        late = np.linspace(0.5 * end, end, 60)
        flap.append(round(float(track.at("flap", late, trial).mean()), 4))
        row = [
            name, f"keypoints/{name}.csv", f"{trials.power[trial]:g}",
            f"{np.rad2deg(trials.phi[trial]):.6g}", f"{trials.head[trial]:.4f}",
            f"{trials.fps:.5f}",
        ]  # fmt: skip
        if has_log:
            log = f"motor/{name}.csv"
            write_log(rng, folder / log, track, style, take, end=end + 0.05)
            row.append(log)
        if states_flap:
            row.append(f"{flap[-1]:.4f}")
        rows.append(row)
    (folder / "trials.csv").write_text("\n".join(",".join(row) for row in rows) + "\n")
    return flap
