"""Lens, pose and refraction: from pixels to places in the pool, with covariance."""

from .corners import camera_from_corners, pool_camera
from .lens import Lens
from .pool import PoolCamera, jacobian, map_keypoints, project, to_pool

__all__ = [
    "Lens",
    "PoolCamera",
    "camera_from_corners",
    "jacobian",
    "map_keypoints",
    "pool_camera",
    "project",
    "to_pool",
]
