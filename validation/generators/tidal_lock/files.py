"""Files of a study folder in the layout of its contract."""

import csv
from pathlib import Path

import numpy as np
import yaml

from .optics import Camera
from .robot import WATER_DENSITY, Robot
from .tracking import BODYPARTS


def study_table(robot: Robot, stated: Camera, corners: np.ndarray) -> dict:
    """Content of study.yaml."""
    (fx, fy), (cx, cy) = stated.focal, stated.principal
    return {
        "pool": {
            "length_m": round(float(stated.size[0]), 4),
            "width_m": round(float(stated.size[1]), 4),
            "depth_m": round(float(robot.pool[2]), 3),
        },
        "water": {
            "density_kg_m3": WATER_DENSITY,
            "refractive_index": round(float(stated.index), 5),
        },
        "robot": {
            "mass_kg": round(float(robot.mass), 6),
            "yaw_inertia_kg_m2": float(f"{robot.inertia:.5g}"),
            "body_length_m": round(float(robot.length), 5),
            "head_length_m": round(float(robot.head), 4),
            "head_span_m": round(float(robot.span), 5),
            "hinge_to_com_m": round(float(robot.hinge_to_com), 5),
            "tail_length_m": round(float(robot.tail), 5),
            "keypoint_depth_m": round(float(stated.depth), 5),
        },
        "camera": {
            "model": stated.model,
            "image_size_px": [int(n) for n in stated.image],
            "matrix": [[float(fx), 0.0, float(cx)], [0.0, float(fy), float(cy)], [0.0, 0.0, 1.0]],
            "distortion": [float(k) for k in stated.distortion],
            "pool_corners_px": [[round(float(u), 2), round(float(v), 2)] for u, v in corners],
            "pool_corners_height_m": float(stated.corner_height),
        },
    }


def write_yaml(path: Path, table: dict) -> None:
    """Write a mapping as YAML in the given order."""
    path.write_text(yaml.safe_dump(table, sort_keys=False, default_flow_style=None))


def write_rows(path: Path, rows: list[dict]) -> None:
    """Write rows of equal keys as CSV with a header."""
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def _cell(value: float, digits: int) -> str:
    return "" if np.isnan(value) else f"{value:.{digits}f}"


def write_keypoints(path: Path, found: np.ndarray, likelihood: np.ndarray) -> None:
    """Write detections (frames, 5, 2) and likelihoods (frames, 5) in DeepLabCut's layout."""
    names = [name for name in BODYPARTS for _ in range(3)]
    lines = [
        ",".join(["scorer", *["overhead"] * len(names)]),
        ",".join(["bodyparts", *names]),
        ",".join(["coords", *["x", "y", "likelihood"] * len(BODYPARTS)]),
    ]
    for k, (points, likelihoods) in enumerate(zip(found, likelihood, strict=True)):
        cells = [str(k)]
        for (u, v), certainty in zip(points, likelihoods, strict=True):
            cells += [_cell(u, 3), _cell(v, 3), _cell(certainty, 4)]
        lines.append(",".join(cells))
    path.write_text("\n".join(lines) + "\n")
