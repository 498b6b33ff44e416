"""Which points and frames are used, and how many samples count as one: one rule for all stages.

A point counts where its likelihood is at least `MIN_KEYPOINT_LIKELIHOOD` or not stated (NaN). A
frame whose standard deviation is `MAX_STD_TO_USUAL_STD_RATIO` times the usual one of its trial says
nothing by itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .types import Float

MIN_KEYPOINT_LIKELIHOOD = 0.6
"""Likelihood from which a keypoint counts as seen: the cut-off that DeepLabCut uses."""
MIN_POSE_FRAMES = 8
"""Frames with a pose without which a motion cannot be smoothed."""
MAX_STD_TO_USUAL_STD_RATIO = 10.0
"""Standard deviation over the usual one of its trial above which a frame counts as poorly seen."""


def is_confident(likelihood: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Where a likelihood, of any shape, is that of a point that counts."""
    return np.asarray(~(likelihood < MIN_KEYPOINT_LIKELIHOOD))


def has_excess_variance(variance: Float, usual: Float | float) -> npt.NDArray[np.bool_]:
    """Where a variance, of any shape, exceeds the usual one by too much, or is unknown (NaN)."""
    return np.asarray(~(variance <= MAX_STD_TO_USUAL_STD_RATIO**2 * np.asarray(usual)))


def correlation_time_samples(residual: Float) -> float:
    """Samples that count as one: 1 + 2 sum of the autocorrelation up to its first zero."""
    n = len(residual)
    centred = residual - residual.mean()
    power = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    acf = np.fft.irfft(power)[:n] / max(float(centred @ centred), 1e-300)
    stop = int(np.argmax(acf <= 0)) if np.any(acf <= 0) else n
    return float(np.clip(1 + 2 * acf[1 : max(stop, 1)].sum(), 1.0, n / 4))
