"""Cameras without a matrix: a homography from the pool corners, with a bound of its error."""

from __future__ import annotations

import numpy as np

from ..data import Float
from ..errors import input_error
from .lens import Lens, project_to_pixels
from .pool_projection import PoolCamera, apply_homography
from .refraction import surface_points_of_light_paths
from .resection import CORNER_REORDERING_ADVICE, pool_diagonal_px, pose_from_marks, rms_length_px

ASSUMED_DISTORTION_K1 = -0.2
"""Radial distortion of a usual wide lens, by which the error of a homography is estimated."""
ASSUMED_MIN_CAMERA_HEIGHT_M = 1.0
"""Height of the camera for which the cost of leaving out refraction is stated."""
GRID_POINTS_PER_SIDE = 15
"""Points along each side of the pool at which that error is evaluated."""
START_FOCAL_LENGTHS_IN_WIDTHS = (0.4, 0.5, 0.65, 0.85, 1.1, 1.5, 2.2)
"""Focal lengths, over the picture's width, from which the pose is searched."""
MAX_POSE_MISFIT_SHARE_OF_POOL_DIAGONAL = 0.04
"""Misfit of the corners, over the pool's diagonal in the picture, above which they are refused."""
NO_MATRIX_REMARK = "camera without a matrix"
"""Beginning of the remark on such a camera."""


def homography_camera(
    corners_px: Float, corners_m: Float, index: float, depth_m: float,
    size_px: tuple[int, int] | None,
) -> PoolCamera:  # fmt: skip
    """Camera that is only a homography, pixel to the plane of the corners, with its error bound.

    The bound is the larger error over a grid of the pool for a point `depth_m` below the corners'
    plane seen from `ASSUMED_MIN_CAMERA_HEIGHT_M` above the pool's middle, plus that of a lens with
    k1 = -0.2 (an action camera's wide mode) whose corners were fitted.
    """
    to_plane = homography_from_four_points(corners_px, corners_m[:, :2])
    depth, lens = (
        ignored_depth_error_bound_m(corners_m, index, depth_m),
        ignored_distortion_error_bound_m(corners_m),
    )
    size = size_px or _size_covering_corners(corners_px)
    _check_corner_order(corners_px, corners_m, size)
    return PoolCamera(
        size_px=size,
        corners_px=corners_px,
        corners_m=corners_m,
        refractive_index=index,
        residuals_px=np.zeros((4, 2)),
        corner_std_px=size[0] / 1920,
        homography=to_plane,
        bound_m=depth + lens,
        remarks=(
            f"{NO_MATRIX_REMARK}: mapped by homography from the pool corners alone, so "
            "refraction, the keypoints' depth and lens distortion are not corrected; places may "
            f"be off by up to {1000 * depth:.0f} mm from depth ({1000 * depth_m:.0f} mm, "
            f"camera {ASSUMED_MIN_CAMERA_HEIGHT_M:g} m up) and {1000 * lens:.0f} mm from an action "
            "camera's distortion: calibrate the camera",
        ),
    )


def ignored_depth_error_bound_m(corners_m: Float, index: float, depth_m: float) -> float:
    """Largest error, m, of taking a point so far down for one on the surface, camera 1 m up."""
    grid = _grid_over_pool_at_height(corners_m, -depth_m)
    middle = corners_m[:, :2].mean(axis=0)
    camera = np.array([*middle, ASSUMED_MIN_CAMERA_HEIGHT_M])
    seen = surface_points_of_light_paths(camera, grid, index)
    return float(np.max(np.linalg.norm(seen[:, :2] - grid[:, :2], axis=1)))


def ignored_distortion_error_bound_m(corners_m: Float) -> float:
    """Largest error, m, inside the pool of a homography fitted to corners seen with k1 = -0.2.

    The pool fills the view of a camera as high as half its length, as an overhead one must.
    """
    length = float(corners_m[2, 0])
    lens = Lens("pinhole", np.eye(3), np.array([ASSUMED_DISTORTION_K1, 0, 0, 0]), (1, 1))
    middle = corners_m.mean(axis=0)
    turn, height = np.diag([1.0, -1.0, -1.0]), max(ASSUMED_MIN_CAMERA_HEIGHT_M, length / 2)
    shift = -turn @ (middle + np.array([0, 0, height]))
    grid = _grid_over_pool_at_height(corners_m, float(middle[2]))
    image, marks = (project_to_pixels(lens, points @ turn + shift) for points in (grid, corners_m))
    back = homography_from_four_points(marks, corners_m[:, :2])
    return float(np.max(np.linalg.norm(apply_homography(back, image) - grid[:, :2], axis=1)))


def _grid_over_pool_at_height(corners_m: Float, z: float) -> Float:
    x, y = np.meshgrid(
        np.linspace(0, corners_m[2, 0], GRID_POINTS_PER_SIDE),
        np.linspace(0, corners_m[2, 1], GRID_POINTS_PER_SIDE),
    )
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])


def homography_from_four_points(source: Float, target: Float) -> Float:
    """The homography through four pairs of points, solved in double precision."""
    rows = []
    for (u, v), (x, y) in zip(source, target, strict=True):
        rows.append([u, v, 1, 0, 0, 0, -x * u, -x * v])
        rows.append([0, 0, 0, u, v, 1, -y * u, -y * v])
    solution = np.linalg.solve(np.array(rows), target.ravel())
    return np.append(solution, 1.0).reshape(3, 3)


def _size_covering_corners(corners_px: Float) -> tuple[int, int]:
    width, height = np.ceil(corners_px.max(axis=0)).astype(int)
    return int(width), int(height)


def _check_corner_order(corners_px: Float, corners_m: Float, size_px: tuple[int, int]) -> None:
    """Raise a InputError where a camera with square pixels fits another order of corners only."""
    limit = MAX_POSE_MISFIT_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(corners_px)
    if _least_pose_error_px(corners_px, corners_m, size_px) <= limit:
        return
    for order, words in CORNER_REORDERING_ADVICE.items():
        if _least_pose_error_px(corners_px[list(order)], corners_m, size_px) < limit / 2:
            raise input_error(
                "study.yaml",
                "camera.pool_corners_px",
                "corners in an order that no camera with square pixels could see",
                "images of pool (0, 0), (length, 0), (length, width), (0, width) in this order",
                f"Another order fits: {words}.",
            )


def _least_pose_error_px(corners_px: Float, corners_m: Float, size_px: tuple[int, int]) -> float:
    """Least reprojection error, px rms, of distortion-free cameras of some focal lengths."""
    errors = []
    for share in START_FOCAL_LENGTHS_IN_WIDTHS:
        focal = share * size_px[0]
        matrix = np.array(
            [[focal, 0, size_px[0] / 2 - 0.5], [0, focal, size_px[1] / 2 - 0.5], [0, 0, 1]]
        )
        lens = Lens("pinhole", matrix, np.zeros(4), size_px)
        errors.append(rms_length_px(pose_from_marks(lens, corners_px, corners_m, 1.0)[2]))
    return min(errors)
