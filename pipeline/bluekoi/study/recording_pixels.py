"""The camera section of a study in the pixels of a recording, and back.

Not among the files of the camera: detection would run again whenever one of those changes.
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from ..errors import input_error
from .setup import StudySettings


def setup_in_recording_pixels(
    setup: StudySettings, size_px: tuple[int, int], name: str = "the recording"
) -> StudySettings:
    """Setup whose camera section speaks of the pixels of a recording of this size (width, height).

    name: of the recording, for the fault.

    Raises: InputError where the recording is not the picture of study.yaml, scaled alike in both
    directions.
    """
    scale, given = recording_to_study_pixel_ratio(setup, size_px, name), setup.camera
    if scale == 1.0:
        return setup
    corners = np.array(given.pool_corners_px, dtype=float) * scale + (scale - 1) / 2
    changed: dict[str, object] = {
        "pool_corners_px": tuple((float(u), float(v)) for u, v in corners),
        "image_size_px": tuple(size_px),
    }
    if given.matrix is not None:
        matrix = picture_scaling_homography(scale) @ np.array(given.matrix, dtype=float)
        changed["matrix"] = tuple(map(tuple, matrix.tolist()))
    return setup.model_copy(update={"camera": given.model_copy(update=changed)})


def to_study_pixels(setup: StudySettings, size_px: tuple[int, int], points_px: Float) -> Float:
    """Points (n, 2) of a recording of this size in the pixels that study.yaml speaks of."""
    scale = recording_to_study_pixel_ratio(setup, size_px)
    return (points_px - (scale - 1) / 2) / scale


def picture_scaling_homography(factor: float) -> Float:
    """Pixels of a picture to those of one `factor` times as large, homogeneous (3, 3).

    Pixel centres lie at whole numbers.
    """
    shift = (factor - 1) / 2
    return np.array([[factor, 0, shift], [0, factor, shift], [0, 0, 1]])


def recording_to_study_pixel_ratio(
    setup: StudySettings, size_px: tuple[int, int] | None, name: str = "the recording"
) -> float:
    """How many times larger the recording is than the picture study.yaml speaks of."""
    return recording_to_declared_size_ratio(setup.camera.image_size_px, size_px, name)


def recording_to_declared_size_ratio(
    declared: tuple[int, int] | None, size_px: tuple[int, int] | None, name: str
) -> float:
    """How many times larger a recording of this name is than the declared image_size_px.

    Raises: InputError where it is not scaled alike in both directions.
    """
    if size_px is None or declared is None or tuple(size_px) == tuple(declared):
        return 1.0
    ratios = [size_px[0] / declared[0], size_px[1] / declared[1]]
    if abs(ratios[0] / ratios[1] - 1) < 0.002:
        return float(np.mean(ratios))
    turned = size_px[0] == declared[1] and size_px[1] == declared[0]
    raise input_error(
        "study.yaml",
        "camera.image_size_px",
        f"{declared[0]} x {declared[1]}, but {name} has {size_px[0]} x {size_px[1]}",
        "the recording's own size, or one scaled alike in both directions",
        "The recording is turned by 90 degrees: calibrate and give the corners in turned frames."
        if turned
        else "Another field of view needs its own matrix and corners.",
    )
