"""Whether keypoints of a file lie in the picture that study.yaml describes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..data import Keypoints, is_confident
from ..errors import input_error

MARGIN_SHARE = 0.05
"""Points may lie outside of the picture by this share of its longer side; networks extrapolate."""
MAX_OUTSIDE_SHARE = 0.25
"""Share of the points that may lie further outside."""


def check_within_picture(path: Path, found: Keypoints, size_px: tuple[int, int] | None) -> None:
    """Nothing where most points lie in a picture of size_px (width, height), or that is unknown.

    Raises: InputError with the share outside of it and one such point.
    """
    points = found.xy_px[is_confident(found.likelihood) & np.isfinite(found.xy_px).all(axis=2)]
    if size_px is None or len(points) == 0:
        return
    beyond = np.maximum(-points, points - np.array(size_px)).max(axis=1)
    outside = beyond > MARGIN_SHARE * max(size_px)
    if outside.mean() <= MAX_OUTSIDE_SHARE:
        return
    u, v = points[outside][0]
    raise input_error(
        path, "", f"{100 * outside.mean():.0f} % of the points outside of the picture, such as "
        f"({u:.0f}, {v:.0f})", f"pixels of a picture of {size_px[0]} x {size_px[1]}",
        "Are they pixels of another size of picture, and is image_size_px that of the recording?",
    )  # fmt: skip
