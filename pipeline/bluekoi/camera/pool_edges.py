"""Straight steps in brightness near an expected edge of the pool."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..data import Float
from .boards import GreyPicture

FloatPicture = npt.NDArray[np.float32]
SAMPLES_PER_EDGE = 80
"""Places along an edge at which it is looked for."""
SAMPLE_SPACING_PX = 0.25
"""Spacing of the samples across an edge."""
SMOOTHING_STD_PX = 1.0
"""Standard deviation of the Gaussian that smooths the picture."""
MAX_INLIER_DISTANCE_PX = 1.5
"""Distance from the fitted line, px, within which a step of brightness belongs to it."""
MIN_SEEN_SHARE_OF_EDGE = 0.4
"""Share of an edge's places that must show a step for the line to count."""
MIN_STEP_TO_NOISE_RATIO = 4.0
"""Slope of the brightness at an edge, over the median slope around it."""
CORNER_MARGIN_SHARE_OF_EDGE = 0.05
"""Part at either end of an edge, as a share of its length, that is left out: corners round it."""
MAX_LINES_PER_EDGE = 5
"""Parallel lines (rims, steps) looked for at one edge."""
MIN_LINE_SPACING_PX = 3.0
"""Distance between two such lines."""
MIN_LINE_STD_PX = 0.1
"""Steps are found to about a tenth of a pixel (docs/measuring.md), however many agree."""


@dataclass(frozen=True)
class ExpectedEdge:
    """Expected edge: points (n, 2) px from one corner to the next and their unit normals (n, 2)."""

    points_px: Float
    normal_px: Float

    @property
    def fraction_along(self) -> Float:
        """Place along the edge (n,), 0 at its first corner, 1 at its second."""
        return np.linspace(0, 1, len(self.points_px))


@dataclass(frozen=True)
class EdgeLine:
    """A line found near an expected edge.

    steps_px: (n,) offset along the normal of the steps that lie on it, else NaN. share: part of the
    samples on it. ends_px, ends_std_px: (2,) offset at the two corners and its std. bend_px: rms of
    the steps about the line.
    """

    steps_px: Float
    share: float
    ends_px: Float
    ends_std_px: Float
    bend_px: float

    @property
    def middle_offset_px(self) -> float:
        """Offset at the middle of the edge."""
        return float(self.ends_px.mean())


def smooth_frame(grey: GreyPicture) -> FloatPicture:
    """The frame as `find_edge_lines` takes it, without noise from pixel to pixel."""
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), SMOOTHING_STD_PX), dtype=np.float32)


def find_edge_lines(
    picture: FloatPicture, curve: ExpectedEdge, reach_px: float
) -> tuple[EdgeLine, ...]:
    """Lines within `reach_px` of a curve, those with the most samples first."""
    along = curve.fraction_along
    inner = (along >= CORNER_MARGIN_SHARE_OF_EDGE) & (along <= 1 - CORNER_MARGIN_SHARE_OF_EDGE)
    across, is_step = _brightness_steps(picture, curve, reach_px)
    is_step = is_step & inner[:, None]
    lines: list[EdgeLine] = []
    for _ in range(MAX_LINES_PER_EDGE):
        start = _hough_line(across, along, is_step)
        line = _refine_edge_line(across, along, is_step, start)
        if line is None or line.share < MIN_SEEN_SHARE_OF_EDGE:
            break
        lines.append(line)
        off = np.abs(across - np.interp(along, [0, 1], line.ends_px)[:, None])
        is_step = is_step & (off > MIN_LINE_SPACING_PX)
    return tuple(lines)


