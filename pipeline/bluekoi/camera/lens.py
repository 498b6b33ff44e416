"""Lens models of OpenCV, pinhole and fisheye, with an undistortion that is exact to rounding.

Camera frame: x right, y down, z forward. A pixel is a ray: a unit vector in the camera frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from ..data import Float

LENS_MODELS = ("pinhole", "fisheye")
"""Lens models of OpenCV."""
UNDISTORTION_TOLERANCE = 1e-10
"""Error of an undistorted point, in focal lengths, that counts as solved."""
RADIAL_TABLE_POINTS = 2001
"""Radii in the table that finds where a lens model stops being monotonic."""
MAX_RAY_TANGENT = 6.0
"""Largest tangent of the angle between ray and axis, for the pinhole model."""
MAX_RAY_ANGLE_RAD = np.pi
"""Largest angle between ray and axis, for the fisheye model."""


@dataclass(frozen=True)
class Lens:
    """One lens: model, matrix (3, 3) in px, distortion (k,), picture size (width, height) in px.

    pinhole: OpenCV's k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]]. fisheye: k1 k2 k3 k4.
    """

    model: str
    matrix: Float
    distortion: Float
    size_px: tuple[int, int]

    @cached_property
    def radial_table(self) -> tuple[Float, Float]:
        """Plane radii and their distorted images, both growing, up to the fold of the model."""
        widest = MAX_RAY_ANGLE_RAD if self.model == "fisheye" else MAX_RAY_TANGENT
        radius = np.linspace(0, widest, RADIAL_TABLE_POINTS)
        image = radius * radial_distortion_factor(self, radius**2)
        growing = np.diff(image) > 0
        end = len(growing) if np.all(growing) else int(np.argmin(growing))
        return radius[: end + 1], image[: end + 1]


def lens_parameters(lens: Lens) -> Float:
    """fx, fy, cx, cy and the distortion of a lens."""
    k = lens.matrix
    return np.concatenate([[k[0, 0], k[1, 1], k[0, 2], k[1, 2]], lens.distortion])


def lens_from_parameters(state: Float, model: str, size_px: tuple[int, int]) -> Lens:
    """Lens of parameters fx, fy, cx, cy and the distortion."""
    fx, fy, cx, cy = state[:4]
    return Lens(model, np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), state[4:], size_px)


def project_to_pixels(lens: Lens, points: Float) -> Float:
    """Pixels (n, 2) of points (n, 3) in the camera frame; NaN behind the lens or past its fold.

    pinhole: (x, y)/z, distorted. fisheye: r = theta (1 + k1 theta^2 + ... + k4 theta^8), theta the
    angle from the axis. Source: OpenCV, modules calib3d and fisheye.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    plane, seen = _plane_coordinates(lens, points)
    image = np.full((len(points), 2), np.nan)
    if np.any(seen):
        image[seen] = _plane_to_pixels(lens, distort_points(lens, plane[seen]))
    return image


def projection_derivatives(lens: Lens, points: Float) -> tuple[Float, Float]:
    """Derivatives (n, 2, 4 + k) of `project_to_pixels` by the lens's parameters and (n, 2, 3) by
    the points.

    By OpenCV, whose translation moves a point; 0 where a point is not seen.
    """
    fisheye, still = lens.model == "fisheye", np.zeros(3)
    project = cv2.fisheye.projectPoints if fisheye else cv2.projectPoints
    given = (points.reshape(-1, 1, 3), still, still, lens.matrix, lens.distortion)
    slopes = project(*given)[1].reshape(len(points), 2, -1)
    slopes[np.isnan(project_to_pixels(lens, points)).any(axis=1) | (points[:, 2] <= 0)] = 0.0
    if fisheye:  # columns: focal lengths, centre, distortion, rotation, translation, skew
        return slopes[:, :, :8], slopes[:, :, 11:14]
    # columns: rotation, translation, focal lengths, centre, distortion
    return slopes[:, :, 6:], slopes[:, :, 3:6]


def ray_directions(lens: Lens, uv_px: Float) -> Float:
    """Unit rays (n, 3) in the camera frame of pixels (n, 2); NaN where the model folds over.

    Newton's method on the distortion, from a table of its radial part, to 1e-10 of the focal
    length; OpenCV stops after 5 to 20 steps of a fixed-point iteration that may diverge.
    """
    target = _pixels_to_plane(lens, np.asarray(uv_px, dtype=float).reshape(-1, 2))
    plane = undistort_points(lens, target)
    radius = np.hypot(plane[:, 0], plane[:, 1])
    if lens.model == "fisheye":
        scale = np.sinc(radius / np.pi)
        return np.column_stack([plane * scale[:, None], np.cos(radius)])
    norm = np.sqrt(1 + radius**2)
    return np.column_stack([plane, np.ones(len(plane))]) / norm[:, None]


def undistort_points(lens: Lens, target: Float) -> Float:
    """Plane coordinates (n, 2) whose distorted image is `target` (n, 2); NaN where there is none.

    pinhole: tangents x/z, y/z. fisheye: angle from the axis times its direction.
    """
    plane = _undistort_by_radial_table(lens, target)
    limit = max_monotonic_radius(lens)
    for _ in range(20):
        image, slope = _distort_with_derivatives(lens, plane)
        error = image - target
        if not np.any(np.abs(error) > UNDISTORTION_TOLERANCE / 100):
            break
        plane = (
            plane
            - np.linalg.solve(_replace_singular_derivatives(slope), error[:, :, None])[:, :, 0]
        )
    error = np.abs(distort_points(lens, plane) - target).max(axis=1, initial=0.0)
    radius = np.hypot(plane[:, 0], plane[:, 1])
    bad = ~(error < UNDISTORTION_TOLERANCE) | (radius > limit)
    return np.where(bad[:, None], np.nan, plane)


