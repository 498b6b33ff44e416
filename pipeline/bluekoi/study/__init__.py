"""A study folder, read and checked at the door: the only reader of study.yaml and trials.csv."""

from .setup import Camera, Pool, Robot, StudySettings, Water
from .study_reading import load_incomplete_study, load_study, missing_files, missing_files_of_trial
from .study_yaml import lacks_pool_corners, stated_image_size_px
from .types import VIDEO_SUFFIXES, Study, Trial
