"""Keypoints from footage or from other people's files; every module in this folder is a source.

Sources from footage have `detect_keypoints(frames, setup, trial) -> Keypoints`, those from files
`read_keypoints_of_trial(path, trial, bodyparts) -> Keypoints`. A new source is one new module here.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import ModuleType

from ..errors import did_you_mean, input_error

NO_ROBOT_REMARK = "No robot was found: "
"""Beginning of the remark on a video in which a detector found no robot; the reason follows."""


def keypoint_source_names() -> tuple[str, ...]:
    """Names of the sources: the modules of this folder."""
    names = (path.stem for path in Path(__file__).parent.glob("*.py"))
    return tuple(sorted(name for name in names if not name.startswith("_")))


def keypoint_source_module(name: str) -> ModuleType:
    """Module of a source.

    Raises: InputError with the nearest known name where there is none of that name.
    """
    if name not in keypoint_source_names():
        raise input_error(
            "study.yaml",
            "detection.source",
            f"'{name}'",
            "a keypoint source",
            did_you_mean(name, keypoint_source_names()),
        )
    return import_module(f"{__name__}.{name}")
