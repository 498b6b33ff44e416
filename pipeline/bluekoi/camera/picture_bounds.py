"""Whether keypoints of a file lie in the picture that study.yaml describes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..data import Float, Keypoints, is_confident
from ..errors import input_error

OUTSIDE_PICTURE_MARGIN_SHARE = 0.05
"""Points may lie outside of the picture by this share of its longer side; networks extrapolate."""
MAX_OUTSIDE_SHARE = 0.25
"""Share of the points that may lie further outside."""

MAX_NORMALISED_COORDINATE = 1.5
"""Coordinates that never exceed this are shares of the picture, not pixels."""
MIN_REPEATED_SENTINELS = 3
"""Measured places outside of the picture do not repeat to the last digit so often."""


def check_within_picture(path: Path, found: Keypoints, size_px: tuple[int, int] | None) -> None:
    """Nothing where most points lie in a picture of size_px (width, height), or that is unknown.

    Raises: InputError with the share outside of it and one such point, for coordinates from 0 to 1,
    and for a code of negative numbers that stands for a point that was not seen.
    """
    points = found.xy_px[is_confident(found.likelihood) & np.isfinite(found.xy_px).all(axis=2)]
    if len(points) == 0:
        return
    _refuse_normalised_or_sentinels(path, points)
    if size_px is None:
        return
    beyond = np.maximum(-points, points - np.array(size_px)).max(axis=1)
    outside = beyond > OUTSIDE_PICTURE_MARGIN_SHARE * max(size_px)
    if outside.mean() <= MAX_OUTSIDE_SHARE:
        return
    u, v = points[outside][0]
    raise input_error(
        path, "", f"{100 * outside.mean():.0f} % of the points outside of the picture, such as "
        f"({u:.0f}, {v:.0f})", f"pixels of a picture of {size_px[0]} x {size_px[1]}",
        "Are they pixels of another size of picture, and is image_size_px that of the recording?",
    )  # fmt: skip


def _refuse_normalised_or_sentinels(path: Path, points: Float) -> None:
    """Nothing for points (n, 2) that can be pixels."""
    if np.all((points >= 0) & (points <= MAX_NORMALISED_COORDINATE)):
        found = f"coordinates from {points.min():.3g} to {points.max():.3g}"
        remedy = "If they are shares of the picture, multiply x by its width and y by its height."
        raise input_error(path, "", found, "pixels", remedy)
    negative = points[(points < 0).all(axis=1)]
    places, counts = np.unique(negative, axis=0, return_counts=True)
    if len(counts) and counts.max() >= MIN_REPEATED_SENTINELS:
        u, v = places[np.argmax(counts)]
        remedy = "If this means not seen, leave x and y empty there, or set the likelihood to 0."
        raise input_error(path, "", f"the place ({u:g}, {v:g}), to the last digit, "
                          f"{counts.max()} times", "pixels in the picture", remedy)  # fmt: skip
