"""Frames of a keypoint file that were filled in afterwards instead of measured.

Between two measured frames, a filled gap holds points on straight lines, or the last pose again.
Measured points scatter by a hundredth of a pixel or more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..data import Float, Keypoints

COORDINATE_DECIMALS = (2, 3)
"""Coordinates are taken to be written with two decimals if they have no more, else with three. The
second difference of a straight line is then at most twice the last digit."""
FLOAT_ROUNDING_TOLERANCE_PX = 1e-6
MIN_FILLED_FRAMES = 8
"""Frames of a gap from which it is named."""
MIN_SECOND_DIFFERENCE_RATIO = 5.0
"""Second difference where a filled gap meets a measured frame, over the largest one that a straight
line has by rounding. Keypoints that were smoothed over time are straight for several frames as
well, but their second difference grows gradually. In the demo's 24 trials, gaps of 8 to 15 frames,
filled on straight lines or with the last pose, have 465 or more (135 gaps), and keypoints smoothed
over 5 to 31 frames 1.5 at most (7 such stretches)."""
MIN_LIKELIHOOD = 0.5
"""Points below are not stated as measured: detectors fill gaps with such points themselves."""
MIN_TRAVEL_SINCE_START_PX = 2.0
"""Travel of a keypoint after which the robot is said to have started: before, it rests."""


def without_filled_frames(keypoints: Keypoints) -> Keypoints:
    """Keypoints whose likelihood is 0 in all frames that were filled in."""
    likelihood = keypoints.likelihood.copy()
    for first, end in _filled_gaps(keypoints):
        likelihood[first:end] = 0.0
    return replace(keypoints, likelihood=likelihood)


def longest_filled_gap(keypoints: Keypoints) -> dict[str, Any] | None:
    """Longest stretch of frames that were filled in: `from_s`, `to_s`, `frames`; None if none."""
    gaps = _filled_gaps(keypoints)
    if not gaps:
        return None
    first, end = max(gaps, key=lambda gap: gap[1] - gap[0])
    times = keypoints.time_s[first:end]
    return {"from_s": float(times[0]), "to_s": float(times[-1]), "frames": end - first}


def _filled_gaps(keypoints: Keypoints) -> list[tuple[int, int]]:
    """First frame, and frame after the last one, of each gap that was filled in."""
    xy = np.where(keypoints.likelihood[:, :, None] >= MIN_LIKELIHOOD, keypoints.xy_px, np.nan)
    second_differences = np.abs(np.diff(xy, n=2, axis=0)).reshape(max(len(xy) - 2, 0), -1)
    limit = 2.0 * _last_digit_px(xy).reshape(len(xy), -1)
    limit = np.maximum(np.maximum(limit[:-2], limit[1:-1]), limit[2:]) + FLOAT_ROUNDING_TOLERANCE_PX
    straight = np.isfinite(second_differences).any(axis=1) & ~(second_differences > limit).any(
        axis=1
    )
    travel = np.linalg.norm(xy - xy[:1], axis=2)
    straight &= np.maximum.accumulate((travel > MIN_TRAVEL_SINCE_START_PX).any(axis=1))[1:-1]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], straight.astype(int), [0]])))
    runs = edges.reshape(-1, 2) + 1  # a second difference belongs to the frame in its middle
    ratios = np.nan_to_num(np.pad(second_differences / limit, ((1, 1), (0, 0))), nan=0.0).max(
        axis=1
    )
    return [
        (int(first), int(end)) for first, end in runs
        if end - first >= MIN_FILLED_FRAMES
        and max(ratios[first - 1], ratios[min(end, len(ratios) - 1)]) > MIN_SECOND_DIFFERENCE_RATIO
    ]  # fmt: skip


def _last_digit_px(xy: Float) -> Float:
    """Last digit with which coordinates are written: programs that write six digits in all leave
    two decimals from 1000 px on.
    """
    coarse, fine = (10.0**-decimals for decimals in COORDINATE_DECIMALS)
    with np.errstate(invalid="ignore"):
        is_coarse = (
            np.abs(xy / coarse - np.round(xy / coarse)) < FLOAT_ROUNDING_TOLERANCE_PX / coarse
        )
    return np.where(is_coarse, coarse, fine)


def filled_gap_warnings(gaps: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """One sentence on the filled frames of all trials that have some. gaps: by trial."""
    if not gaps:
        return []
    places = ", ".join(f"{name} from {gap['from_s']:.2f} to {gap['to_s']:.2f} s"
                       for name, gap in gaps.items())  # fmt: skip
    return [
        f"In trial{'s' if len(gaps) > 1 else ''} {places}, each keypoint repeats its step from one "
        "frame to the next exactly, or stands still. These frames were filled in and not measured. "
        f"They and other such gaps of {MIN_FILLED_FRAMES} frames or more are not used; shorter "
        "gaps cannot be distinguished from measured frames. Leave the cells of every frame that "
        "was not measured empty."
    ]
