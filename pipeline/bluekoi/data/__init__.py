"""The types that flow between the stages, each with its reader and writer.

frame_sampling: a few frames of a film, evenly spaced
types: frames, keypoints, positions, pose, track, flapping, steady state; frozen and checked
columns: numeric columns as csv
quality: which points and frames count, how many samples count as one
motion: poses/ID.csv and tracks/ID.csv
"""

from .csv_columns import read_columns, write_columns
from .frame_sampling import sample_evenly, with_copied_luma
from .keypoint_quality import (
    MIN_KEYPOINT_LIKELIHOOD,
    MIN_POSE_FRAMES,
    has_excess_variance,
    is_confident,
)
from .motion_files import TRACK_COLUMNS, read_pose, read_track, write_pose, write_track
from .types import (
    BODY_PART_NAMES,
    BoolNDArray,
    FlappingFrequency,
    Float,
    Frame,
    KeypointPositions,
    Keypoints,
    Pose,
    SeekableFilm,
    SteadyState,
    Track,
)
