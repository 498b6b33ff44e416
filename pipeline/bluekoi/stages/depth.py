"""Depth of the keypoints of a study whose results stand in a folder."""

from __future__ import annotations

from ..files import read_json
from ..study import Setup
from ..study.depth import with_depth
from .layout import Layout


def keypoint_depth(setup: Setup, layout: Layout) -> float:
    """Depth to use, m, by `study.depth`; before geometry.json is there, without an estimate."""
    geometry = read_json(layout.geometry) if layout.geometry.is_file() else None
    return with_depth(setup, geometry).robot.keypoint_depth_m
