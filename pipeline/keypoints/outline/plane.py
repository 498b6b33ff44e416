"""The plane that the robot swims in, as seen: metres to pixels and back, smooth and fast.

Only the template's scale and shape depend on it; keypoints leave in raw pixels.
Coordinates: pool frame, x and y in m, at the keypoints' depth under the still water.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numba
import numpy as np
import numpy.typing as npt

from ...study import Camera, Setup

Float = npt.NDArray[np.float64]
DEGREES = (5, 7, 9, 11)
"""Tried in turn: a lens that draws straight lines straight needs 5, a wide one 9 or 11."""
NEAR_PX = 0.05
MARGIN = 0.12
GRID = 17


@dataclass(frozen=True)
class Plane:
    """Polynomials both ways: coefficients (2, degree + 1, degree + 1) of scaled coordinates.

    centre_m, half_m: scaling of the plane's coordinates; centre_px, half_px: of the picture's.
    corners_px: (4, 2) of the pool; px_per_m at the pool's middle.
    """

    to_px: Float
    to_m: Float
    scale_m: Float
    scale_px: Float
    corners_px: Float
    px_per_m: float

    def pixels(self, xy_m: Float) -> Float:
        """(n, 2) pixels of points (n, 2) m."""
        return evaluate(self.to_px, self.scale_m, np.ascontiguousarray(xy_m, dtype=float))

    def metres(self, uv_px: Float) -> Float:
        """(n, 2) m of pixels (n, 2)."""
        return evaluate(self.to_m, self.scale_px, np.ascontiguousarray(uv_px, dtype=float))


def plane_of(setup: Setup) -> Plane:
    """Plane at the keypoints' depth from lens and pool corners; at the marks without a lens."""
    pool = setup.pool
    xy = _grid(setup, GRID)
    uv = _seen(setup, xy)
    scale_m, scale_px = _scaling(xy), _scaling(uv)
    to_px = _near_enough(setup, (xy, uv), scale_m)
    middle = np.array([[0.5 * pool.length_m, 0.5 * pool.width_m]])
    beside = middle + np.array([0.05, 0.0])
    step = evaluate(to_px, scale_m, beside) - evaluate(to_px, scale_m, middle)
    return Plane(
        to_px=to_px,
        to_m=_fit(uv, xy, scale_px, to_px.shape[1] - 1),
        scale_m=scale_m,
        scale_px=scale_px,
        corners_px=np.array(setup.camera.pool_corners_px, dtype=float),
        px_per_m=float(np.hypot(*step[0]) / 0.05),
    )


def _grid(setup: Setup, count: int) -> Float:
    """Places (count^2, 2) all over the pool and a little beyond, m."""
    x, y = (np.linspace(-MARGIN, 1 + MARGIN, count) * side
            for side in (setup.pool.length_m, setup.pool.width_m))  # fmt: skip
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def _near_enough(setup: Setup, pairs: tuple[Float, Float], scale: Float) -> Float:
    """Coefficients of the least degree that comes within `NEAR_PX` between the nodes."""
    between = _grid(setup, 2 * GRID)
    inside = np.all((between > 0) & (between < [setup.pool.length_m, setup.pool.width_m]), axis=1)
    seen = _seen(setup, between[inside])
    for degree in DEGREES:
        found = _fit(*pairs, scale, degree)
        if np.abs(evaluate(found, scale, between[inside]) - seen).max() < NEAR_PX:
            break
    return found


def _scaling(points: Float) -> Float:
    """Rows centre and half extent that bring points to [-1, 1]."""
    low, high = points.min(axis=0), points.max(axis=0)
    return np.array([(low + high) / 2, (high - low) / 2])


def _fit(source: Float, target: Float, scale: Float, degree: int) -> Float:
    """Polynomial coefficients (2, d + 1, d + 1), least squares."""
    scaled = (source - scale[0]) / scale[1]
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    terms = np.stack([scaled[:, 0] ** i * scaled[:, 1] ** j for i, j in powers], axis=1)
    solved = np.linalg.lstsq(terms, target, rcond=None)[0]
    coefficients = np.zeros((2, degree + 1, degree + 1))
    for row, (i, j) in enumerate(powers):
        coefficients[:, i, j] = solved[row]
    return coefficients


@numba.njit(cache=True)
def evaluate(coefficients: Float, scale: Float, points: Float) -> Float:
    """Polynomial of coefficients (2, d + 1, d + 1) at points (n, 2), by Horner's rule."""
    degree = coefficients.shape[1] - 1
    out = np.empty((points.shape[0], 2))
    for k in range(points.shape[0]):
        x = (points[k, 0] - scale[0, 0]) / scale[1, 0]
        y = (points[k, 1] - scale[0, 1]) / scale[1, 1]
        for c in range(2):
            total = 0.0
            for i in range(degree, -1, -1):
                inner = 0.0
                for j in range(degree - i, -1, -1):
                    inner = inner * y + coefficients[c, i, j]
                total = total * x + inner
            out[k, c] = total
    return out


def _seen(setup: Setup, xy: Float) -> Float:
    """Pixels of points (n, 2) m at the keypoints' depth."""
    pool, camera = setup.pool, setup.camera
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * [pool.length_m, pool.width_m]
    marks = np.array(camera.pool_corners_px, dtype=float)
    if camera.matrix is None:
        direct = cv2.getPerspectiveTransform(corners.astype(np.float32), marks.astype(np.float32))
        return cv2.perspectiveTransform(xy[:, None], direct)[:, 0]
    turn, shift = _pose(camera, corners, marks)
    eye = -turn.T @ shift
    height = eye[2]
    surface = _surface(
        xy, eye[:2], height, (setup.robot.keypoint_depth_m, setup.water.refractive_index)
    )
    inside = np.column_stack([surface, np.zeros(len(surface))]) @ turn.T + shift
    return _lens(camera, inside)


def _surface(xy: Float, foot: Float, height: float, water: tuple[float, float]) -> Float:
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


def _pose(camera: Camera, corners: Float, marks: Float) -> tuple[Float, Float]:
    """Rotation and shift pool to camera of the straightened corners."""
    matrix, distortion = np.array(camera.matrix), np.array(camera.distortion or (0.0,) * 4)
    straighten = cv2.fisheye.undistortPoints if camera.model == "fisheye" else cv2.undistortPoints
    flat = straighten(marks[:, None], matrix, distortion)[:, 0]
    points = np.column_stack([corners, np.full(4, camera.pool_corners_height_m)])
    _, turn, shift = cv2.solvePnP(points, flat, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE)
    turn, shift = cv2.solvePnPRefineLM(points, flat, np.eye(3), None, turn, shift)
    return cv2.Rodrigues(turn)[0], shift[:, 0]


def _lens(camera: Camera, inside: Float) -> Float:
    """Pixels of points (n, 3) in the camera's axes."""
    matrix, distortion = np.array(camera.matrix), np.array(camera.distortion or (0.0,) * 4)
    none = np.zeros(3)
    points = inside[:, None]
    if camera.model == "fisheye":
        return cv2.fisheye.projectPoints(points, none, none, matrix, distortion)[0][:, 0]
    return cv2.projectPoints(points, none, none, matrix, distortion)[0][:, 0]
