"""Whether the camera stood still: the pool's corners, which do not move, compared over time."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from ...data import Frame
from .background import Image
from .plane import Plane

Float = npt.NDArray[np.float64]
PATCH_M = 0.16
LEAST_PX = 0.6
LEAST_RESPONSE = 0.15


def shifts(samples: Sequence[Frame], plane: Plane) -> Float:
    """Shift (samples, corners, 2) px of each pool corner against the first sample; NaN unseen.

    Phase correlation of the edges in a patch about each corner; only a clear peak counts.
    """
    found = np.full((len(samples), 4, 2), np.nan)
    for k, corner in enumerate(plane.corners_px):
        patches = [_patch(frame.luma, corner, plane) for frame in samples]
        first = patches[0]
        if first is None:
            continue
        window = cv2.createHanningWindow(first.shape[::-1], cv2.CV_32F)
        for i, patch in enumerate(patches):
            if patch is not None:
                moved, response = cv2.phaseCorrelate(first, patch, window)
                if response > LEAST_RESPONSE:
                    found[i, k] = moved
    return found


def _patch(luma: Image, corner: Float, plane: Plane) -> npt.NDArray[np.float32] | None:
    """Strength of the edges about a corner; None where it reaches out of the picture."""
    half = int(PATCH_M * plane.px_per_m)
    u, v = (round(float(value)) for value in corner)
    height, width = luma.shape
    if not (half <= u < width - half and half <= v < height - half):
        return None
    cut = cv2.GaussianBlur(luma[v - half : v + half, u - half : u + half], (0, 0), 1.5)
    return cv2.Laplacian(cut, cv2.CV_32F)


def camera_remarks(samples: Sequence[Frame], plane: Plane) -> tuple[str, ...]:
    """A remark where nearly all corners moved between two samples: nudged or stabilised."""
    if len(samples) < 2:
        return ()
    moved = shifts(samples, plane)
    for i in range(1, len(samples)):
        step = moved[i] - moved[i - 1]
        seen = step[np.isfinite(step).all(axis=1)]
        if len(seen) < 2:
            continue
        sizes = np.hypot(*seen.T)
        if np.mean(sizes > LEAST_PX) > 0.7:
            size = float(np.median(sizes))
            return (
                f"the camera moved by about {size:.1f} px between {samples[i - 1].time_s:.2f} s "
                f"and {samples[i].time_s:.2f} s (seen at the pool's corners): positions before "
                "and after do not share one calibration",
            )
    return ()
