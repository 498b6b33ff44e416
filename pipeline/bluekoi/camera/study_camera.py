"""The camera of a study, from its lens and pool corners, checked by their reprojection."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import Float
from ..errors import input_error
from ..study import Camera, Pool, StudySettings
from ..study.recording_pixels import setup_in_recording_pixels
from .homography_camera import homography_camera
from .lens import Lens
from .pool_projection import PoolCamera
from .resection import (
    CORNER_NAMES,
    MAX_REPROJECTION_SHARE_OF_POOL_DIAGONAL,
    corner_reordering_advice,
    pool_diagonal_px,
    pool_rectangle,
    pose_from_marks,
)

CORNER_CLICK_ERROR_PX = 1.0
"""Usual error of a corner given by eye, px, in a picture `REFERENCE_WIDTH_PX` wide."""
CORNER_TOLERANCE_SHARE_OF_POOL_DIAGONAL = 0.002
"""Error of a corner that is tolerated, over the pool's diagonal in the picture."""
REFERENCE_WIDTH_PX = 1920
"""Width of the picture for which `CORNER_CLICK_ERROR_PX` holds."""


def pool_camera(setup: StudySettings, size_px: tuple[int, int] | None = None) -> PoolCamera:
    """Camera of a study: lens, pose from the pool corners, refractive index, remarks.

    size_px: (width, height) of the recording at hand, where known; a recording scaled in both
    directions alike is accepted, any other size is an error. Without a matrix the corners give a
    homography; `bound_m` and the remarks state its error.

    Raises: InputError where the corners fit no pose; its remedy says which order of corners would.
    """
    given = (setup_in_recording_pixels(setup, size_px) if size_px else setup).camera
    depth_m = setup.robot.keypoint_depth_m
    return pool_camera_from_parts(given, setup.pool, setup.water.refractive_index, depth_m, size_px)


def pool_camera_from_parts(
    given: Camera, pool: Pool, index: float, depth_m: float, size_px: tuple[int, int] | None = None
) -> PoolCamera:
    """`pool_camera` of a camera, a pool, a refractive index and a depth of the keypoints."""
    corners_px = np.array(given.pool_corners_px, dtype=float)
    corners_m = pool_rectangle(pool.length_m, pool.width_m, given.pool_corners_height_m)
    lens = lens_of_camera_section(given)
    if lens is None:
        return homography_camera(
            corners_px, corners_m, index, depth_m, size_px or given.image_size_px
        )
    return camera_from_corners(lens, corners_px, corners_m, index)


def pool_corners_m(setup: StudySettings) -> Float:
    """The pool's corners (4, 3), m, at the height at which their images are given."""
    pool = setup.pool
    return pool_rectangle(pool.length_m, pool.width_m, setup.camera.pool_corners_height_m)


def lens_of_camera_section(given: Camera) -> Lens | None:
    """Lens of a camera section; None where it has no matrix."""
    if given.matrix is None:
        return None
    assert given.image_size_px is not None
    distortion = np.array(given.distortion or np.zeros(4), dtype=float)
    return Lens(given.model, np.array(given.matrix, dtype=float), distortion, given.image_size_px)


def camera_from_corners(
    lens: Lens, corners_px: Float, corners_m: Float, index: float
) -> PoolCamera:
    """Camera whose pose brings the corners (4, 3) m nearest to their images (4, 2) px.

    Raises: InputError where they lie outside the lens model or miss by more than 1.5 % of the
    pool's diagonal in the picture.
    """
    rotation, translation, residuals = pose_from_marks(lens, corners_px, corners_m, index)
    width = lens.size_px[0]
    spread = CORNER_CLICK_ERROR_PX * width / REFERENCE_WIDTH_PX
    camera = PoolCamera(
        size_px=lens.size_px,
        corners_px=corners_px,
        corners_m=corners_m,
        refractive_index=index,
        residuals_px=residuals,
        corner_std_px=float(np.sqrt((np.sum(residuals**2) + 4 * spread**2) / 6)),
        lens=lens,
        rotation=rotation,
        translation=translation,
    )
    _check_camera_pose(camera)
    return replace(camera, remarks=_corner_misfit_remarks(camera))


def _check_camera_pose(camera: PoolCamera) -> None:
    limit = MAX_REPROJECTION_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(camera.corners_px)
    if camera.rms_px <= limit and camera.center_m[2] > 0:
        return
    assert camera.lens is not None
    fits = corner_reordering_advice(
        camera.lens, camera.corners_px, camera.corners_m, camera.refractive_index
    )
    reasons = (
        f"Another order fits: {fits}."
        if fits
        else "No order fits either: check pool length and width, matrix, distortion and model, and "
        "that the corners were read in a raw frame (not undistorted) of this size."
    )
    worst = int(np.argmax(np.linalg.norm(camera.residuals_px, axis=1)))
    raise input_error(
        "study.yaml",
        "camera.pool_corners_px",
        f"corners that miss the best pose by {camera.rms_px:.0f} px rms "
        f"(most at pool {CORNER_NAMES[worst]})",
        f"images of pool {', '.join(CORNER_NAMES)} in this order, within {limit:.0f} px",
        reasons,
    )


def _corner_misfit_remarks(camera: PoolCamera) -> tuple[str, ...]:
    limit = CORNER_TOLERANCE_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(camera.corners_px)
    if camera.rms_px <= limit:
        return ()
    scale = np.linalg.norm(camera.corners_m[2] - camera.corners_m[0]) / pool_diagonal_px(
        camera.corners_px
    )
    return (
        f"the pool corners miss the best pose by {camera.rms_px:.1f} px rms "
        f"(about {1000 * scale * camera.rms_px:.0f} mm): look at them with `bluekoi pool`",
    )
