"""Lens, pose and refraction: from pixels to places in the pool, with covariance."""

from .lens import Lens
from .pool_projection import (
    PoolCamera,
    map_keypoints,
    map_to_pool,
    pixel_to_pool_jacobian,
    pool_to_pixels,
)
from .study_camera import camera_from_corners, pool_camera
