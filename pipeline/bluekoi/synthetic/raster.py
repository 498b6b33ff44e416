"""Exact-area drawing of polygons: each pixel gets the share of it that a shape covers."""

import math

import numpy as np

from ..numba_settings import njit


@njit(cache=True)
def _accumulate_edge(acc: np.ndarray, row: int, x0: float, x1: float, dy: float) -> None:
    """Add one edge piece inside a pixel row: height `dy` (signed) from x0 to x1, to `acc`.

    The cell that a piece of height d at mean distance m from its left border lies in gets
    d (1 - m), the next one d m; the running sum along the row is then the covered area.
    """
    width = acc.shape[1] - 1
    if x0 > x1:
        x0, x1 = x1, x0
    span = x1 - x0
    x = x0
    while True:
        cell = math.floor(x)
        end = min(x1, cell + 1.0)
        part = dy if span <= 1e-12 else dy * (end - x) / span
        mean = 0.5 * (x + end) - cell
        if cell < 0:
            acc[row, 0] += part
        elif cell < width:
            acc[row, cell] += part * (1 - mean)
            acc[row, cell + 1] += part * mean
        if end >= x1:
            return
        x = end


@njit(cache=True)
def _add_polygon(acc: np.ndarray, points: np.ndarray) -> tuple[int, int]:
    """Add all edges of a closed polygon `(n, 2)`; returns the rows touched."""
    height, count = acc.shape[0], points.shape[0]
    top, bottom = height, 0
    for i in range(count):
        xa, ya = points[i, 0], points[i, 1]
        xb, yb = points[(i + 1) % count, 0], points[(i + 1) % count, 1]
        if ya == yb:
            continue
        sign = 1.0
        if ya > yb:
            xa, ya, xb, yb, sign = xb, yb, xa, ya, -1.0
        slope = (xb - xa) / (yb - ya)
        first, last = max(0, math.floor(ya)), min(height - 1, math.ceil(yb) - 1)
        for row in range(first, last + 1):
            y0, y1 = max(ya, float(row)), min(yb, row + 1.0)
            if y1 > y0:
                x0, x1 = xa + (y0 - ya) * slope, xa + (y1 - ya) * slope
                _accumulate_edge(acc, row, x0, x1, sign * (y1 - y0))
        top, bottom = min(top, first), max(bottom, last + 1)
    return top, bottom


@njit(cache=True)
def paint_polygons(
    canvas: np.ndarray, points: np.ndarray, ends: np.ndarray, colours: np.ndarray
) -> None:
    """Paint polygons over `canvas` `(rows, columns, 4)` in place, premultiplied colour and opacity.

    `points` `(n, 2)` are x, y in pixel cells (the first cell spans 0 to 1), polygon k ends
    before `ends[k]`; `colours` `(polygons, 4)` are three channels and opacity (0 to 1).
    """
    height, width = canvas.shape[0], canvas.shape[1]
    acc = np.zeros((height, width + 1))
    begin = 0
    for k in range(ends.shape[0]):
        polygon = points[begin : ends[k]]
        begin = ends[k]
        left = max(0, math.floor(polygon[:, 0].min()))
        right = min(width, math.ceil(polygon[:, 0].max()) + 1)
        top, bottom = _add_polygon(acc, polygon)
        opacity = colours[k, 3]
        for row in range(top, bottom):
            covered = 0.0
            for column in range(left, right):
                covered += acc[row, column]
                share = min(abs(covered), 1.0) * opacity
                if share > 1e-6:
                    for c in range(3):
                        canvas[row, column, c] += share * (colours[k, c] - canvas[row, column, c])
                    canvas[row, column, 3] += share * (1.0 - canvas[row, column, 3])
            acc[row, :] = 0.0


def pixels_to_canvas(pixels: np.ndarray, origin: tuple[int, int]) -> np.ndarray:
    """Image pixels (centres at whole numbers) as cell coordinates of a canvas at `origin`."""
    return pixels - np.array(origin, dtype=float) + 0.5
