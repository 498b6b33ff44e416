"""Detections of one trial, from its footage or its keypoint file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import keypoints as sources
from ..data import Float, Frame, Keypoints
from ..errors import InputError, input_error
from ..keypoints.deeplabcut import detector_of_file, write_keypoints_csv
from ..study import Study, Trial, load_study, missing_files_of_trial
from ..study.frame_count import check_frame_count
from .result_paths import ResultPaths
from .status import run_with_status

MIN_LOST_FRAMES = 3
"""Frames in a row without the body that are reported."""
MAX_LENGTH_SAMPLES = 80
"""Frames of a trial whose whole length is kept; more add no information."""


def keypoints(
    study: Path, results: Path, trial_id: str, *, threads: int = 1, inputs: str = ""
) -> None:
    """Write keypoints/ID.csv, its covariances and how it went."""
    loaded, layout = load_study(study, only=trial_id), ResultPaths(results)
    trial = loaded.trial(trial_id)
    run_with_status(
        layout.detection_status(trial_id),
        trial_id,
        lambda: _write_detection(loaded, trial, layout.keypoints(trial_id), threads),
        source=trial.source,
        products=layout.detection_files(trial_id),
        stale=layout.track_files(trial_id),
        inputs=inputs,
    )


def _write_detection(study: Study, trial: Trial, path: Path, threads: int) -> dict[str, Any]:
    if missing := missing_files_of_trial(study, trial):
        raise InputError(missing)
    found, notes = (
        _read_keypoint_file(study, trial)
        if trial.reads_keypoints
        else detect_in_footage(study, trial, threads)
    )
    if len(found.time_s) == 0:
        raise input_error(
            study.paths(trial)[0], "", "no frames", "frames between start_s and end_s"
        )
    detector = notes["source"] if notes["source"] != "deeplabcut" else ""
    stated_m = study.setup.robot.whole_length_m(trial.head_length_m)
    write_keypoints_csv(path, found, detector, stated_length_m=stated_m)
    notes = notes | {"length_seen": sampled_whole_lengths(found)}
    return {"remarks": list(found.remarks), "frames_read": len(found.time_s), **notes}


def sampled_whole_lengths(found: Keypoints) -> list[list[float]] | None:
    """Pairs frame, whole length seen over stated, of some frames all over the recording; None where
    the source does not measure it.
    """
    if found.length_seen is None:
        return None
    frames = np.flatnonzero(np.isfinite(found.length_seen))
    some = frames[:: max(1, -(-len(frames) // MAX_LENGTH_SAMPLES))]
    return [[int(i), float(found.length_seen[i])] for i in some]


def _read_keypoint_file(study: Study, trial: Trial) -> tuple[Keypoints, dict[str, Any]]:
    path = study.paths(trial)[0]
    found = sources.keypoint_source_module("deeplabcut").read_keypoints_of_trial(
        path, trial, study.setup.bodyparts,
        stated_length_m=study.setup.robot.whole_length_m(trial.head_length_m),
    )  # fmt: skip
    check_frame_count(study, trial, len(found.time_s), trial.fps or 30.0)
    source = detector_of_file(path) or "deeplabcut"
    return found, {"source": source, "frames_declared": len(found.time_s)}


def detect_in_footage(study: Study, trial: Trial, threads: int) -> tuple[Keypoints, dict[str, Any]]:
    """Keypoints of a filmed trial, and what was read: source, frames, picture size, missing end."""
    import cv2  # noqa: PLC0415  only where there is footage

    from ..footage import frames, open_recording  # noqa: PLC0415
    from ..footage.video_probe import TRUNCATED_FILE_REMARK  # noqa: PLC0415
    from ..study.recording_pixels import setup_in_recording_pixels  # noqa: PLC0415

    cv2.setNumThreads(threads)
    detector = sources.keypoint_source_module(study.setup.detection.source)
    recording = open_recording(
        study.paths(trial), fps=trial.fps, start_s=trial.start_s, end_s=trial.end_s
    )
    check_frame_count(
        study, trial, recording.frame_count_in_part, recording.fps or recording.nominal_fps
    )
    colour = getattr(detector, "NEEDS_COLOUR", False)

    def film() -> Iterable[Frame]:
        return frames(recording, colour=colour)

    found = detector.detect_keypoints(
        film, setup_in_recording_pixels(study.setup, recording.size_px), trial
    )
    short = recording.frames_present < recording.frames_declared and trial.end_s is None
    unreadable = unreadable_frames_remark(trial, recording, found.time_s)
    recorded = [text for text in recording.remarks if not (short and TRUNCATED_FILE_REMARK in text)]
    return replace(found, remarks=(*recorded, *found.remarks, *unreadable)), {
        "source": study.setup.detection.source,
        "frames_declared": recording.frames_declared,
        "size_px": list(recording.size_px),
        "cut_short": _truncation_remark(study, trial, recording) if short else "",
    }


def unreadable_frames_remark(trial: Trial, recording: Any, time_s: Float) -> tuple[str, ...]:
    """A remark where pictures in the midst of a whole recording could not be read; time_s of those
    that could. Pictures that are missing from a folder have a remark of the recording.
    """
    present = len(recording.paths) if trial.reads_images else recording.frames_present
    lost = present - len(time_s)
    whole = trial.start_s is None and trial.end_s is None
    if not whole or lost < MIN_LOST_FRAMES or len(time_s) < 2:
        return ()
    if trial.reads_images:
        return (f"{lost} of {present} pictures could not be read: copy them again",)
    step = np.diff(time_s)
    at = int(np.argmax(step))
    return (
        f"{lost} of {recording.frames_present} frames could not be read, the longest hole "
        f"{step[at]:.2f} s after {time_s[at]:.2f} s: copy the file again from the card",
    )


def _truncation_remark(study: Study, trial: Trial, recording: Any) -> str:
    """What to say of a recording that holds fewer frames than it declares; it is used so far."""
    return str(
        input_error(
            study.paths(trial)[-1],
            f"trial {trial.trial_id}",
            f"{recording.frames_present} of {recording.frames_declared} declared frames",
            "all of them",
            "Copy it again from the card, or set end_s in trials.csv to accept what is there; "
            "the readable frames were used.",
        )
    )
