"""Which lens model to believe, judged on views held out, and what makes a calibration refused."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ..data import Float
from .boards import View
from .bundle import Fitted, adjust, fit_lens, parameters, place_views
from .lens import Lens, fold_radius_px

CANDIDATES = (("pinhole", 4), ("pinhole", 5), ("fisheye", 4), ("pinhole", 8))
FOLDS = 5
FEWEST_VIEWS = 8
FOCAL_APART = 0.05
CENTRE_OFF = 0.10
LARGEST_RMS_SHARE = 1 / 1280
FRONTAL_DEG = 15.0
FEWEST_TILTED = 3
FOCAL_STD = 0.02
BAD_VIEW = 4.0
SIMPLER_WINS = 1.01
CELLS = (8, 6)


@dataclass(frozen=True)
class Judged:
    """One lens model's fit, its error on views held out, and why it cannot be right (if so)."""

    model: str
    terms: int
    fit: Fitted
    views: tuple[View, ...]
    left_out: tuple[str, ...]
    held_out_px: float
    refusals: tuple[str, ...]

    @property
    def label(self) -> str:
        """Model and number of distortion coefficients."""
        return f"{self.model}, {self.terms} coefficients"


def judged(views: list[View], model: str, terms: int, size_px: tuple[int, int]) -> Judged:
    """One model fitted to the views, without those it misses grossly, and judged.

    Raises ValueError where no starting focal length suits the model.
    """
    fit = fit_lens(views, model, terms, size_px)
    errors = np.array([np.sqrt(np.mean(np.sum(r**2, axis=1))) for r in fit.residuals])
    limit = max(BAD_VIEW * float(np.median(errors)), size_px[0] * LARGEST_RMS_SHARE)
    left_out = [f"{v.name} ({e:.1f} px)" for v, e in zip(views, errors, strict=True) if e > limit]
    if left_out and np.sum(errors <= limit) >= FEWEST_VIEWS:
        views = [v for v, e in zip(views, errors, strict=True) if e <= limit]
        fit = fit_lens(views, model, terms, size_px)
    else:
        left_out = []
    held_out = held_out_rms(fit, views)
    reasons = tuple(refusals(fit, size_px))
    return Judged(model, terms, fit, tuple(views), tuple(left_out), held_out, reasons)


def held_out_rms(fit: Fitted, views: list[View]) -> float:
    """Corner error, px rms, on views whose lens was fitted without them, five folds."""
    squares, count = 0.0, 0
    folds = min(FOLDS, len(views))
    for fold in range(folds):
        kept = [i for i in range(len(views)) if i % folds != fold]
        held = [views[i] for i in range(len(views)) if i % folds == fold]
        if not kept:
            return float("inf")
        lens = adjust(fit.lens, fit.poses[kept], [views[i] for i in kept], rounds=15).lens
        try:
            placed = place_views(lens, held)
        except ValueError:
            return float("inf")
        squares += sum(float(np.sum(r**2)) for r in placed.residuals)
        count += sum(len(r) for r in placed.residuals)
    return float(np.sqrt(squares / count))


def chosen(candidates: list[Judged]) -> Judged | None:
    """The model with the least held-out error of those not refused; a simpler one within 1 %."""
    sound = [c for c in candidates if not c.refusals]
    if not sound:
        return None
    least = min(c.held_out_px for c in sound)
    close = [c for c in sound if c.held_out_px <= SIMPLER_WINS * least]
    return min(close, key=lambda c: (c.terms, c.held_out_px))


def refusals(fit: Fitted, size_px: tuple[int, int]) -> list[str]:
    """Reasons, in words, why this lens cannot be right; empty where there is none."""
    std = np.sqrt(np.diag(fit.lens_cov))[:2] / parameters(fit.lens)[:2]
    tilts = tilts_deg(fit.poses)
    tilted = int(np.sum(tilts > FRONTAL_DEG))
    checks = {
        f"only {len(fit.poses)} views; at least {FEWEST_VIEWS} are needed": len(fit.poses)
        < FEWEST_VIEWS,
        f"the boards are seen frontally: {tilted} of {len(tilts)} tilted by more than "
        f"{FRONTAL_DEG:.0f} degrees, which leaves the focal length open": tilted < FEWEST_TILTED,
        f"the focal length is known to {100 * max(std):.1f} % only": max(std) > FOCAL_STD,
    }
    found = [reason for reason, applies in checks.items() if applies]
    return [*found, *lens_refusals(fit.lens, size_px, fit.rms_px)]


def lens_refusals(lens: Lens, size_px: tuple[int, int], rms_px: float) -> list[str]:
    """Reasons, in words, why a lens with this corner error (NaN: not known) cannot be right."""
    fx, fy, cx, cy = parameters(lens)[:4]
    if not (np.isfinite([*lens.matrix.ravel(), *lens.distortion]).all() and min(fx, fy) > 0):
        return ["focal lengths, centre and distortion are not all numbers, or not above 0"]
    width, height = size_px
    off = max(abs(cx - (width - 1) / 2) / width, abs(cy - (height - 1) / 2) / height)
    limit = width * LARGEST_RMS_SHARE
    checks = {
        f"focal lengths fx {fx:.0f} and fy {fy:.0f} lie more than 5 % apart": abs(fx / fy - 1)
        > FOCAL_APART,
        f"the optical centre ({cx:.0f}, {cy:.0f}) lies {100 * off:.0f} % off the middle": off
        > CENTRE_OFF,
        "the distortion is not monotonic inside the picture: it folds over "
        f"{fold_radius_px(lens):.0f} px from the centre": folds_inside(lens),
        f"corners miss by {rms_px:.2f} px rms, more than {limit:.2f}": rms_px > limit,
    }
    return [reason for reason, applies in checks.items() if applies]


def folds_inside(lens: Lens) -> bool:
    """Whether the lens model stops growing before the picture's farthest corner."""
    width, height = lens.size_px
    across = [max(lens.matrix[0, 2], width - lens.matrix[0, 2])]
    down = [max(lens.matrix[1, 2], height - lens.matrix[1, 2])]
    return fold_radius_px(lens) < float(np.hypot(across[0], down[0]))


def tilts_deg(poses: Float) -> Float:
    """Angle of each board (views,) against the picture plane, degrees."""
    normals = Rotation.from_rotvec(poses[:, :3]).as_matrix()[:, :, 2]
    return np.degrees(np.arccos(np.clip(np.abs(normals[:, 2]), 0, 1)))


def coverage(views: tuple[View, ...], size_px: tuple[int, int]) -> float:
    """Share of an 8 x 6 grid over the picture in which some view has a corner."""
    points = np.concatenate([view.image_px for view in views])
    cells = np.floor(points / np.array(size_px) * CELLS).astype(int)
    inside = np.all((cells >= 0) & (cells < CELLS), axis=1)
    return len({tuple(cell) for cell in cells[inside]}) / (CELLS[0] * CELLS[1])