def _brightness_steps(
    picture: FloatPicture, curve: ExpectedEdge, reach_px: float
) -> tuple[Float, npt.NDArray[np.bool_]]:
    """Offsets (n, m) along the normals, refined at peaks of the gradient, and which are peaks."""
    across = np.arange(-reach_px, reach_px + SAMPLE_SPACING_PX, SAMPLE_SPACING_PX)
    points = curve.points_px[:, None] + across[:, None] * curve.normal_px[:, None]
    maps = points.astype(np.float32)
    profile = cv2.remap(
        picture, maps[:, :, 0], maps[:, :, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    slope = np.abs(np.gradient(profile, axis=1)) / SAMPLE_SPACING_PX
    wide = max(3, int(2 * MIN_LINE_SPACING_PX / SAMPLE_SPACING_PX) | 1)
    highest = cv2.dilate(slope, np.ones((1, wide), np.uint8))
    limit = np.maximum(MIN_STEP_TO_NOISE_RATIO * np.median(slope), 1.0)
    peak = (slope >= highest) & (slope > limit)
    peak[:, [0, -1]] = False
    left, right = np.roll(slope, 1, axis=1), np.roll(slope, -1, axis=1)
    curvature = np.where(peak, left - 2 * slope + right, -1)
    shift = np.where(peak & (curvature < 0), (left - right) / np.minimum(2 * curvature, -1e-9), 0)
    return across + np.clip(shift, -1, 1) * SAMPLE_SPACING_PX, peak


def _hough_line(across: Float, along: Float, is_step: npt.NDArray[np.bool_]) -> Float:
    """Straight line (slope, offset at 0) near the most samples' steps: a Hough transform.

    A line is given by its offsets at both ends, in whole pixels. The lines that pass a step within
    `MAX_INLIER_DISTANCE_PX` are, for each first end, those of an interval of second ends.
    """
    single = is_step.copy()
    single[:, 1:] &= ~is_step[:, :-1]  # neighbours of equal slope are one step
    row, column = np.nonzero(single)
    ends = np.arange(across[0, 0], across[0, -1], 1.0)
    n, place, step = len(ends), along[row], across[row, column]
    second = (step - (1 - place) * ends[:, None]) / place - ends[0]
    half = MAX_INLIER_DISTANCE_PX / place
    first, behind = np.ceil(second - half), np.floor(second + half) + 1
    cells = np.arange(n)[:, None] * (n + 1)
    changes = [np.bincount((cells + np.clip(edge, 0, n).astype(np.intp)).ravel(),
                           minlength=n * (n + 1)) for edge in (first, behind)]  # fmt: skip
    votes = np.cumsum((changes[0] - changes[1]).reshape(n, n + 1), axis=1)[:, :n]
    one, other = np.unravel_index(np.argmax(votes), votes.shape)
    return np.array([ends[other] - ends[one], ends[one]])


def _refine_edge_line(
    across: Float, along: Float, is_step: npt.NDArray[np.bool_], start: Float
) -> EdgeLine | None:
    line, steps = start, np.full(len(along), np.nan)
    for reach in (
        3 * MAX_INLIER_DISTANCE_PX,
        2 * MAX_INLIER_DISTANCE_PX,
        MAX_INLIER_DISTANCE_PX,
        MAX_INLIER_DISTANCE_PX,
    ):
        off = np.where(is_step, across - np.polyval(line, along)[:, None], np.inf)
        nearest = np.argmin(np.abs(off), axis=1)[:, None]
        miss = np.take_along_axis(off, nearest, axis=1)[:, 0]
        steps = np.take_along_axis(across, nearest, axis=1)[:, 0]
        steps = np.where(np.abs(miss) < reach, steps, np.nan)
        on = np.isfinite(steps)
        if on.sum() < 8 or np.ptp(along[on]) < 0.5:
            return None
        line = np.polyfit(along[on], steps[on], 1)
    on = np.isfinite(steps)
    design = np.vander(along[on], 2)
    bend = float(np.sqrt(np.sum((steps[on] - design @ line) ** 2) / (on.sum() - 2)))
    ends = np.vander([0.0, 1.0], 2)
    spread = np.einsum("ij,jk,ik->i", ends, np.linalg.inv(design.T @ design), ends)
    inner = np.sum(
        (along >= CORNER_MARGIN_SHARE_OF_EDGE) & (along <= 1 - CORNER_MARGIN_SHARE_OF_EDGE)
    )
    return EdgeLine(
        steps_px=steps,
        share=float(on.sum() / inner),
        ends_px=ends @ line,
        ends_std_px=np.hypot(np.sqrt(spread) * bend, MIN_LINE_STD_PX),
        bend_px=bend,
    )
