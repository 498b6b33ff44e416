"""Lens models compared on held-out views, and the reasons that refuse a calibration."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ..data import Float
from .boards import BoardView
from .image_circle import ImageCircle
from .lens import Lens, lens_parameters, max_monotonic_radius, max_monotonic_radius_px
from .lens_bundle_adjustment import LensFit, bundle_adjustment, fit_lens, held_out_residuals, rms_px
from .opencv_comparison import opencv_lens

MODELS_COMPARED = (("pinhole", 4), ("pinhole", 5), ("fisheye", 4), ("pinhole", 8))
"""Lens models with the number of their distortion coefficients."""
CROSS_VALIDATION_FOLDS = 5
"""Parts of the views, each left out of the fit once."""
MIN_BOARD_VIEWS = 8
"""Views without which no lens is calibrated."""
MAX_FX_FY_DIFFERENCE_SHARE = 0.05
"""Relative difference of fx and fy above which the input cannot be right."""
MAX_PRINCIPAL_POINT_OFFSET_SHARE = 0.10
"""Distance of the principal point from the middle of the picture, over its size."""
MAX_CORNER_RMS_SHARE_OF_WIDTH = 1 / 1280
"""Reprojection error over the picture's width, up to which a lens is accepted and no view is an
outlier."""
MIN_BOARD_TILT_DEG = 15.0
"""Tilt of the board below which a view counts as frontal."""
MIN_TILTED_VIEWS = 3
"""Views with a larger tilt, without which the focal length is not determined."""
MAX_RELATIVE_FOCAL_STD = 0.02
"""Relative standard deviation of the focal length that is accepted."""
OUTLIER_VIEW_RMS_OVER_MEDIAN = 4.0
"""Error of a view over the median of all, above which the view is left out."""
SIMPLER_MODEL_MAX_ERROR_RATIO = 1.01
"""Held-out error over the least one, up to which the model with fewer coefficients is taken."""
COVERAGE_GRID_CELLS = (8, 6)
"""Cells of the picture (columns, rows) in which corners are counted."""


@dataclass(frozen=True)
class LensCandidate:
    """One lens model's fit, its held-out error, and the reasons that refuse it (if any)."""

    model: str
    terms: int
    fit: LensFit
    views: tuple[BoardView, ...]
    left_out: tuple[str, ...]
    held_out_px: float
    implausibilities: tuple[str, ...]

    @property
    def label(self) -> str:
        """Model and number of distortion coefficients."""
        return f"{self.model}, {self.terms} coefficients"


def fit_lens_candidate(
    views: list[BoardView], model: str, terms: int, size_px: tuple[int, int], *,
    circle: ImageCircle | None = None, simpler: Sequence[Lens] = (),
) -> LensCandidate:  # fmt: skip
    """One model fitted to the views, without gross outliers, with its held-out error.

    simpler: fits of the same model with fewer coefficients, to start from. Raises ValueError where
    no start suits the model.
    """
    fit = fit_lens(views, model, terms, size_px, simpler)
    errors = np.array([rms_px([r]) for r in fit.residuals])
    limit = max(
        OUTLIER_VIEW_RMS_OVER_MEDIAN * float(np.median(errors)),
        size_px[0] * MAX_CORNER_RMS_SHARE_OF_WIDTH,
    )
    left_out = [f"{v.name} ({e:.1f} px)" for v, e in zip(views, errors, strict=True) if e > limit]
    if left_out and np.sum(errors <= limit) >= MIN_BOARD_VIEWS:
        views = [v for v, e in zip(views, errors, strict=True) if e <= limit]
        fit = fit_lens(views, model, terms, size_px, [*simpler, fit.lens])
    else:
        left_out = []
    held_out = held_out_rms(views, lambda kept: _refit_lens_to_views(fit, views, kept))
    reasons = tuple(lens_fit_refusal_reasons(fit, size_px, circle))
    return LensCandidate(model, terms, fit, tuple(views), tuple(left_out), held_out, reasons)


def _refit_lens_to_views(fit: LensFit, views: list[BoardView], kept: list[int]) -> Lens:
    return bundle_adjustment(
        fit.lens, fit.poses[kept], [views[i] for i in kept], iterations=15
    ).lens


def held_out_rms(
    views: Sequence[BoardView], lens_from: Callable[[list[int]], Lens | None]
) -> float:
    """Corner error, px rms, of views whose lens was fitted without them, over five folds.

    lens_from: lens fitted to the views of the given numbers. Infinite where a fold has no lens.
    """
    residuals = []
    folds = min(CROSS_VALIDATION_FOLDS, len(views))
    for fold in range(folds):
        kept = [i for i in range(len(views)) if i % folds != fold]
        lens = lens_from(kept) if kept else None
        if lens is None:
            return float("inf")
        try:
            residuals += held_out_residuals(lens, list(views[fold::folds]))
        except ValueError:
            return float("inf")
    return rms_px(residuals)


def opencv_held_out_rms(best: LensCandidate, size_px: tuple[int, int]) -> float:
    """Held-out error, px rms, of OpenCV's calibration: same model, same views, same folds."""
    return held_out_rms(
        best.views,
        lambda kept: opencv_lens([best.views[i] for i in kept], best.model, best.terms, size_px),
    )


