"""Residuals and normal equations of a bundle adjustment: one lens, the pose of every view."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from ..data import Float
from .boards import BoardView
from .lens import Lens, lens_from_parameters, project_to_pixels, projection_derivatives

PIXEL_OF_UNPROJECTED_CORNER = -3000.0
"""Image coordinate that stands for a corner which the lens model cannot project."""


@dataclass(frozen=True)
class StackedCorners:
    """All corners of all views: board_m (n, 3), image_px (n, 2), view (n,), each view's slice."""

    board_m: Float
    image_px: Float
    view: npt.NDArray[np.intp]
    slices: tuple[slice, ...]
    model: str
    size_px: tuple[int, int]


@dataclass(frozen=True)
class NormalEquations:
    """J'J of each view: lens (v, p, p), cross (v, p, 6), pose (v, 6, 6); J'r: the two rhs."""

    lens: Float
    cross: Float
    pose: Float
    lens_rhs: Float
    pose_rhs: Float


def gather_corners(lens: Lens, views: list[BoardView]) -> StackedCorners:
    """All corners of all views as arrays, for one kind of lens."""
    counts = [len(view.board_m) for view in views]
    return StackedCorners(
        board_m=np.concatenate([view.board_m for view in views]),
        image_px=np.concatenate([view.image_px for view in views]),
        view=np.repeat(np.arange(len(views)), counts),
        slices=tuple(slice(a, b) for a, b in pairwise(np.cumsum([0, *counts]))),
        model=lens.model,
        size_px=lens.size_px,
    )


def _corners_in_camera_frame(poses: Float, corners: StackedCorners) -> Float:
    """Corners (n, 3) in the camera frame."""
    rotations = Rotation.from_rotvec(poses[:, :3]).as_matrix()[corners.view]
    return np.einsum("nij,nj->ni", rotations, corners.board_m) + poses[corners.view, 3:]


def residuals_px(state: Float, poses: Float, corners: StackedCorners) -> Float:
    """Found minus modelled corner (n, 2), px."""
    image = project_to_pixels(
        lens_from_parameters(state, corners.model, corners.size_px),
        _corners_in_camera_frame(poses, corners),
    )
    return corners.image_px - np.nan_to_num(image, nan=PIXEL_OF_UNPROJECTED_CORNER)


def _projection_jacobian(state: Float, poses: Float, corners: StackedCorners) -> Float:
    """Derivative (n, 2, p + 6) of modelled corners by the lens and by their view's pose.

    d(R b)/dw = -R [b]x J_r(w), J_r(w) = I - (1 - cos t)/t^2 [w]x + (t - sin t)/t^3 [w]x^2, t = |w|:
    right Jacobian of SO(3).
    """
    lens, points = (
        lens_from_parameters(state, corners.model, corners.size_px),
        _corners_in_camera_frame(poses, corners),
    )
    by_lens, by_point = projection_derivatives(lens, points)
    rotations = Rotation.from_rotvec(poses[:, :3]).as_matrix()[corners.view]
    turning = (
        -rotations @ _cross_matrix(corners.board_m) @ _rotation_right_jacobians(poses)[corners.view]
    )
    return np.concatenate([by_lens, by_point @ turning, by_point], axis=2)


def _rotation_right_jacobians(poses: Float) -> Float:
    """J_r (v, 3, 3) of the rotation vectors in poses (v, 6)."""
    angle = np.maximum(np.linalg.norm(poses[:, :3], axis=1), 1e-6)[:, None, None]
    hat = _cross_matrix(poses[:, :3])
    first, second = (1 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    return np.asarray(np.eye(3) - first * hat + second * hat @ hat)


def _cross_matrix(vectors: Float) -> Float:
    """[a]x (n, 3, 3), so that [a]x b = a x b."""
    return np.cross(vectors[:, None], np.eye(3)[None]).swapaxes(1, 2)


def bundle_normal_equations(
    state: Float, poses: Float, corners: StackedCorners, residuals: Float
) -> NormalEquations:
    """Normal equations of each view at a lens (p,) and poses (views, 6)."""
    size, slope = len(state), _projection_jacobian(state, poses, corners)
    rows = [slope[part].reshape(-1, size + 6) for part in corners.slices]
    block = np.array([j.T @ j for j in rows])
    rhs = np.array(
        [j.T @ residuals[part].ravel() for j, part in zip(rows, corners.slices, strict=True)]
    )
    return NormalEquations(
        lens=block[:, :size, :size],
        cross=block[:, :size, size:],
        pose=block[:, size:, size:],
        lens_rhs=rhs[:, :size],
        pose_rhs=rhs[:, size:],
    )


def levenberg_marquardt_step(normal: NormalEquations, damping: float) -> tuple[Float, Float]:
    """Step of the lens (p,) and of the poses (v, 6), by the Schur complement of the pose blocks."""
    inverse = np.linalg.inv(_add_marquardt_damping(normal.pose, damping))
    gain = normal.cross @ inverse
    eliminated = np.sum(gain @ np.swapaxes(normal.cross, 1, 2), axis=0)
    reduced = _add_marquardt_damping(normal.lens.sum(axis=0)[None], damping)[0] - eliminated
    rhs = np.sum(normal.lens_rhs - (gain @ normal.pose_rhs[:, :, None])[:, :, 0], axis=0)
    step = _scaled_solve(reduced, rhs)
    pose_rhs = normal.pose_rhs - np.einsum("vpi,p->vi", normal.cross, step)
    return step, np.einsum("vij,vj->vi", inverse, pose_rhs)


def jackknife_lens_covariance(normal: NormalEquations) -> Float:
    """Covariance of the lens by leaving out one view at a time, to first order (CR3).

    d_v = (B - B_v)^-1 g_v, cov = (v - 1)/v sum d_v d_v', B the normal matrix with poses eliminated.
    A plain sandwich is too small by a third for a dozen views.
    """
    gain = normal.cross @ np.linalg.inv(_add_marquardt_damping(normal.pose, 1e-12))
    blocks = normal.lens - gain @ np.swapaxes(normal.cross, 1, 2)
    scores = normal.lens_rhs - (gain @ normal.pose_rhs[:, :, None])[:, :, 0]
    scale = 1 / np.sqrt(np.maximum(np.einsum("vii->i", blocks), 1e-30))
    scaled = blocks * np.outer(scale, scale)
    fewer = np.linalg.pinv(scaled.sum(axis=0) - scaled, hermitian=True)
    shifts = (fewer @ (scores * scale)[:, :, None])[:, :, 0] * scale
    return np.asarray(shifts.T @ shifts * (len(scores) - 1) / len(scores))


def _add_marquardt_damping(matrices: Float, damping: float) -> Float:
    diagonal = np.einsum("vii->vi", matrices)
    return matrices + (damping * diagonal + 1e-30)[:, :, None] * np.eye(matrices.shape[1])


def _scaled_solve(matrix: Float, rhs: Float) -> Float:
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    solution = np.linalg.lstsq(matrix * np.outer(scale, scale), rhs * scale, rcond=None)[0]
    return np.asarray(solution * scale)
