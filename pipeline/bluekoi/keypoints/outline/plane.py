"""The plane that the robot swims in, as seen: body lengths to pixels and back, smooth and fast.

Only the template's scale and shape depend on it; keypoints leave in raw pixels.
Coordinates: pool frame, x and y in body lengths (`robot.body_length_m`), at the keypoints' depth
under the still water. So detection does not depend on the metric scale of a study.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...data import Float
from ...numba_settings import njit
from ...study import Camera, Robot, StudySettings

POLYNOMIAL_DEGREES = (5, 7, 9, 11)
"""Tried in turn: a lens that draws straight lines straight needs 5, a wide one 9 or 11."""
MAX_POLYNOMIAL_ERROR_PX = 0.05
POOL_MARGIN_SHARE = 0.12
GRID_POINTS_PER_SIDE = 17


@dataclass(frozen=True)
class SwimmingPlaneMap:
    """Polynomials both ways: coefficients (2, degree + 1, degree + 1) of scaled coordinates.

    scale_bl, scale_px: centre and half extent (2, 2) of the plane's and the picture's coordinates.
    corners_px: (4, 2) of the pool; px_per_bl: pixels per body length at the pool's middle.
    """

    to_px: Float
    to_bl: Float
    scale_bl: Float
    scale_px: Float
    corners_px: Float
    px_per_bl: float

    @property
    def shorter_pool_side_px(self) -> float:
        """Mean length of the pool's shorter sides in the picture, px."""
        sides = np.hypot(*(np.roll(self.corners_px, -1, axis=0) - self.corners_px).T)
        return float(min(sides[[0, 2]].mean(), sides[[1, 3]].mean()))

    def body_lengths_to_pixels(self, xy_bl: Float) -> Float:
        """(n, 2) pixels of points (n, 2) in body lengths."""
        return evaluate_polynomial(
            self.to_px, self.scale_bl, np.ascontiguousarray(xy_bl, dtype=float)
        )

    def pixels_to_body_lengths(self, uv_px: Float) -> Float:
        """(n, 2) body lengths of pixels (n, 2)."""
        return evaluate_polynomial(
            self.to_bl, self.scale_px, np.ascontiguousarray(uv_px, dtype=float)
        )


def metres_to_body_lengths(robot: Robot, length_m: float) -> float:
    """A length in body lengths, rounded so that the metric scale of a study leaves no trace."""
    return round(length_m / robot.body_length_m, 12)


def swimming_plane_map(setup: StudySettings) -> SwimmingPlaneMap:
    """Plane at the keypoints' depth from lens and pool corners; at the marks without a lens."""
    sides = np.array([metres_to_body_lengths(setup.robot, side)
                      for side in (setup.pool.length_m, setup.pool.width_m)])  # fmt: skip
    xy = _pool_grid_bl(sides, GRID_POINTS_PER_SIDE)
    uv = _project_to_pixels(setup, sides, xy)
    scale_bl, scale_px = _centre_and_half_extent(xy), _centre_and_half_extent(uv)
    between = _pool_grid_bl(sides, 2 * GRID_POINTS_PER_SIDE)
    between = between[np.all((between > 0) & (between < sides), axis=1)]
    seen = _project_to_pixels(setup, sides, between)
    for degree in POLYNOMIAL_DEGREES:
        to_px = _fit_polynomial(xy, uv, scale_bl, degree)
        if (
            np.abs(evaluate_polynomial(to_px, scale_bl, between) - seen).max()
            < MAX_POLYNOMIAL_ERROR_PX
        ):
            break
    step = 0.02 * sides[0]
    ends = evaluate_polynomial(to_px, scale_bl, 0.5 * sides + np.array([[0.0, 0.0], [step, 0.0]]))
    return SwimmingPlaneMap(
        to_px=to_px,
        to_bl=_fit_polynomial(uv, xy, scale_px, degree),
        scale_bl=scale_bl,
        scale_px=scale_px,
        corners_px=np.array(setup.camera.pool_corners_px, dtype=float),
        px_per_bl=float(np.hypot(*(ends[1] - ends[0])) / step),
    )


def _pool_grid_bl(sides: Float, count: int) -> Float:
    """Places (count^2, 2) all over the pool and a little beyond, body lengths."""
    shares = np.linspace(-POOL_MARGIN_SHARE, 1 + POOL_MARGIN_SHARE, count)
    return np.stack(np.meshgrid(shares, shares), axis=-1).reshape(-1, 2) * sides


def _centre_and_half_extent(points: Float) -> Float:
    """Rows centre and half extent that bring points to [-1, 1]."""
    low, high = points.min(axis=0), points.max(axis=0)
    return np.array([(low + high) / 2, (high - low) / 2])


