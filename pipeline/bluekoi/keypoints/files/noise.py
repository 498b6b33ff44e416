"""White noise of a keypoint from the keypoint itself, where its source gives no covariance."""

from __future__ import annotations

from math import comb

import numpy as np

from ...data import Float
from ...data.keypoint_quality import is_confident

DIFFERENCE_ORDERS = (6, 2, 4, 8, 10)
MIN_STD_PX = 0.05
FALLBACK_STD_PX = 2.0
MIN_FRAMES = 12
OUTLIER_SIGMAS = 6.0


def frame_to_frame_noise_std_px(xy_px: Float, likelihood: Float) -> float:
    """Standard deviation of the frame-to-frame noise of one part, px, one number for x and y.

    The k-th difference of white noise has variance C(2k, k) sigma^2, while a motion at angular
    step w is reduced by sin(w/2)^k: high orders see through swimming and tail beat. Scale by the
    median absolute deviation; the sixth order unless another is clearly smaller.
    xy_px: (frames, 2). Slow errors of a network are not seen in this way.
    """
    good = positions_without_jumps(np.where(is_confident(likelihood)[:, None], xy_px, np.nan))
    found = [_white_noise_std_px(np.diff(good, n=k, axis=0), k) for k in DIFFERENCE_ORDERS]
    known = [value for value in found if np.isfinite(value)]
    if not known:
        return FALLBACK_STD_PX
    usual = found[0] if np.isfinite(found[0]) else known[0]
    least = min(known)
    return max(MIN_STD_PX, least if least < 0.8 * usual else usual)


def positions_without_jumps(xy_px: Float, order: int = 6) -> Float:
    """Positions (frames, 2) with lone jumps made NaN: the middle of the largest differences."""
    half = order // 2
    difference = np.diff(xy_px, n=order, axis=0)
    scale = _white_noise_std_px(difference, order) * np.sqrt(comb(2 * order, order))
    if not np.isfinite(scale):
        return xy_px
    size = np.pad(np.nan_to_num(np.hypot(*difference.T)), half)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(size, half), order + 1).max(axis=1)
    lone = (size > OUTLIER_SIGMAS * scale) & (size == around)
    return np.where(lone[:, None], np.nan, xy_px)


def _white_noise_std_px(difference: Float, order: int) -> float:
    whole = difference[np.isfinite(difference).all(axis=1)]
    if len(whole) < MIN_FRAMES:
        return float("nan")
    deviation = np.median(np.abs(whole - np.median(whole, axis=0)), axis=0) / 0.6744898
    return float(np.sqrt(np.mean(deviation**2) / comb(2 * order, order)))
