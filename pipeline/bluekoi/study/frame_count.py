"""Recordings, or parts of them, that are too short for a pose over time."""

from __future__ import annotations

from ..data import MIN_POSE_FRAMES
from ..errors import input_error
from .types import Study, Trial


def check_frame_count(study: Study, trial: Trial, frames: int, fps: float) -> None:
    """Raises: InputError where a recording, or the part of it that start_s and end_s choose, has
    fewer than `MIN_POSE_FRAMES` frames.
    """
    if frames >= MIN_POSE_FRAMES:
        return
    count = f"{frames} frame{'' if frames == 1 else 's'}"
    expected = f"{MIN_POSE_FRAMES} at least, {MIN_POSE_FRAMES / fps:.2g} s at {fps:.4g} frames/s"
    part = {"start_s": trial.start_s, "end_s": trial.end_s}
    given = [f"{key} {value:g}" for key, value in part.items() if value is not None]
    if not given:
        raise input_error(study.paths(trial)[0], "", f"a recording of {count}", expected)
    raise input_error(
        study.root / "trials.csv", f"trial {trial.trial_id}, start_s, end_s",
        f"a part of {trial.source} with {count} ({', '.join(given)})", expected,
    )  # fmt: skip
