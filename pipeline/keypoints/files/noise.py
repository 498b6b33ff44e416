"""White noise of a keypoint from the keypoint itself, where its source gives no covariance."""

from __future__ import annotations

from math import comb

import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.float64]
ORDERS = (6, 2, 4, 8)
LEAST_PX = 0.05
UNKNOWN_PX = 2.0
TRUSTED = 0.6
FEWEST = 12


def white_noise_px(xy_px: Float, likelihood: Float) -> float:
    """Standard deviation of the frame-to-frame noise of one part, px, one number for x and y.

    The k-th difference of white noise has variance C(2k, k) sigma^2, while a motion at angular
    step w is reduced by sin(w/2)^k: high orders see through swimming and tail beat. Scale by the
    median absolute deviation; the sixth order unless another is clearly smaller.
    xy_px: (frames, 2). Slow errors of a network are not seen in this way.
    """
    good = np.where((likelihood >= TRUSTED)[:, None], xy_px, np.nan)
    found = [_scale(np.diff(good, n=k, axis=0), k) for k in ORDERS]
    known = [value for value in found if np.isfinite(value)]
    if not known:
        return UNKNOWN_PX
    usual = found[0] if np.isfinite(found[0]) else known[0]
    least = min(known)
    return max(LEAST_PX, least if least < 0.8 * usual else usual)


def _scale(difference: Float, order: int) -> float:
    whole = difference[np.isfinite(difference).all(axis=1)]
    if len(whole) < FEWEST:
        return float("nan")
    deviation = np.median(np.abs(whole - np.median(whole, axis=0)), axis=0) / 0.6744898
    return float(np.sqrt(np.mean(deviation**2) / comb(2 * order, order)))
