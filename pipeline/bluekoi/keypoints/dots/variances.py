"""How well dots are known: their distances on rigid parts, which do not change, and their areas."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from scipy.ndimage import median_filter

from ...data import Float
from ...data.keypoint_quality import is_confident
from ..files.noise import frame_to_frame_noise_std_px

RIGID_PARTS = ("head_tip", "hinge", "core_center", "tail_base")
TREND_MEDIAN_FILTER_FRAMES = 31
MIN_FRAMES_FOR_VARIANCE = 20
MIN_STD_PX = 0.03
OUTLIER_SIGMAS = 5.0
HALF_DISC_CENTROID_RADII = 4 / (3 * math.pi)
MAX_AREA_DEVIATION_SIGMAS = 3.0


def dot_variances(names: Sequence[str], xy_px: Float, likelihood: Float) -> Float:
    """Usual variance (parts,) px^2 of each dot's coordinates, (frames, parts, 2).

    The distance of two dots on the robot, which holds its head angle, scatters by the sum of their
    variances; what goes on for longer than TREND_MEDIAN_FILTER_FRAMES is perspective. Unlike
    differences from frame to frame that sees noise that lasts for a few frames, as compression
    makes it. A dot on the tail is as noisy as the others. Where too few distances are known: each
    dot's white noise.
    """
    xy = np.where(is_confident(likelihood)[..., None], xy_px, np.nan)
    rigid = [k for k, name in enumerate(names) if name in RIGID_PARTS]
    pairs = list(combinations(range(len(rigid)), 2))
    scatter = np.array(
        [_variance_about_trend_px2(xy[:, rigid[a]] - xy[:, rigid[b]]) for a, b in pairs]
    )
    known = np.isfinite(scatter)
    sums = np.zeros((len(pairs), len(rigid)))
    for row, pair in enumerate(pairs):
        sums[row, list(pair)] = 1.0
    if np.linalg.matrix_rank(sums[known]) < len(rigid):
        return np.array(
            [
                frame_to_frame_noise_std_px(xy[:, k], likelihood[:, k]) ** 2
                for k in range(len(names))
            ]
        )
    found = np.linalg.lstsq(sums[known], scatter[known], rcond=None)[0]
    variance = np.full(len(names), float(np.median(found)))
    variance[rigid] = found
    return np.maximum(variance, 0.0) + MIN_STD_PX**2


def _variance_about_trend_px2(apart: Float) -> float:
    """Variance px^2 of a distance (frames, 2) about its trend, without gross errors."""
    length = np.hypot(*apart[np.isfinite(apart).all(axis=1)].T)
    if len(length) < MIN_FRAMES_FOR_VARIANCE:
        return math.nan
    off = length - median_filter(length, TREND_MEDIAN_FILTER_FRAMES, mode="nearest")
    limit = OUTLIER_SIGMAS * 1.4826 * float(np.median(np.abs(off)))
    return float(np.mean(off[np.abs(off) <= limit] ** 2))


def occlusion_variances(area_px2: Float, radius_px: Float) -> Float:
    """Variance (frames, parts) px^2 from what is hidden of a dot, or shines on it.

    A dot of radius r that lacks the share f of its area, on one side, has its centre off by up to
    about f 4 r / (3 pi). Only what differs from the dot's usual area by more than it usually does.
    """
    known = np.isfinite(area_px2)
    area = np.where(known, area_px2, np.nanmedian(area_px2) if known.any() else 1.0)
    trend = median_filter(area, (TREND_MEDIAN_FILTER_FRAMES, 1), mode="nearest")
    lacking = np.abs(area / trend - 1.0)
    usual = MAX_AREA_DEVIATION_SIGMAS * 1.4826 * np.median(lacking, axis=0)
    off = (
        HALF_DISC_CENTROID_RADII
        * np.nan_to_num(radius_px)
        * np.maximum(np.minimum(lacking, 1.0) - usual, 0.0)
    )
    return np.where(known, off**2, (0.5 * np.nan_to_num(radius_px)) ** 2)