def select_lens(candidates: list[LensCandidate]) -> LensCandidate | None:
    """The model with the least held-out error of those not refused; a simpler one within 1 %."""
    accepted = [c for c in candidates if not c.implausibilities]
    if not accepted:
        return None
    least = min(c.held_out_px for c in accepted)
    close = [c for c in accepted if c.held_out_px <= SIMPLER_MODEL_MAX_ERROR_RATIO * least]
    return min(close, key=lambda c: (c.terms, c.held_out_px))


def lens_fit_refusal_reasons(
    fit: LensFit, size_px: tuple[int, int], circle: ImageCircle | None = None
) -> list[str]:
    """Reasons why this lens cannot be right; empty where there are none."""
    std = np.sqrt(np.diag(fit.lens_cov))[:2] / lens_parameters(fit.lens)[:2]
    tilts = board_tilts_deg(fit.poses)
    tilted = int(np.sum(tilts > MIN_BOARD_TILT_DEG))
    checks = {
        too_few_views_reason(len(fit.poses)): len(fit.poses) < MIN_BOARD_VIEWS,
        f"the boards are seen frontally: {tilted} of {len(tilts)} tilted by more than "
        f"{MIN_BOARD_TILT_DEG:.0f} degrees, which leaves the focal length open": tilted
        < MIN_TILTED_VIEWS,
        f"the focal length is known to {100 * max(std):.1f} % only": max(std)
        > MAX_RELATIVE_FOCAL_STD,
    }
    found = [reason for reason, applies in checks.items() if applies]
    return [*found, *lens_implausibilities(fit.lens, size_px, fit.rms_px, circle)]


def too_few_views_reason(views: int) -> str:
    """The reason that refuses a calibration from so few views."""
    return f"only {views} view{'' if views == 1 else 's'}; at least {MIN_BOARD_VIEWS} are needed"


def lens_implausibilities(
    lens: Lens, size_px: tuple[int, int], corner_rms_px: float, circle: ImageCircle | None = None
) -> list[str]:
    """Reasons why a lens with this corner error (NaN: not known) cannot be right.

    The projection must be monotonic wherever a corner can be: inside the image circle, else inside
    the picture.
    """
    fx, fy, cx, cy = lens_parameters(lens)[:4]
    if not (np.isfinite([*lens.matrix.ravel(), *lens.distortion]).all() and min(fx, fy) > 0):
        return ["focal lengths, centre and distortion are not all numbers, or not above 0"]
    width, height = size_px
    u, v = circle.center_px if circle else ((width - 1) / 2, (height - 1) / 2)
    across, down = (2 * circle.radius_px,) * 2 if circle else (width, height)
    offset = max(abs(cx - u) / across, abs(cy - v) / down)
    limit = width * MAX_CORNER_RMS_SHARE_OF_WIDTH
    where = "image circle" if circle else "picture"
    checks = {
        f"focal lengths fx {fx:.0f} and fy {fy:.0f} lie more than 5 % apart": abs(fx / fy - 1)
        > MAX_FX_FY_DIFFERENCE_SHARE,
        f"the optical centre ({cx:.0f}, {cy:.0f}) lies {100 * offset:.0f} % off the middle of the "
        f"{where}": offset > MAX_PRINCIPAL_POINT_OFFSET_SHARE,
        f"the distortion is not monotonic inside the {where}: it folds over "
        f"{max_monotonic_radius_px(lens):.0f} px from the centre": has_distortion_fold_in_image(
            lens, circle
        ),
        f"corners miss by {corner_rms_px:.2f} px rms, more than {limit:.2f}": corner_rms_px > limit,
    }
    return [reason for reason, applies in checks.items() if applies]


def has_distortion_fold_in_image(lens: Lens, circle: ImageCircle | None = None) -> bool:
    """Whether the projection stops growing where a corner can be.

    That is inside the image circle. Where none is known: inside the picture, and within 90 degrees
    of the axis of a fisheye, since a camera above a pool sees no corner beyond.
    """
    width, height = lens.size_px
    cx, cy = lens.matrix[:2, 2]
    farthest = float(np.hypot(max(cx, width - cx), max(cy, height - cy)))
    if circle:
        return max_monotonic_radius_px(lens) < min(farthest, circle.max_distance_px(cx, cy))
    beyond_horizon = lens.model == "fisheye" and max_monotonic_radius(lens) > np.pi / 2
    return max_monotonic_radius_px(lens) < farthest and not beyond_horizon


def board_tilts_deg(poses: Float) -> Float:
    """Angle of each board (views,) against the picture plane, degrees."""
    normals = Rotation.from_rotvec(poses[:, :3]).as_matrix()[:, :, 2]
    return np.degrees(np.arccos(np.clip(np.abs(normals[:, 2]), 0, 1)))


def image_coverage(
    views: Sequence[BoardView], size_px: tuple[int, int], circle: ImageCircle | None = None
) -> float:
    """Share of an 8 x 6 grid over the picture, or the image circle, with a corner of some view."""
    points = np.concatenate([view.image_px for view in views])
    low, side = np.zeros(2), np.array(size_px, dtype=float)
    if circle:
        low, side = np.array(circle.center_px) - circle.radius_px, np.full(2, 2 * circle.radius_px)
    cells = np.floor((points - low) / side * COVERAGE_GRID_CELLS).astype(int)
    grid = np.indices(COVERAGE_GRID_CELLS).reshape(2, -1).T
    usable = grid[np.hypot(*((grid + 0.5) / COVERAGE_GRID_CELLS - 0.5).T) < 0.5] if circle else grid
    covered = {tuple(cell) for cell in cells} & {tuple(cell) for cell in usable}
    return len(covered) / len(usable)
