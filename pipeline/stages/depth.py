"""How deep the keypoints lie: as study.yaml says, else as the rigid distances told."""

from __future__ import annotations

from ..files import read_json
from ..study import Setup
from .layout import Layout


def keypoint_depth(setup: Setup, layout: Layout) -> float:
    """Depth of the keypoints, m: as study.yaml gives it, else as the distances tell it.

    The usual one where they were not asked: the workflow asks them before the tracks.
    """
    if setup.robot.depth_given or not layout.geometry.is_file():
        return setup.robot.keypoint_depth_m
    return float(read_json(layout.geometry)["depth_m"])
