"""Values of trials that deviate from those of most trials."""

from __future__ import annotations

import numpy as np

from .types import Float

NORMAL_IQR_IN_STDS = 1.349
"""Width of the central half of a normal distribution, in standard deviations."""
MAX_MAJORITY_DEVIATION_SIGMAS = 5.0
"""Standard deviations beyond which a value is not one of most trials."""


def deviations_from_majority(values: Float, stds: Float, least: float) -> Float:
    """Difference (n,) of each trial's value from most trials', 0 where it is within the scatter.

    least: differences up to this one are no deviation, in units of `values`. Fewer than three
    values have no majority.
    """
    if len(values) < 3:
        return np.zeros(len(values))
    centre, scatter = majority_centre_and_scatter(values)
    off = values - centre
    limit = np.maximum(least, MAX_MAJORITY_DEVIATION_SIGMAS * np.hypot(scatter, stds))
    return np.where(np.abs(off) > limit, off, 0.0)


def majority_centre_and_scatter(values: Float) -> tuple[float, float]:
    """Centre and standard deviation of most of the values (n,), two or more.

    Those of the shortest interval with half of them (least median of squares; Rousseeuw, J. Am.
    Stat. Assoc. 79 (1984) 871, with its correction for few values): up to half may be wrong.
    """
    n = len(values)
    half = (n + 1) // 2
    ordered = np.sort(values)
    widths = ordered[half - 1 :] - ordered[: n - half + 1]
    at = int(np.argmin(widths))
    centre = float(np.median(ordered[at : at + half]))
    return centre, float(widths[at]) / NORMAL_IQR_IN_STDS * (1 + 5 / (n - 1))
