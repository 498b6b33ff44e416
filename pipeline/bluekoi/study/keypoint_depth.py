"""Depth of the keypoints: given in study.yaml, else estimated, else usual. The one rule for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .types import Study, StudySettings

MAX_ESTIMATED_DEPTH_STD_M = 0.01
"""An estimate less certain than this is worth less than the usual depth."""
DEPTH_DECIMALS = 3
"""An estimate is used to the millimetre, 0.03 % of a length seen from 3 m: the last digits change
with every trial, and each change would place all keypoints again.
"""


def select_keypoint_depth_m(setup: StudySettings, estimate_m: float, std_m: float) -> float:
    """Depth to use, m, given an estimate and its standard deviation (0: no estimate)."""
    inside = 0 <= estimate_m < setup.pool.depth_m
    if setup.robot.keypoint_depth_given or not (0 < std_m < MAX_ESTIMATED_DEPTH_STD_M and inside):
        return setup.robot.keypoint_depth_m
    return round(estimate_m, DEPTH_DECIMALS)


def setup_with_keypoint_depth(
    setup: StudySettings, geometry: Mapping[str, Any] | None
) -> StudySettings:
    """Setup whose `robot.keypoint_depth_m` is the depth to use, with geometry.json's content.

    `robot.keypoint_depth_given` still says whether study.yaml gives it.
    """
    if setup.robot.keypoint_depth_given or not geometry:
        return setup
    fields = dict(setup.robot) | {
        "keypoint_depth_m": float(geometry.get("depth_m", setup.robot.keypoint_depth_m))
    }
    robot = setup.robot.model_construct(setup.robot.model_fields_set, **fields)
    return setup.model_copy(update={"robot": robot})


def study_with_keypoint_depth(study: Study, geometry: Mapping[str, Any] | None) -> Study:
    """Study whose setup is that of `setup_with_keypoint_depth`."""
    return study.model_copy(update={"setup": setup_with_keypoint_depth(study.setup, geometry)})
