"""Lens, pose and refraction: from pixels to places in the pool, with covariance."""

from .corners import camera_from_corners, pool_camera
from .lens import Lens
from .pool import PoolCamera, jacobian, map_keypoints, project, to_pool
