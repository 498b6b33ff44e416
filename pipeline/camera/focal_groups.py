"""Whether views of a board were taken with one focal length, or some with another zoom."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..data import Float
from .boards import View
from .bundle import Fitted, focal_shifts

Index = npt.NDArray[np.intp]

LEAST_APART, CLEFT = 0.01, 5.0
"""Two zooms lie apart by this share of the focal length at least, and by this many times as much as
views of one zoom scatter. Any one heap parted in the middle has 2.7; of 40 sets of one zoom none is
told, of 20 sets with two zooms 3 % apart 13, 6 % apart 18.
"""
FEWEST = 3
MOST_NAMED = 6


def two_focal_lengths(fitted: Fitted, views: list[View]) -> str:
    """A remark where the views fall into two groups of another focal length; else empty.

    The views are parted where their own focal lengths, weighed by how well each can tell, scatter
    least within both groups.
    """
    if len(views) < 2 * FEWEST:
        return ""
    shift, std = focal_shifts(fitted, views)
    order = np.argsort(shift)
    parted = [(order[:k], order[k:]) for k in range(FEWEST, len(views) - FEWEST + 1)]
    low, high = min(parted, key=lambda two: sum(_about(shift, std, one)[1] for one in two))
    (below, one), (above, other) = (_about(shift, std, group) for group in (low, high))
    apart = above - below
    scatter = float(np.sqrt((one + other) / np.sum(std**-2.0)))
    if apart < LEAST_APART or apart < CLEFT * scatter:
        return ""
    fewer = min(low, high, key=len)
    names = [views[i].name for i in sorted(fewer.tolist())]
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return (
        f"the views seem taken with two focal lengths, {100 * apart:.1f} % apart: was the zoom or "
        f"the field of view another for {', '.join(names[:MOST_NAMED])}{more}?"
    )


def _about(shift: Float, std: Float, group: Index) -> tuple[float, float]:
    """Weighted mean of a group's shifts, and the weighted sum of squares about it."""
    weight = std[group] ** -2.0
    mean = float(weight @ shift[group] / weight.sum())
    return mean, float(weight @ (shift[group] - mean) ** 2)
