"""Image circle of a circular fisheye lens: the lit part of its pictures."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from ..data import Float

RIM_SEARCH_DIRECTIONS = 360
"""Directions, evenly over the circle, in which the rim is looked for."""
MAX_OUTSIDE_BRIGHTNESS_SHARE = 0.25
"""Outside the circle at most this share of the brightness inside it, in the brightest picture."""
MIN_SHARE_OF_RIM_SEEN = 0.3
"""Share of the directions in which the rim is inside the picture and was found."""
MAX_RIM_SCATTER_SHARE_OF_RADIUS = 0.01
"""Median distance of the rim from the fitted circle, over its radius."""


@dataclass(frozen=True)
class ImageCircle:
    """Centre (u, v) and radius of the lit circle, px."""

    center_px: tuple[float, float]
    radius_px: float

    def max_distance_px(self, u: float, v: float) -> float:
        """Largest distance, px, of a point of the circle from (u, v)."""
        return self.radius_px + float(np.hypot(self.center_px[0] - u, self.center_px[1] - v))

    @property
    def text(self) -> str:
        """The circle with its numbers."""
        return (
            f"image circle of radius {self.radius_px:.0f} px about "
            f"({self.center_px[0]:.0f}, {self.center_px[1]:.0f})"
        )


def image_circle(brightest: npt.NDArray[np.uint8]) -> ImageCircle | None:
    """Image circle of pictures whose pixelwise maximum (height, width) is given; None without one.

    The rim is where the brightness, along `RIM_SEARCH_DIRECTIONS` directions inwards from the
    border, first exceeds `MAX_OUTSIDE_BRIGHTNESS_SHARE` of the median inside. The circle is fitted
    to it robustly (soft L1).
    """
    height, width = brightest.shape
    smooth = cv2.GaussianBlur(brightest, (0, 0), max(1.0, width / 500))
    middle = smooth[height // 3 : 2 * height // 3, width // 3 : 2 * width // 3]
    lit = smooth > MAX_OUTSIDE_BRIGHTNESS_SHARE * float(np.median(middle))
    rim = _lit_rim_px(lit)
    if len(rim) < MIN_SHARE_OF_RIM_SEEN * RIM_SEARCH_DIRECTIONS:
        return None

    def off_circle(p: Float) -> Float:
        return np.hypot(rim[:, 0] - p[0], rim[:, 1] - p[1]) - p[2]

    start = np.array([width / 2, height / 2, height / 2])
    found = least_squares(off_circle, start, loss="soft_l1", f_scale=0.002 * width)
    u, v, radius = map(float, found.x)
    if np.median(np.abs(off_circle(found.x))) > MAX_RIM_SCATTER_SHARE_OF_RADIUS * radius:
        return None
    return ImageCircle((u, v), radius)


def _lit_rim_px(lit: np.ndarray) -> Float:
    """Outermost lit pixel (n, 2) in each direction from the middle that ends in the dark."""
    height, width = lit.shape
    angle = np.linspace(0, 2 * np.pi, RIM_SEARCH_DIRECTIONS, endpoint=False)
    distance = np.arange(0, np.hypot(width, height) / 2)
    u = (width - 1) / 2 + distance[:, None] * np.cos(angle)
    v = (height - 1) / 2 + distance[:, None] * np.sin(angle)
    inside = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
    column, row = (np.clip(np.round(x), 0, n - 1).astype(int) for x, n in ((u, width), (v, height)))
    seen = lit[row, column] & inside
    last_seen = len(distance) - 1 - np.argmax(seen[::-1], axis=0)
    last_inside = inside.sum(axis=0) - 1
    ends = np.any(seen, axis=0) & (last_seen < last_inside - 2)
    rays = np.flatnonzero(ends)
    return np.column_stack([u[last_seen[rays], rays], v[last_seen[rays], rays]])
