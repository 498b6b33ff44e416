"""Where a tail leaves a body: the longest thin thing that begins beside it."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from .background import Image

Float = npt.NDArray[np.float64]
FAINT = (0.35, 0.25, 0.18)
LEAST_TAIL, LONG_TAIL = 0.6, 1.5


def tail_exit(cover: Float, body: Image, radius: float) -> Float | None:
    """Where the tail leaves the surroundings of the body (2,) px; None without a tail.

    The longest thin thing. Fainter and fainter ones are looked for until one is long: an ear is
    faint too, but short.
    """
    best, longest = None, LEAST_TAIL * radius
    for faint in FAINT:
        place, length = _longest_leaving(cover > faint, body, radius)
        if place is not None and length > longest:
            best, longest = place, length
        if longest > LONG_TAIL * radius:
            break
    return best


def _longest_leaving(
    faint: npt.NDArray[np.bool_], body: Image, radius: float
) -> tuple[Float | None, float]:
    """Where the longest thin thing leaves the surroundings of the body, and its length [px]."""
    reach = max(2, round(0.45 * radius))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    rest = faint.astype(np.uint8) & (1 - cv2.dilate(body, disc))
    away = cv2.distanceTransform(1 - body, cv2.DIST_L2, 5)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(rest)
    best, longest = None, 0.0
    for i in range(1, count):
        v, u = np.nonzero(labels == i)
        distance = away[v, u]
        length = float(np.ptp(distance))
        thin = stats[i, cv2.CC_STAT_AREA] < 0.8 * radius * max(length, 1.0)
        if distance.min() <= reach + 4 and thin and length > longest:
            near = np.argsort(distance)[:5]
            best, longest = np.array([u[near].mean(), v[near].mean()]), length
    return best, longest
