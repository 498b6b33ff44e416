"""A study folder, read and checked at the door: the only reader of study.yaml and trials.csv."""

from .reading import load_study, missing_files, missing_of
from .setup import Camera, Detection, Pool, Robot, Setup, Water
from .types import KEYPOINT_SUFFIXES, VIDEO_SUFFIXES, Study, Trial
from .yaml_file import lacks_corners

__all__ = [
    "KEYPOINT_SUFFIXES",
    "VIDEO_SUFFIXES",
    "Camera",
    "Detection",
    "Pool",
    "Robot",
    "Setup",
    "Study",
    "Trial",
    "Water",
    "lacks_corners",
    "load_study",
    "missing_files",
    "missing_of",
]
