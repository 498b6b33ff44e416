"""A scale that the rigid lengths contradict while the verdict names no error of measurement."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .distances import LENGTH_STD_SHARE

SIGMAS = 5.0
SCALE_CAUSES = ("scale_error", "uncorrected_refraction", "lens_error", "sinking")
"""Causes that account for rigid lengths of another size."""


def scale_warning(
    geometry: Mapping[str, Any] | None, mismatch: Mapping[str, Any] | None
) -> list[str]:
    """One sentence where rigid lengths differ from study.yaml by more than twice the accuracy to
    which lengths are measured, and the verdict does not say why; else nothing.

    geometry, mismatch: content of geometry.json and mismatch.json.
    """
    scale, std = ((geometry or {}).get(key) for key in ("scale", "scale_std"))
    if scale is None or std is None:
        return []
    off = float(scale) - 1.0
    named = {cause["name"] for cause in (mismatch or {}).get("causes") or []}
    if abs(off) < max(2 * LENGTH_STD_SHARE, SIGMAS * float(std)) or named & set(SCALE_CAUSES):
        return []
    return [
        f"The robot's rigid lengths come out {100 * off:+.1f} +- {100 * float(std):.1f} % against "
        "study.yaml and trials.csv, and the verdict does not say why: speeds and radii may be off "
        "by as much. Check the pool's size, pool_corners_px, refractive_index, keypoint_depth_m "
        "and the robot's lengths."
    ]
