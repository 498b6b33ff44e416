"""A study folder, read and checked at the door: the only reader of study.yaml and trials.csv."""

from .reading import load_study, missing_files, missing_of
from .setup import Camera, Pool, Robot, Setup, Water
from .types import VIDEO_SUFFIXES, Study, Trial
from .yaml_file import lacks_corners
