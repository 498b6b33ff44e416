"""Whether the camera stood still: the pool's corners, which do not move, compared over time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from ...data import Float, Frame
from .background import LumaPicture
from .plane import SwimmingPlaneMap

PATCH_HALF_SIZE_SHARE, MAX_SHIFT_SHARE = 0.1, 0.05
"""Half a patch and the farthest shift, as shares of the pool's shorter side."""
BLUR_STD_PX = 1.5
MIN_SHIFT_PX = 0.6
SUDDEN_SHIFT_SHARE = 0.7
AGREEMENT_TOLERANCE_PX, AGREEMENT_TOLERANCE_SHARE = 0.5, 0.15
MIN_CORRELATION = 0.25


def corner_shifts(samples: Sequence[Frame], plane: SwimmingPlaneMap) -> Float:
    """Shift (samples, corners, 2) px of each pool corner against the first sample; NaN unseen.

    Correlation of the edges in a patch about each corner, looked for around where it was; only a
    clear peak inside that range counts.
    """
    found = np.full((len(samples), 4, 2), np.nan)
    far = max(4, round(MAX_SHIFT_SHARE * plane.shorter_pool_side_px))
    for k, corner in enumerate(plane.corners_px):
        patches = [_edge_strength_patch(frame.luma, corner, plane) for frame in samples]
        first = patches[0]
        if first is None:
            continue
        template = np.ascontiguousarray(first[far:-far, far:-far])
        found[0, k] = 0.0
        for i, patch in enumerate(patches[1:], 1):
            if patch is not None:
                found[i, k] = _peak_offset_px(
                    cv2.matchTemplate(patch, template, cv2.TM_CCOEFF_NORMED)
                )
    return found


def _peak_offset_px(likeness: npt.NDArray[np.float32]) -> tuple[float, float]:
    """Place (u, v) of a map's peak from its middle, to a part of a pixel; NaN without a peak."""
    _, most, _, (u, v) = cv2.minMaxLoc(likeness)
    height, width = likeness.shape
    if most < MIN_CORRELATION or not (0 < u < width - 1 and 0 < v < height - 1):
        return math.nan, math.nan
    along, across = likeness[v, u - 1 : u + 2], likeness[v - 1 : v + 2, u]
    return u + _parabola_vertex(along) - (width - 1) / 2, v + _parabola_vertex(across) - (
        height - 1
    ) / 2


def _parabola_vertex(three: npt.NDArray[np.float32]) -> float:
    """Where the parabola through three values, the middle one the largest, has its top."""
    before, here, after = three.tolist()
    bend = before - 2 * here + after
    return 0.5 * (before - after) / bend if bend < 0 else 0.0


def _edge_strength_patch(
    luma: LumaPicture, corner: Float, plane: SwimmingPlaneMap
) -> npt.NDArray[np.float32] | None:
    """Strength of the edges about a corner; None where it reaches out of the picture."""
    half = int(PATCH_HALF_SIZE_SHARE * plane.shorter_pool_side_px)
    u, v = (round(float(value)) for value in corner)
    height, width = luma.shape
    if not (half <= u < width - half and half <= v < height - half):
        return None
    cut = luma[v - half : v + half, u - half : u + half].astype(np.float32)
    return cv2.Laplacian(cv2.GaussianBlur(cut, (0, 0), BLUR_STD_PX), cv2.CV_32F)


def camera_motion_remarks(samples: Sequence[Frame], plane: SwimmingPlaneMap) -> tuple[str, ...]:
    """A remark where the corners moved together: a camera knocked, or a picture that drifts."""
    if len(samples) < 2:
        return ()
    moved = corner_shifts_of_camera_motion(corner_shifts(samples, plane), plane.corners_px)
    known = np.flatnonzero(np.isfinite(moved).all(axis=(1, 2)))
    if len(known) < 2:
        return ()
    apart = np.sqrt(np.mean(np.sum((moved[known, None] - moved[known]) ** 2, axis=3), axis=2))
    most = float(apart.max())
    if most < MIN_SHIFT_PX:
        return ()
    steps = np.diagonal(apart, offset=1)
    k = int(np.argmax(steps))
    if steps[k] > SUDDEN_SHIFT_SHARE * most:
        early, late = (samples[known[i]].time_s for i in (k, k + 1))
        what = f"the camera moved by about {most:.1f} px between {early:.2f} s and {late:.2f} s"
    else:
        what = f"the picture drifts by about {most:.1f} px, as stabilised footage does"
    return (f"{what} (seen at the pool's corners): the positions do not share one calibration",)


def corner_shifts_of_camera_motion(moved: Float, corners_px: Float) -> Float:
    """Shift (samples, corners, 2) px of each corner by the picture's common turn, scale and shift.

    NaN for a sample in which the corners do not agree on one (light that moves, a hand), or in
    which fewer than two corners are seen; two corners give a common shift alone.
    """
    out = np.full(moved.shape, np.nan)
    for i, step in enumerate(moved):
        seen = np.isfinite(step).all(axis=1)
        if seen.sum() < 2:
            continue
        places = corners_px[:, 0] + 1j * corners_px[:, 1]
        terms = np.column_stack([np.ones(len(places)), places - places[seen].mean()])
        terms = terms[:, : 2 if seen.sum() > 2 else 1]
        found = step[:, 0] + 1j * step[:, 1]
        common = terms @ np.linalg.lstsq(terms[seen], found[seen], rcond=None)[0]
        size = float(np.abs(common).max())
        if (
            np.abs(common - found)[seen].max()
            < AGREEMENT_TOLERANCE_PX + AGREEMENT_TOLERANCE_SHARE * size
        ):
            out[i] = np.column_stack([common.real, common.imag])
    return out