def _fit_polynomial(source: Float, target: Float, scale: Float, degree: int) -> Float:
    """Polynomial coefficients (2, d + 1, d + 1), least squares."""
    scaled = (source - scale[0]) / scale[1]
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    terms = np.stack([scaled[:, 0] ** i * scaled[:, 1] ** j for i, j in powers], axis=1)
    solved = np.linalg.lstsq(terms, target, rcond=None)[0]
    coefficients = np.zeros((2, degree + 1, degree + 1))
    for row, (i, j) in enumerate(powers):
        coefficients[:, i, j] = solved[row]
    return coefficients


@njit(cache=True, error_model="numpy")
def horner(coefficients: Float, scale: Float, px: float, py: float) -> tuple[float, float]:
    """Polynomials of coefficients (2, d + 1, d + 1) at one point, by Horner's rule."""
    degree = coefficients.shape[1] - 1
    x = (px - scale[0, 0]) / scale[1, 0]
    y = (py - scale[0, 1]) / scale[1, 1]
    u, v = 0.0, 0.0
    for i in range(degree, -1, -1):
        inner_u, inner_v = 0.0, 0.0
        for j in range(degree - i, -1, -1):
            inner_u = inner_u * y + coefficients[0, i, j]
            inner_v = inner_v * y + coefficients[1, i, j]
        u = u * x + inner_u
        v = v * x + inner_v
    return u, v


@njit(cache=True, error_model="numpy")
def evaluate_polynomial(coefficients: Float, scale: Float, points: Float) -> Float:
    """As `horner`, at points (n, 2)."""
    out = np.empty((points.shape[0], 2))
    for k in range(points.shape[0]):
        out[k, 0], out[k, 1] = horner(coefficients, scale, points[k, 0], points[k, 1])
    return out


def _project_to_pixels(setup: StudySettings, sides: Float, xy: Float) -> Float:
    """Pixels of points (n, 2) [body lengths] at the keypoints' depth; sides (2,) of the pool."""
    camera = setup.camera
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * sides
    marks = np.array(camera.pool_corners_px, dtype=float)
    if camera.matrix is None:
        direct = cv2.getPerspectiveTransform(corners.astype(np.float32), marks.astype(np.float32))
        return cv2.perspectiveTransform(xy[:, None], direct)[:, 0]
    marks_bl = metres_to_body_lengths(setup.robot, camera.pool_corners_height_m)
    turn, shift = _camera_rotation_and_shift(
        camera, np.column_stack([corners, np.full(4, marks_bl)]), marks
    )
    eye = -turn.T @ shift
    depth_bl = metres_to_body_lengths(setup.robot, setup.robot.keypoint_depth_m)
    surface = _surface_crossing_points(
        xy, eye[:2], eye[2], (depth_bl, setup.water.refractive_index)
    )
    inside = np.column_stack([surface, np.zeros(len(surface))]) @ turn.T + shift
    return _apply_lens(camera, inside)


def _surface_crossing_points(
    xy: Float, foot: Float, height: float, water: tuple[float, float]
) -> Float:
    """Where on the surface (n, 2) the ray from a point at depth leaves towards the camera."""
    depth, index = water
    offset = xy - foot
    reach = np.maximum(np.hypot(*offset.T), 1e-12)
    out = reach * height / (height + depth / index)
    for _ in range(6):
        above, below = np.hypot(out, height), np.hypot(reach - out, depth)
        error = out / above - index * (reach - out) / np.maximum(below, 1e-12)
        slope = height**2 / above**3 + index * depth**2 / np.maximum(below, 1e-12) ** 3
        out = np.clip(out - error / np.maximum(slope, 1e-9), 0.0, reach)
    return foot + offset * (out / reach)[:, None]


def _camera_rotation_and_shift(camera: Camera, corners: Float, marks: Float) -> tuple[Float, Float]:
    """Rotation and shift pool to camera from corners (4, 3) and their marks (4, 2) px."""
    matrix, distortion = np.array(camera.matrix), np.array(camera.distortion or (0.0,) * 4)
    straighten = cv2.fisheye.undistortPoints if camera.model == "fisheye" else cv2.undistortPoints
    flat = straighten(marks[:, None], matrix, distortion)[:, 0]
    _, turn, shift = cv2.solvePnP(corners, flat, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE)
    turn, shift = cv2.solvePnPRefineLM(corners, flat, np.eye(3), None, turn, shift)
    return cv2.Rodrigues(turn)[0], shift[:, 0]


def _apply_lens(camera: Camera, inside: Float) -> Float:
    """Pixels of points (n, 3) in the camera's axes."""
    matrix, distortion = np.array(camera.matrix), np.array(camera.distortion or (0.0,) * 4)
    none = np.zeros(3)
    points = inside[:, None]
    if camera.model == "fisheye":
        return cv2.fisheye.projectPoints(points, none, none, matrix, distortion)[0][:, 0]
    return cv2.projectPoints(points, none, none, matrix, distortion)[0][:, 0]
