"""Depth of the keypoints of a study, from its results folder."""

from __future__ import annotations

from ..files import read_json_if_present
from ..study import StudySettings
from ..study.keypoint_depth import setup_with_keypoint_depth
from .result_paths import ResultPaths


def keypoint_depth(setup: StudySettings, layout: ResultPaths) -> float:
    """Depth to use, m, by `study.keypoint_depth`; no estimate until geometry.json is there."""
    return setup_with_keypoint_depth(
        setup, read_json_if_present(layout.geometry)
    ).robot.keypoint_depth_m
