"""A camera above the pool: pixels to places at a depth and back, with covariance.

Pool frame: origin at a corner on the still water surface, x along the length, y along the width,
z up, metres. X_camera = rotation X_pool + translation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data import Float, KeypointPositions, Keypoints, is_confident
from .lens import Lens, project_to_pixels, ray_directions
from .refraction import intersect_rays_with_depth, surface_points_of_light_paths

DERIVATIVE_STEP_PX = 0.01
"""Step of the difference quotients from pixels to metres."""


@dataclass(frozen=True)
class PoolCamera:
    """One fixed camera over one pool.

    With a lens: rotation (3, 3), translation (3,) m, refraction at the surface with
    `refractive_index` against air. Without: `homography` (3, 3), pixel to pool plane, alone.
    corners_px: (4, 2), images of `corners_m` (4, 3). corner_std_px: what a corner is trusted to.
    residuals_px: (4, 2), given corner minus its reprojection. bound_m: largest error left inside
    the pool by doing without lens and refraction, 0 with a lens.
    """

    size_px: tuple[int, int]
    corners_px: Float
    corners_m: Float
    refractive_index: float
    residuals_px: Float
    corner_std_px: float
    lens: Lens | None = None
    rotation: Float | None = None
    translation: Float | None = None
    homography: Float | None = None
    bound_m: float = 0.0
    remarks: tuple[str, ...] = ()

    @property
    def center_m(self) -> Float:
        """Place of the camera in the pool frame, (3,), m; NaN for a homography."""
        if self.rotation is None or self.translation is None:
            return np.full(3, np.nan)
        return -self.rotation.T @ self.translation

    @property
    def rms_px(self) -> float:
        """Root mean square distance between given and reprojected corners, px."""
        return float(np.sqrt(np.mean(np.sum(self.residuals_px**2, axis=1))))

    @property
    def pool_size_m(self) -> tuple[float, float]:
        """Length and width of the pool, m."""
        return float(self.corners_m[2, 0]), float(self.corners_m[2, 1])


def pool_to_pixels(camera: PoolCamera, xyz_m: Float) -> Float:
    """Pixels (n, 2) of pool points (n, 3); z < 0 is under water and seen refracted.

    Snell's law is met by a root find along the horizontal way. NaN where the camera cannot see
    it. A homography puts every point on the plane of the corners.
    """
    points = np.asarray(xyz_m, dtype=float).reshape(-1, 3)
    if camera.lens is None or camera.rotation is None or camera.translation is None:
        assert camera.homography is not None
        return apply_homography(np.asarray(np.linalg.inv(camera.homography)), points[:, :2])
    seen = surface_points_of_light_paths(camera.center_m, points, camera.refractive_index)
    return project_to_pixels(camera.lens, seen @ camera.rotation.T + camera.translation)


def map_to_pool(camera: PoolCamera, uv_px: Float, depth_m: float | Float) -> Float:
    """Places (n, 2), m, of pixels (n, 2) at a depth below the surface; NaN past the lens's fold.

    The pixel's ray is bent at the surface in closed form and followed down to `depth_m`, one
    number or (n,); a negative depth lies above the water. A homography ignores the depth.
    """
    uv = np.asarray(uv_px, dtype=float).reshape(-1, 2)
    if camera.lens is None or camera.rotation is None:
        assert camera.homography is not None
        return apply_homography(camera.homography, uv)
    rays = ray_directions(camera.lens, uv) @ camera.rotation
    depth = np.broadcast_to(np.asarray(depth_m, dtype=float), (len(uv),))
    return intersect_rays_with_depth(camera.center_m, rays, depth, camera.refractive_index)


def pixel_to_pool_jacobian(camera: PoolCamera, uv_px: Float, depth_m: float | Float) -> Float:
    """Derivative (n, 2, 2) of the place with respect to the pixel, m per px, central differences.

    [:, i, j] is the change of x or y (i) with u or v (j).
    """
    uv = np.asarray(uv_px, dtype=float).reshape(-1, 2)
    slope = np.empty((len(uv), 2, 2))
    for axis, step in enumerate(np.eye(2) * DERIVATIVE_STEP_PX):
        change = map_to_pool(camera, uv + step, depth_m) - map_to_pool(camera, uv - step, depth_m)
        slope[:, :, axis] = change / (2 * DERIVATIVE_STEP_PX)
    return slope


def map_keypoints(camera: PoolCamera, keypoints: Keypoints, depth_m: float) -> KeypointPositions:
    """Keypoints of one trial in the pool frame, all at one depth, with cov = J cov_px2 J^T.

    The covariance is the detections' own; what the calibration adds is common to all frames and
    comes from `calibration_covariance_factor`.
    """
    flat = keypoints.xy_px.reshape(-1, 2)
    xy = map_to_pool(camera, flat, depth_m)
    slope = pixel_to_pool_jacobian(camera, flat, depth_m)
    cov = slope @ keypoints.cov_px2.reshape(-1, 2, 2) @ np.swapaxes(slope, 1, 2)
    shape = keypoints.xy_px.shape
    placed = KeypointPositions(
        time_s=keypoints.time_s,
        names=keypoints.names,
        xy_m=xy.reshape(shape),
        cov_m2=cov.reshape(*shape, 2),
        likelihood=keypoints.likelihood,
    )
    remarks = (*keypoints.remarks, *camera.remarks, *_outside_pool_remark(camera, placed))
    return KeypointPositions(**{**placed.__dict__, "remarks": remarks})


def apply_homography(homography: Float, points: Float) -> Float:
    """Points (n, 2) sent through a homography (3, 3)."""
    lifted = np.column_stack([points, np.ones(len(points))]) @ homography.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return lifted[:, :2] / lifted[:, 2:]


def _outside_pool_remark(
    camera: PoolCamera, positions: KeypointPositions, margin_m: float = 0.05
) -> tuple[str, ...]:
    """A remark where confident keypoints lie outside the pool or cannot be mapped."""
    trusted = is_confident(positions.likelihood)
    length, width = camera.pool_size_m
    low, high = -margin_m, np.array([length, width]) + margin_m
    beyond = np.any((positions.xy_m < low) | (positions.xy_m > high), axis=2) & trusted
    share = float(beyond.sum()) / max(1, int(trusted.sum()))
    if share <= 0.01:
        return ()
    return (
        f"{100 * share:.0f} % of the confident keypoints lie more than {100 * margin_m:.0f} cm "
        "outside the pool: the pool corners, the pool size or the lens are not this camera's",
    )
