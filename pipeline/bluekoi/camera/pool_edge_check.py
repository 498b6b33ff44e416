"""Whether a recording shows the pool where the corners of study.yaml put it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..data import Float
from ..data.majority_deviation import deviations_from_majority
from ..study import Pool, StudySettings
from ..study.recording_pixels import setup_in_recording_pixels
from .boards import GreyPicture
from .pool_corner_fit import CLICK_ERROR_SHARE_OF_POOL_DIAGONAL, CornerFit, fit_corners
from .resection import pool_diagonal_px
from .study_camera import lens_of_camera_section, pool_corners_m

CAMERA_MOVED_SHARE_OF_POOL_DIAGONAL = 0.004
"""Edges farther from the corners given than this share of the pool's diagonal in the picture: twice
what `bluekoi pool` puts down to a corner given by eye.
"""


@dataclass(frozen=True)
class PoolEdgeCheck:
    """Edges of the pool in a frame against the corners of study.yaml.

    found: number of edges found. off_px, off_m: largest distance of a corner from where edges meet
    (of an edge where they do not), None where fewer than two edges were found. off_std_m: standard
    deviation of the least certain corner, None where an edge is missing. moved: whether that
    is more than corners given by eye are off; turned: whether the frame fits turned by 180 degrees.
    """

    found: int
    off_px: float | None
    off_m: float | None
    off_std_m: float | None
    moved: bool
    turned: bool

    @property
    def remarks(self) -> tuple[str, ...]:
        """A warning where the camera was moved or turned; else empty."""
        if self.turned:
            return ("the recording is turned by 180 degrees against the corners of study.yaml",)
        if not self.moved or self.off_m is None:
            return ()
        return (
            f"the pool's edges lie up to {self.off_px:.0f} px ({1000 * self.off_m:.0f} mm) from "
            "the corners of study.yaml: was the camera moved, or are the corners wrong?",
        )


def compare_pool_edges(grey: GreyPicture, setup: StudySettings) -> PoolEdgeCheck:
    """The pool's edges in one frame of a recording, against the corners of the study."""
    camera, corners_m = (
        setup_in_recording_pixels(setup, (grey.shape[1], grey.shape[0])).camera,
        pool_corners_m(setup),
    )
    given, lens = np.array(camera.pool_corners_px, dtype=float), lens_of_camera_section(camera)
    diagonal = pool_diagonal_px(given)
    fit = fit_corners(grey, given, lens, corners_m)
    off = _largest_corner_distance_px(fit, given)
    moved = off is not None and off > CAMERA_MOVED_SHARE_OF_POOL_DIAGONAL * diagonal
    turned = False
    if moved or off is None:
        about = np.array(grey.shape[::-1]) - 1.0 - given
        off_turned = _largest_corner_distance_px(fit_corners(grey, about, lens, corners_m), about)
        turned = (
            off_turned is not None and off_turned <= CAMERA_MOVED_SHARE_OF_POOL_DIAGONAL * diagonal
        )
    px_per_m = diagonal / float(np.linalg.norm(corners_m[2] - corners_m[0]))
    found = sum(line is not None for line in fit.lines)
    std = float(np.max(fit.std_px)) / px_per_m
    return PoolEdgeCheck(
        found=found,
        off_px=off,
        off_m=None if off is None else off / px_per_m,
        off_std_m=std if np.isfinite(std) else None,
        moved=moved,
        turned=turned,
    )


def deviating_pool_edges_m(
    statuses: Mapping[str, Mapping[str, Any]], pool: Pool
) -> dict[str, tuple[float, float]]:
    """Recordings whose pool edges are not where most others have them: distance from the corners of
    study.yaml there, and in most others, m. Recordings that show all four edges are compared;
    differences up to `CLICK_ERROR_SHARE_OF_POOL_DIAGONAL` are no deviation.

    statuses: content of status/ID.json by trial id.
    """
    seen = {name: found for name, status in statuses.items()
            if (found := status.get("pool_edges")) and found.get("off_std_m") is not None
            and found["off_m"] is not None}  # fmt: skip
    offset_m, std_m = (np.array([one[key] for one in seen.values()], dtype=float)
                       for key in ("off_m", "off_std_m"))  # fmt: skip
    least_m = CLICK_ERROR_SHARE_OF_POOL_DIAGONAL * float(np.hypot(pool.length_m, pool.width_m))
    deviation_m = deviations_from_majority(offset_m, std_m, least_m)
    return {name: (float(own), float(own - off))
            for name, own, off in zip(seen, offset_m, deviation_m, strict=True) if off}  # fmt: skip


def deviating_edge_warnings(statuses: Mapping[str, Mapping[str, Any]], pool: Pool) -> Iterator[str]:
    """A sentence for each of `deviating_pool_edges_m` that does not count as moved by itself."""
    for name, (own_m, majority_m) in deviating_pool_edges_m(statuses, pool).items():
        if not statuses[name]["pool_edges"]["moved"]:
            yield (
                f"Trial {name}: the pool's edges lie up to {1000 * own_m:.0f} mm from the corners "
                f"of study.yaml, in most other recordings {1000 * majority_m:.0f} mm. Was the "
                "camera moved or zoomed, or the picture cropped?"
            )


def _largest_corner_distance_px(fit: CornerFit, given_px: Float) -> float | None:
    if np.isfinite(fit.corners_px).all():
        return float(np.max(np.linalg.norm(fit.corners_px - given_px, axis=1)))
    ends = [np.max(np.abs(line.ends_px)) for line in fit.lines if line is not None]
    return float(np.max(ends)) if len(ends) >= 2 else None
