"""Depth of the keypoints of a study whose results stand in a folder."""

from __future__ import annotations

from ..files import optional_json
from ..study import Setup
from ..study.depth import with_depth
from .layout import Layout


def keypoint_depth(setup: Setup, layout: Layout) -> float:
    """Depth to use, m, by `study.depth`; before geometry.json is there, without an estimate."""
    return with_depth(setup, optional_json(layout.geometry)).robot.keypoint_depth_m
