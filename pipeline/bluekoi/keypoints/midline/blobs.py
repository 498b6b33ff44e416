"""Blobs that differ from the background, each with its midline: candidates for a bending body."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import numpy.typing as npt

from ...data import Float
from ...numba_settings import njit
from ..outline.background import LumaPicture, grey_level_quantiles, noise_level
from ..outline.blob_detection import pool_mask
from ..outline.plane import SwimmingPlaneMap
from .midline_fit import BEND_TERMS, REFERENCE_ARC, Float32Image, bending_basis

OUTER_GREY_LEVEL_QUANTILE = 0.1
MIN_CHANGE_GREY_LEVELS, MIN_CHANGE_NOISE_STDS = 16.0, 5.0
BODY_LENGTH_AFTER_DOWNSAMPLING_PX = 96.0
EXTENT_RANGE_LENGTHS, AREA_RANGE_SQUARE_LENGTHS = (0.45, 1.5), (0.02, 0.55)
"""Plausible extent of a body, in lengths, and share of its length's square that it fills."""
MIDLINE_BIN_PX = 2.0


@dataclass(frozen=True)
class BackgroundModel:
    """The pool without bodies, and what distinguishes a body from it.

    background: image (height, width). sign: 1 if bodies are darker than it, -1 if brighter. skin:
    grey level of a body. level: detection threshold of a change; noise: standard deviation of a
    pixel; both in grey levels. length_px: nose to tail tip at the pool's middle. factor: images
    are reduced by this factor before blobs are searched.
    """

    background: LumaPicture
    plane: SwimmingPlaneMap
    sign: float
    skin: float
    level: float
    noise: float
    length_px: float
    factor: int

    @cached_property
    def median_contrast(self) -> float:
        """Difference in grey levels between the background's median and a body."""
        return abs(float(np.median(self.background)) - self.skin)


@dataclass(frozen=True)
class BackgroundDifferenceCrop:
    """A reduced part of a frame.

    change: background minus frame, times `sign` [grey levels]. depth: background minus body, times
    `sign` [grey levels]. place: (3,) reduction factor, left, top.
    """

    change: Float32Image
    depth: Float32Image
    place: Float

    def to_full_frame_pixels(self, points: Float) -> Float:
        """Pixels (n, 2) of the whole frame from pixels (n, 2) of the reduced part."""
        return (points + self.place[1:] + 0.5) * self.place[0] - 0.5


@dataclass(frozen=True)
class Blob:
    """A connected region: midline (n, 2) px from end to end, length [px], area [px^2], mean change
    [grey levels], and ratio of the mean thickness of the first half to that of the second.
    """

    line: Float
    length: float
    area: float
    change: float
    thicker: float


def background_model(
    samples: list[LumaPicture], plane: SwimmingPlaneMap, total_bl: float
) -> BackgroundModel:
    """Background model from frames spread over the film; total_bl: nose to tail tip.

    The median grey level of a pixel is the background's, except where a body rests for most of the
    film. Pixels that a body passes show whether bodies are darker or brighter than the background.
    If the 10 % or 90 % quantile on that side differs clearly from the median, a body rests there
    and the quantile is the background.
    """
    least, low, usual, high, most = grey_level_quantiles(
        samples, 0.0, OUTER_GREY_LEVEL_QUANTILE, 0.5, 1 - OUTER_GREY_LEVEL_QUANTILE, 1.0
    )
    noise = noise_level(samples, usual)
    level = max(MIN_CHANGE_GREY_LEVELS, MIN_CHANGE_NOISE_STDS * noise)
    inside = pool_mask(usual.shape, plane.corners_px) > 0
    darker, brighter = (
        float(away[inside & (away > 2 * level)].sum(dtype=float))
        for away in (usual - least, most - usual)
    )
    sign, rare = (1.0, high) if darker >= brighter else (-1.0, low)
    background = np.where(cv2.absdiff(rare, usual) > 2 * level, rare, usual)
    signed = [int(sign) * cv2.subtract(background, one, dtype=cv2.CV_16S) for one in samples]
    strong = np.concatenate([change[inside & (change > 2 * level)] for change in signed])
    contrast = float(np.percentile(strong, 90)) if len(strong) else 2 * level
    usual_grey = float(np.median(background[inside]))
    length_px = total_bl * plane.px_per_bl
    factor = max(1, int(length_px / BODY_LENGTH_AFTER_DOWNSAMPLING_PX))
    level = max(level, 0.25 * contrast)
    skin = usual_grey - sign * contrast
    return BackgroundModel(background, plane, sign, skin, level, noise, length_px, factor)


