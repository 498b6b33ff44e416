"""What geometry.json in the results folder says of depth and displacements of the keypoints."""

from __future__ import annotations

from ..files import read_json_if_present
from ..study import StudySettings, Trial
from ..study.keypoint_depth import setup_with_keypoint_depth
from .layout import ResultPaths


def keypoint_depth(setup: StudySettings, layout: ResultPaths) -> float:
    """Depth to use, m, by `study.keypoint_depth`; no estimate until geometry.json is there."""
    return setup_with_keypoint_depth(
        setup, read_json_if_present(layout.geometry)
    ).robot.keypoint_depth_m


def keypoint_displacement_vectors(
    trial: Trial, layout: ResultPaths
) -> dict[str, tuple[float, float]]:
    """Keypoint -> displacement (x, y) in the pool frame, m, of `camera.keypoint_displacement`.

    Empty for trials of videos: their tracks do not wait for geometry.json.
    """
    geometry = read_json_if_present(layout.geometry) if trial.reads_keypoints else None
    displaced = (geometry or {}).get("keypoint_displacements") or {}
    return {name: (found["x_m"], found["y_m"]) for name, found in displaced.items()}
