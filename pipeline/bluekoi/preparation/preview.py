"""The detection on a few frames of a trial, to see before a run whether and why it fails."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from ..data import MIN_KEYPOINT_LIKELIHOOD, Float, Frame, Keypoints
from ..errors import input_error
from ..footage import frames, open_recording
from ..keypoints import keypoint_source_module
from ..study import Study, Trial
from ..study.recording_pixels import setup_in_recording_pixels

PREVIEWED_FRAMES = 20
MIN_CONFIDENT_FRAMES_SHARE = 0.5
"""Share of the frames below which the preview looks for a reason."""


@dataclass(frozen=True)
class Preview:
    """Detections on frames spread over a trial, or on its first ones (`consecutive`).

    time_s: (n,). xy_px: (n, parts, 2) of `names`, NaN where not seen. likelihood: (n,) the least of
    the parts. remarks: what the detector says, the reason where it found nothing. size_px: width
    and height of the pictures.
    """

    trial_id: str
    time_s: Float
    names: tuple[str, ...]
    xy_px: Float
    likelihood: Float
    remarks: tuple[str, ...]
    size_px: tuple[int, int]
    consecutive: bool = False

    @property
    def confident_frame_count(self) -> int:
        """Frames in which every part is confident."""
        return int(np.sum(self.likelihood >= MIN_KEYPOINT_LIKELIHOOD))


def preview_frames(
    paths: Sequence[Path], *, fps: float | None = None, part_s: tuple[float | None, float | None] =
    (None, None), colour: bool = False, consecutive: bool = False, count: int = PREVIEWED_FRAMES,
) -> list[Frame]:  # fmt: skip
    """At most `count` frames of the part (start, end) of a recording, numbered: evenly spread, or
    the first ones.

    Raises: InputError where the recording cannot be read.
    """
    recording = open_recording(paths, fps=fps, start_s=part_s[0], end_s=part_s[1])
    film = frames(recording, colour=colour)
    if consecutive:
        found = list(islice(film, count))
    elif colour:
        step = max(1, recording.frames_present // count)
        found = [frame for i, frame in enumerate(film) if i % step == step // 2]
    else:
        found = list(film.evenly_spaced(count))
    if not found:
        return []
    chosen = np.unique(np.linspace(0, len(found) - 1, count).round().astype(int))
    return [replace(found[i], index=k) for k, i in enumerate(chosen)]


def preview_trial(study: Study, trial_id: str) -> Preview:
    """The detection on `PREVIEWED_FRAMES` frames of a trial, spread over it.

    Of a trial with start_x_px and start_y_px, the first frames: among several bodies the intended
    one can only be followed from frame to frame.

    Raises: InputError where the trial has no footage or it cannot be read.
    """
    trial = study.trial(trial_id)
    detector = keypoint_source_module(study.setup.detection.source)
    some = preview_frames(
        study.paths(trial), fps=trial.fps, part_s=(trial.start_s, trial.end_s),
        colour=getattr(detector, "NEEDS_COLOUR", False), consecutive=trial.start_px is not None,
    )  # fmt: skip
    if not some:
        raise input_error(trial.source, "", "no frames", "footage with frames")
    height, width = some[0].luma.shape
    setup = setup_in_recording_pixels(study.setup, (width, height), trial.source)

    def detect(trial: Trial) -> Keypoints:
        return detector.detect_keypoints(lambda: some, setup, trial)

    found = detect(trial)
    return Preview(
        trial_id=trial_id,
        time_s=found.time_s,
        names=found.names,
        xy_px=found.xy_px,
        likelihood=found.likelihood.min(axis=1),
        remarks=(*found.remarks, *_reason_for_few_detections(found, trial, detect)),
        size_px=(width, height),
        consecutive=trial.start_px is not None,
    )


def _confident_frame_count(found: Keypoints) -> int:
    return int(np.sum(found.likelihood.min(axis=1) >= MIN_KEYPOINT_LIKELIHOOD))


def _reason_for_few_detections(
    found: Keypoints, trial: Trial, detect: Callable[[Trial], Keypoints]
) -> tuple[str, ...]:
    """Why a body that was drawn is hardly ever found with confidence; empty where it is found, or
    where the detector says why.
    """
    count = len(found.time_s)
    if (
        _confident_frame_count(found) >= MIN_CONFIDENT_FRAMES_SHARE * count
        or not np.isfinite(found.xy_px).any()
    ):
        return ()
    if angle := trial.head_angle_deg:
        mirrored = _confident_frame_count(
            detect(trial.model_copy(update={"head_angle_deg": -angle}))
        )
        if mirrored >= MIN_CONFIDENT_FRAMES_SHARE * count:
            return (
                f"with head_angle_deg {-angle:g} the robot is found in {mirrored} of {count} "
                f"frames: is the sign of {angle:g} wrong? It is positive where the head points "
                "to the robot's right",
            )
    if found.remarks:
        return ()
    return (
        "a body is there, but it does not fit the stated lengths and head angle: compare the drawn "
        "points with the robot; check head_length_m and head_angle_deg of the trial",
    )