def background_difference_crop(
    luma: LumaPicture, arena: BackgroundModel, centre: Float | None = None, reach_px: float = 0.0
) -> BackgroundDifferenceCrop:
    """Reduced part of a frame around a centre (2,) px, within `reach_px`; all of it by default."""
    height, width = luma.shape
    left, top, right, low = 0, 0, width, height
    if centre is not None:
        left, right = _clipped_pixel_range(centre[0], reach_px, width)
        top, low = _clipped_pixel_range(centre[1], reach_px, height)
    f = arena.factor
    left, top = left // f * f, top // f * f
    window = slice(top, low), slice(left, right)
    background = arena.background[window]
    change = cv2.subtract(background, luma[window], dtype=cv2.CV_16S).astype(np.float32)
    change *= arena.sign
    depth = arena.sign * (background.astype(np.float32) - arena.skin)
    if f > 1:
        size = max(1, (right - left) // f), max(1, (low - top) // f)
        whole = slice(0, size[1] * f), slice(0, size[0] * f)
        change, depth = (
            cv2.resize(one[whole], size, interpolation=cv2.INTER_AREA) for one in (change, depth)
        )
    return BackgroundDifferenceCrop(change, depth, np.array([f, left / f, top / f]))


def _clipped_pixel_range(middle: float, reach: float, size: int) -> tuple[int, int]:
    first = int(min(max(middle - reach, 0), max(size - 8, 0)))
    return first, int(min(max(middle + reach, first + 8), size))


def find_blobs(picture: BackgroundDifferenceCrop, arena: BackgroundModel) -> list[Blob]:
    """Blobs of a body's size and slenderness, those with the largest summed change first."""
    smooth = cv2.blur(picture.change, (3, 3))
    mask = ((smooth > arena.level) & (picture.depth > arena.level)).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    length = arena.length_px / arena.factor
    found = []
    for i in range(1, count):
        x, y, w, h, area = stats[i]
        if (
            not AREA_RANGE_SQUARE_LENGTHS[0] * length**2
            < area
            < AREA_RANGE_SQUARE_LENGTHS[1] * length**2
        ):
            continue
        if (
            not EXTENT_RANGE_LENGTHS[0] * length
            < math.hypot(w, h)
            < EXTENT_RANGE_LENGTHS[1] * length
        ):
            continue
        own = labels[y : y + h, x : x + w] == i
        blob = _blob_of_component(
            own, smooth[y : y + h, x : x + w], np.array([x, y], float), picture
        )
        if blob is not None:
            found.append(blob)
    return sorted(found, key=lambda one: -one.change * one.area)


def _blob_of_component(
    own: npt.NDArray[np.bool_],
    change: Float32Image,
    corner: Float,
    picture: BackgroundDifferenceCrop,
) -> Blob | None:
    """Midline of a connected component: centroids of its pixels at equal distance from one end."""
    away = geodesic_distances_from_end(np.pad(own, 1))[1:-1, 1:-1]
    v, u = np.nonzero(own)
    far = away[v, u]
    bins = (far / MIDLINE_BIN_PX).astype(int)
    weight = change[v, u].astype(float)
    total = np.maximum(np.bincount(bins, weight), 1e-9)
    line = np.column_stack([np.bincount(bins, weight * axis) / total for axis in (u, v)])
    if len(line) < 5:
        return None
    padded = np.concatenate([line[:1], line, line[-1:]])
    line = 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]
    length = float(np.hypot(*np.diff(line, axis=0).T).sum()) + MIDLINE_BIN_PX
    half = len(line) // 2
    thicker = float(total[:half].sum() / total[-half:].sum())
    f = picture.place[0]
    return Blob(picture.to_full_frame_pixels(line + corner), length * f, float(own.sum()) * f * f,
                float(weight.mean()), thicker)  # fmt: skip


@njit(cache=True)
def geodesic_distances_from_end(own: npt.NDArray[np.bool_]) -> Float:
    """Geodesic distance [px] within a connected mask from one of its two ends; its border is 0."""
    height, width = own.shape
    v, u = np.nonzero(own)
    at_v, at_u = v[0], u[0]
    away = np.empty((height, width))
    queue = np.empty((height * width * 8, 2), np.int64)
    for _ in range(2):
        away[:] = 1e9
        away[at_v, at_u] = 0.0
        queue[0, 0], queue[0, 1] = at_v, at_u
        first, last = 0, 1
        while first < last:
            y, x = queue[first]
            first += 1
            for dy in range(-1, 2):
                for dx in range(-1, 2):
                    new = away[y, x] + (1.0 if dx * dy == 0 else 1.4142)
                    if own[y + dy, x + dx] and new < away[y + dy, x + dx] - 1e-9:
                        away[y + dy, x + dx] = new
                        if last < len(queue):
                            queue[last, 0], queue[last, 1] = y + dy, x + dx
                            last += 1
        farthest = 0.0
        for k in range(len(v)):
            if farthest < away[v[k], u[k]] < 1e9:
                farthest, at_v, at_u = away[v[k], u[k]], v[k], u[k]
    return away


def candidate_poses(blob: Blob, plane: SwimmingPlaneMap, length_bl: float) -> list[Float]:
    """Two poses (3 + BEND_TERMS,) along the blob's midline, the thicker end as the nose first."""
    line = plane.pixels_to_body_lengths(blob.line)
    both = [line, line[::-1]] if blob.thicker >= 1 else [line[::-1], line]
    return [pose_from_midline(one, length_bl) for one in both]


def pose_from_midline(line: Float, length_bl: float) -> Float:
    """Pose whose midline runs along a line (n, 2) [body lengths] from nose to tail."""
    step = np.hypot(*np.diff(line, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(step)])
    slack = 0.5 * (length_bl - along[-1]) / length_bl
    arc = np.clip(slack + along / length_bl, 0.0, 1.0)
    heading = np.unwrap(np.arctan2(*(line[:-1] - line[1:]).T[::-1]))
    terms = np.column_stack([np.ones(len(heading)), bending_basis(0.5 * (arc[1:] + arc[:-1]))])
    tie = np.diag([0.0] + [0.02 * len(heading)] * BEND_TERMS)
    solved = np.linalg.solve(terms.T @ terms + tie, terms.T @ heading)
    place = [np.interp(REFERENCE_ARC, arc, axis) for axis in line.T]
    return np.concatenate([place, solved])
