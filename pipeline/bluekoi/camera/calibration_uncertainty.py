"""Uncertainty of places from the calibration, common to every frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..data import Float
from .homography_camera import homography_from_four_points
from .pool_projection import PoolCamera, map_to_pool, pool_to_pixels
from .resection import gauss_newton_pose_update


def calibration_covariance_factor(
    camera: PoolCamera, uv_px: Float, depth_m: float | Float
) -> Float:
    """Shifts (n, 2, k), m, of places, one column for each independent error of the calibration.

    The covariance of places i and j from the calibration is modes[i] @ modes[j].T: it does not
    average out over frames, unlike the detections' own. Errors: the two coordinates of each pool
    corner (`camera.corner_std_px`), the pose fitted again to first order.
    """
    uv = np.asarray(uv_px, dtype=float).reshape(-1, 2)
    place = map_to_pool(camera, uv, depth_m)
    modes = [map_to_pool(c, uv, depth_m) - place for c in _perturbed_cameras(camera)]
    return np.stack(modes, axis=2)


def calibration_covariance_at_pixels(
    camera: PoolCamera, uv_px: Float, depth_m: float | Float
) -> Float:
    """Covariance (n, 2, 2), m2, of each place from the calibration alone."""
    modes = calibration_covariance_factor(camera, uv_px, depth_m)
    return np.asarray(modes @ np.swapaxes(modes, 1, 2))


def calibration_covariance_at_points(camera: PoolCamera, xy_m: Float, depth_m: float) -> Float:
    """Covariance (n, 2, 2), m2, of places (n, 2) at a depth from the calibration alone."""
    below = np.column_stack([xy_m, np.full(len(xy_m), -depth_m)])
    return calibration_covariance_at_pixels(camera, pool_to_pixels(camera, below), depth_m)


def _perturbed_cameras(camera: PoolCamera) -> Iterator[PoolCamera]:
    """Cameras one standard deviation away, one for each independent error."""
    for corner in range(4):
        for axis in range(2):
            moved = camera.corners_px.copy()
            moved[corner, axis] += camera.corner_std_px
            yield _refit_camera_pose(replace(camera, corners_px=moved))


def _refit_camera_pose(camera: PoolCamera) -> PoolCamera:
    if camera.lens is None or camera.rotation is None or camera.translation is None:
        plane = homography_from_four_points(camera.corners_px, camera.corners_m[:, :2])
        return replace(camera, homography=plane)
    rotation, translation, residuals = gauss_newton_pose_update(
        camera.lens,
        camera.corners_px,
        camera.corners_m,
        camera.refractive_index,
        rotation=camera.rotation,
        translation=camera.translation,
    )
    return replace(camera, rotation=rotation, translation=translation, residuals_px=residuals)
