"""Pose of a lens from the images of four known marks (resection)."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from ..data import Float
from ..errors import input_error
from .lens import Lens, project_to_pixels, ray_directions
from .refraction import surface_points_of_light_paths

CORNER_NAMES = ("(0, 0)", "(length, 0)", "(length, width)", "(0, width)")
CORNER_REORDERING_ADVICE = {
    (1, 2, 3, 0): "begin with the corner now listed second and keep going round the same way",
    (3, 2, 1, 0): "list the four in reverse",
    (0, 3, 2, 1): "swap the second and the fourth",
}
"""Order in which corners may have been listed by mistake, and what to do about it."""
MAX_REPROJECTION_SHARE_OF_POOL_DIAGONAL = 0.015
"""Misfit of the corners, over the pool's diagonal in the picture, above which they are refused."""
POSE_DERIVATIVE_STEP = 1e-7
"""Step of the difference quotients with respect to the pose (rad, m)."""
SOLVER_TOLERANCES = {"ftol": 1e-12, "xtol": 1e-12, "gtol": 1e-12}
MAX_COST_OVER_BEST = 30.0
"""Starting poses whose cost is larger than this multiple of the least are dropped."""


def pose_from_marks(
    lens: Lens, corners_px: Float, corners_m: Float, index: float
) -> tuple[Float, Float, Float]:
    """Rotation (3, 3), translation (3,) and residuals (4, 2) px of the nearest pose.

    Both planar solutions (cv2.SOLVEPNP_IPPE) are refined by Levenberg-Marquardt on the pixels,
    refracted where the marks lie under water; the nearer one with the camera above wins.
    """
    rays = ray_directions(lens, corners_px)
    lost = np.flatnonzero(~np.isfinite(rays).all(axis=1) | (rays[:, 2] <= 0))
    if len(lost):
        raise _corner_outside_lens_error(corners_px, int(lost[0]))

    residuals = _reprojection_residuals_px(lens, corners_px, corners_m, index)
    starts = _starting_poses(rays[:, :2] / rays[:, 2:], corners_m)
    costs = [float(np.sum(residuals(start) ** 2)) for start in starts]
    likely = [s for s, c in zip(starts, costs, strict=True) if c <= MAX_COST_OVER_BEST * min(costs)]
    fits = [
        least_squares(residuals, start, method="lm", x_scale="jac", **SOLVER_TOLERANCES)
        for start in likely
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    turn, shift = Rotation.from_rotvec(best.x[:3]).as_matrix(), best.x[3:]
    return turn, shift, np.asarray(best.fun, dtype=np.float64).reshape(4, 2)


def gauss_newton_pose_update(
    lens: Lens, corners_px: Float, corners_m: Float, index: float, *, rotation: Float, translation:
    Float,
) -> tuple[Float, Float, Float]:  # fmt: skip
    """Rotation (3, 3), translation (3,), residuals (4, 2) px of the nearest pose to a first order.

    One Gauss-Newton step from the pose found for a lens and corners that hardly differ.
    """
    residuals_at = _reprojection_residuals_px(lens, corners_px, corners_m, index)
    state = np.concatenate([Rotation.from_matrix(rotation).as_rotvec(), translation])
    residuals = residuals_at(state)
    steps = np.eye(6) * POSE_DERIVATIVE_STEP
    slope = np.column_stack(
        [(residuals_at(state + step) - residuals) / POSE_DERIVATIVE_STEP for step in steps]
    )
    state = state - np.linalg.lstsq(slope, residuals, rcond=None)[0]
    turn = Rotation.from_rotvec(state[:3]).as_matrix()
    return turn, state[3:], residuals_at(state).reshape(4, 2)


def _reprojection_residuals_px(
    lens: Lens, corners_px: Float, corners_m: Float, index: float
) -> Callable[[Float], Float]:
    """Residuals (8,) px of the marks as a function of rotation vector and translation (6,)."""

    def residuals(parameters: Float) -> Float:
        turn = Rotation.from_rotvec(parameters[:3]).as_matrix()
        shift = parameters[3:]
        seen = surface_points_of_light_paths(-turn.T @ shift, corners_m, index)
        image = project_to_pixels(lens, seen @ turn.T + shift)
        return np.nan_to_num(corners_px - image, nan=1e4).ravel()

    return residuals


def pool_rectangle(length_m: float, width_m: float, height_m: float) -> Float:
    """The pool's corners (4, 3), m: (0, 0), (L, 0), (L, W), (0, W) at one height."""
    flat = [(0, 0), (length_m, 0), (length_m, width_m), (0, width_m)]
    return np.array([(x, y, height_m) for x, y in flat], dtype=float)


def corner_reordering_advice(lens: Lens, corners_px: Float, corners_m: Float, index: float) -> str:
    """Words for the order of corners that fits, or nothing where no order does."""
    limit = MAX_REPROJECTION_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(corners_px)
    for order, words in CORNER_REORDERING_ADVICE.items():
        turn, shift, residuals = pose_from_marks(lens, corners_px[list(order)], corners_m, index)
        above = (-turn.T @ shift)[2] > 0
        if above and rms_length_px(residuals) < limit / 2:
            return words
    return ""


def pool_diagonal_px(corners_px: Float) -> float:
    """Mean length of the pool's two diagonals in the picture, px."""
    return float(np.mean(np.linalg.norm(corners_px[:2] - corners_px[2:], axis=1)))


def rms_length_px(residuals_px: Float) -> float:
    """Root mean square length of residuals (n, 2), px."""
    return float(np.sqrt(np.mean(np.sum(residuals_px**2, axis=-1))))


def _starting_poses(plane: Float, corners_m: Float) -> list[Float]:
    """Starting poses (6,) = rotation vector, translation, with the camera above the water."""
    middle = corners_m.mean(axis=0)
    found = cv2.solvePnPGeneric(
        corners_m - middle, plane.reshape(-1, 1, 2), np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    starts = []
    for turn, shift in zip(found[1], found[2], strict=True):
        rotation = cv2.Rodrigues(turn)[0]
        moved = shift.ravel() - rotation @ middle
        if (-rotation.T @ moved)[2] > middle[2]:
            starts.append(np.concatenate([turn.ravel(), moved]))
    return starts or [_overhead_starting_pose(plane, corners_m)]


def _overhead_starting_pose(plane: Float, corners_m: Float) -> Float:
    """A camera that looks straight down from where the pool has its size: a last resort."""
    size = float(np.linalg.norm(corners_m[2] - corners_m[0]))
    height = size / max(1e-6, float(np.linalg.norm(plane[2] - plane[0])))
    rotation = np.diag([1.0, -1.0, -1.0])
    center = np.array([*corners_m[:, :2].mean(axis=0), height])
    return np.concatenate([Rotation.from_matrix(rotation).as_rotvec(), -rotation @ center])


def _corner_outside_lens_error(corners_px: Float, which: int) -> Exception:
    u, v = corners_px[which]
    return input_error(
        "study.yaml",
        "camera.pool_corners_px",
        f"corner {CORNER_NAMES[which]} at ({u:g}, {v:g}) px, outside what the lens model can map",
        "corners where the distortion still grows outwards",
        "Check camera.model and camera.distortion, or calibrate with boards near the corners.",
    )