def distort_points(lens: Lens, plane: Float) -> Float:
    """Distorted plane coordinates (n, 2) of `plane` (n, 2)."""
    if lens.model == "fisheye":
        return plane * _fisheye_radial_factor(lens.distortion, np.sum(plane**2, axis=1))[:, None]
    return _distort_by_opencv(lens, plane)[0]


def _distort_with_derivatives(lens: Lens, plane: Float) -> tuple[Float, Float]:
    """Distorted coordinates (n, 2) of `plane` (n, 2), and their derivative (n, 2, 2)."""
    if lens.model == "pinhole":
        return _distort_by_opencv(lens, plane)
    k, squared = lens.distortion, np.sum(plane**2, axis=1)
    gain = _fisheye_radial_factor(k, squared)[:, None, None]
    change = k[0] + squared * (2 * k[1] + squared * (3 * k[2] + squared * 4 * k[3]))
    outer = plane[:, :, None] * plane[:, None, :]
    return plane * gain[:, :, 0], gain * np.eye(2) + 2 * change[:, None, None] * outer


def _distort_by_opencv(lens: Lens, plane: Float) -> tuple[Float, Float]:
    """As `_distort_with_derivatives`, of a pinhole lens.

    At depth 1 the derivative by the camera's translation is that by the plane coordinates.
    """
    points = np.column_stack([plane, np.ones(len(plane))]).reshape(-1, 1, 3)
    still = np.zeros(3)
    image, jacobian = cv2.projectPoints(points, still, still, np.eye(3), lens.distortion)
    slope = np.asarray(jacobian, dtype=float).reshape(-1, 2, jacobian.shape[1])[:, :, 3:5]
    return np.asarray(image, dtype=float).reshape(-1, 2), slope


def max_monotonic_radius(lens: Lens) -> float:
    """Plane radius up to which the radial part grows: beyond it the model folds the picture over.

    pinhole: a tangent, searched up to 6. fisheye: an angle in rad, searched up to pi.
    """
    return float(lens.radial_table[0][-1])


def max_monotonic_radius_px(lens: Lens) -> float:
    """Distance from the image centre, in px, at which the lens model folds over."""
    return float(lens.radial_table[1][-1] * np.sqrt(lens.matrix[0, 0] * lens.matrix[1, 1]))


def _plane_coordinates(lens: Lens, points: Float) -> tuple[Float, np.ndarray]:
    depth = points[:, 2]
    across = np.hypot(points[:, 0], points[:, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        if lens.model == "fisheye":
            angle = np.arctan2(across, depth)
            gain = np.where(across > 0, angle / across, 1 / depth)
        else:
            gain = 1 / depth
        plane = points[:, :2] * gain[:, None]
        radius = np.hypot(plane[:, 0], plane[:, 1])
        seen = np.isfinite(radius) & (radius <= max_monotonic_radius(lens))
        if lens.model == "pinhole":
            seen &= depth > 0
    return plane, seen


def _fisheye_radial_factor(k: Float, squared: Float) -> Float:
    return 1 + squared * (k[0] + squared * (k[1] + squared * (k[2] + squared * k[3])))


def radial_distortion_factor(lens: Lens, squared: Float) -> Float:
    """Distorted over undistorted radius at squared plane radius, the radial part alone."""
    if lens.model == "fisheye":
        return _fisheye_radial_factor(lens.distortion, squared)
    k = np.zeros(8)
    k[: min(8, len(lens.distortion))] = lens.distortion[:8]
    above = 1 + squared * (k[0] + squared * (k[1] + squared * k[4]))
    below = 1 + squared * (k[5] + squared * (k[6] + squared * k[7]))
    return np.where(below > 0, above / np.where(below > 0, below, 1), -1.0)


def _undistort_by_radial_table(lens: Lens, target: Float) -> Float:
    radius, image = lens.radial_table
    wanted = np.hypot(target[:, 0], target[:, 1])
    found = np.interp(wanted, image, radius)
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(wanted > 0, found / wanted, 1.0)
    return target * gain[:, None]


def _replace_singular_derivatives(slope: Float) -> Float:
    """Derivatives (n, 2, 2) with 1 in the place of those that cannot be inverted."""
    usable = np.asarray(np.isfinite(slope).all(axis=(1, 2)))
    with np.errstate(over="ignore", invalid="ignore"):
        det = np.linalg.det(slope[usable])
    usable[usable] = np.isfinite(det) & (np.abs(det) > 1e-9)
    return np.where(usable[:, None, None], slope, np.eye(2))


def _plane_to_pixels(lens: Lens, plane: Float) -> Float:
    return plane @ lens.matrix[:2, :2].T + lens.matrix[:2, 2]


def _pixels_to_plane(lens: Lens, uv_px: Float) -> Float:
    plane = np.linalg.solve(lens.matrix[:2, :2], (uv_px - lens.matrix[:2, 2]).T).T
    return np.asarray(plane, dtype=np.float64)
