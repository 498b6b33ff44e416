"""Frames of recordings as the page shows them, and detections to draw on them."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from ..data import Float
from ..errors import input_error
from ..files import to_json_types
from ..study import Study
from .preview import preview_frames, preview_trial

JPEG_QUALITY = 90
Luma = npt.NDArray[np.uint8]


@lru_cache(maxsize=3)
def _cached_frames(
    paths: tuple[Path, ...], _stamps: tuple[int, ...], fps: float | None, first_s: float | None
) -> list[Any]:
    if first_s is None:
        return preview_frames(paths, fps=fps)
    return preview_frames(paths, fps=fps, part_s=(first_s, None), consecutive=True)


def frame_at_recording_share(
    paths: tuple[Path, ...], share: float, fps: float | None = None, first_s: float | None = None
) -> tuple[float, Luma]:
    """Time [s] and brightness of one of `FRAMES` frames, the nearest to a share of them.

    They are spread over the recording, or the first ones from `first_s` on.

    Raises: InputError where the recording cannot be read.
    """
    stamps = tuple(path.stat().st_mtime_ns if path.exists() else 0 for path in paths)
    some = _cached_frames(paths, stamps, fps, first_s)
    if not some:
        raise input_error(paths[0], "", "no frames", "a recording with frames")
    frame = some[round(min(max(share, 0.0), 1.0) * (len(some) - 1))]
    return frame.time_s, frame.luma


def encode_jpeg(picture: Luma) -> bytes:
    """A picture as jpeg."""
    good, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    assert good
    return data.tobytes()


def preview_as_json(study: Study, trial_id: str) -> dict[str, Any]:
    """`preview_trial` as json: what a job returns."""
    found = preview_trial(study, trial_id)
    return to_json_types({
        "trial_id": trial_id, "time_s": found.time_s, "names": found.names,
        "xy_px": points_as_json(found.xy_px), "likelihood": np.round(found.likelihood, 2),
        "remarks": found.remarks, "found": found.confident_frame_count, "frames": len(found.time_s),
        "size_px": found.size_px, "consecutive": found.consecutive,
    })  # fmt: skip


def points_as_json(points: Float) -> list[Any]:
    """Points as lists, a hundredth of a pixel; NaN as None."""
    return to_json_types(np.round(points, 2))
