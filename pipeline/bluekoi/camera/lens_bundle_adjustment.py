"""Bundle adjustment of a lens and the pose of every view of a board."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import least_squares

from ..data import Float
from .boards import BoardView
from .bundle_equations import (
    bundle_normal_equations,
    gather_corners,
    jackknife_lens_covariance,
    levenberg_marquardt_step,
    residuals_px,
)
from .lens import Lens, lens_from_parameters, lens_parameters, ray_directions

START_FOCAL_LENGTHS_IN_WIDTHS = (0.2, 0.3, 0.45, 0.65, 0.95, 1.4, 2.1)
"""Starting focal lengths over the picture's width: circular fisheye to telephoto."""
MIN_AXIS_COSINE = 0.05
"""Smallest cosine between a ray and the optical axis with which a corner helps to start a pose."""
MAX_BUNDLE_ITERATIONS = 60
"""Levenberg-Marquardt steps of the bundle adjustment."""
MIN_RELATIVE_COST_DECREASE = 1e-9
"""Relative decrease of the cost below which the adjustment has converged."""


@dataclass(frozen=True)
class LensFit:
    """A lens with poses (views, 6), residuals of each view (n, 2) px and covariance of the lens.

    lens_cov: (4 + k, 4 + k) of fx, fy, cx, cy and the distortion, views taken as independent and
    corners of one view as not (first-order jackknife over views).
    """

    lens: Lens
    poses: Float
    residuals: tuple[Float, ...]
    lens_cov: Float

    @property
    def rms_px(self) -> float:
        """Root mean square distance between found and modelled corners, px."""
        return rms_px(self.residuals)


def rms_px(residuals: Sequence[Float]) -> float:
    """Root mean square length of residuals, (n, 2) px of each view."""
    return float(np.sqrt(np.mean(np.concatenate(residuals) ** 2) * 2))


def fit_lens(
    views: list[BoardView], model: str, terms: int, size_px: tuple[int, int],
    starts: Iterable[Lens] = (),
) -> LensFit:  # fmt: skip
    """Lens and poses with the least squared corner error over all starts, each refined fully.

    terms: number of distortion coefficients. starts: lenses with fewer coefficients; the fit is
    never worse than any of them. Raises ValueError where no start gives every view a pose.
    """
    fits = [
        bundle_adjustment(lens, poses, views)
        for lens in _starting_lenses(model, terms, size_px, starts)
        if (poses := starting_poses(lens, views)) is not None
    ]
    if not fits:
        raise ValueError(f"no starting focal length suits the {model} model")
    return min(fits, key=lambda fit: fit.rms_px)


def _starting_lenses(
    model: str, terms: int, size_px: tuple[int, int], starts: Iterable[Lens]
) -> Iterator[Lens]:
    for simpler in starts:
        padded = np.append(simpler.distortion, np.zeros(terms - len(simpler.distortion)))
        yield Lens(model, simpler.matrix, padded, size_px)
    centre = (np.array(size_px) - 1) / 2
    for focal in np.array(START_FOCAL_LENGTHS_IN_WIDTHS) * size_px[0]:
        yield lens_from_parameters(
            np.array([focal, focal, *centre, *np.zeros(terms)]), model, size_px
        )


def bundle_adjustment(
    lens: Lens, poses: Float, views: list[BoardView], *, iterations: int = MAX_BUNDLE_ITERATIONS
) -> LensFit:
    """Levenberg-Marquardt over lens and poses (views, 6).

    Each view's pose is eliminated from the normal equations (arrow matrix), so the cost grows
    with the number of views, not its cube.
    """
    state, damping, corners = lens_parameters(lens), 1e-3, gather_corners(lens, views)
    residuals = residuals_px(state, poses, corners)
    for _ in range(iterations):
        normal = bundle_normal_equations(state, poses, corners, residuals)
        while damping < 1e12:
            lens_step, pose_steps = levenberg_marquardt_step(normal, damping)
            trial = residuals_px(state + lens_step, poses + pose_steps, corners)
            if np.sum(trial**2) < np.sum(residuals**2):
                break
            damping *= 8
        else:
            break
        gain = 1 - np.sum(trial**2) / np.sum(residuals**2)
        state, poses, residuals = state + lens_step, poses + pose_steps, trial
        damping /= 10
        if gain < MIN_RELATIVE_COST_DECREASE:
            break
    lens_cov = jackknife_lens_covariance(bundle_normal_equations(state, poses, corners, residuals))
    by_view = tuple(residuals[part] for part in corners.slices)
    return LensFit(lens_from_parameters(state, lens.model, lens.size_px), poses, by_view, lens_cov)


def held_out_residuals(lens: Lens, views: list[BoardView]) -> list[Float]:
    """Residuals (n, 2) px of each view after fitting its pose alone, the lens held fixed.

    Raises ValueError where a view lies outside the lens model.
    """
    poses = starting_poses(lens, views)
    if poses is None:
        raise ValueError("a held-out view lies outside the lens model")
    state = lens_parameters(lens)

    def fitted(view: BoardView, pose: Float) -> Float:
        corners = gather_corners(lens, [view])
        found = least_squares(
            lambda p: residuals_px(state, p[None], corners).ravel(),
            pose,
            method="lm",
            x_scale="jac",
        )
        return np.asarray(found.fun, dtype=np.float64).reshape(-1, 2)

    return [fitted(view, pose) for view, pose in zip(views, poses, strict=True)]


def starting_poses(lens: Lens, views: list[BoardView]) -> Float | None:
    """Rotation vector and translation (views, 6), or None where a view has no six usable rays."""
    poses = []
    for view in views:
        rays = ray_directions(lens, view.image_px)
        good = rays[:, 2] > MIN_AXIS_COSINE
        if good.sum() < 6:
            return None
        plane = (rays[good, :2] / rays[good, 2:]).reshape(-1, 1, 2)
        _, rotation, translation = cv2.solvePnP(
            view.board_m[good], plane, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
        )
        poses.append(np.concatenate([rotation.ravel(), translation.ravel()]))
    return np.array(poses)
