"""All that is wrong with the files of a study, found without running it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from filecmp import cmp
from pathlib import Path
from typing import Any

import numpy as np

from ..camera import map_keypoints, pool_camera
from ..camera.picture_bounds import check_within_picture
from ..camera.turned_picture import half_turn_regression_sums
from ..data import MIN_POSE_FRAMES, Keypoints, is_confident
from ..errors import InputError, InputIssue, input_error
from ..files import to_json_types
from ..footage import open_recording
from ..keypoints import keypoint_source_module
from ..motor import flapping_as_json, flapping_from_log, trial_flapping
from ..motor.motor_log import motor_log_coverage
from ..motor.swimming_plausibility import median_tail_length_m, trial_list_text
from ..pose.common_mistakes import merge_common_mistakes
from ..pose.fit import usable_frames
from ..pose.head_tail_swap import undo_head_tail_swaps
from ..pose.plausibility import checked_rigid_pose
from ..pose.rigid_lengths import RIGID_PARTS
from ..pose.trial_comparison import body_measurements_as_json
from ..study import Study, StudySettings, Trial
from ..study.frame_count import check_frame_count
from ..study.recording_pixels import setup_in_recording_pixels

STATED_FREQUENCY_TOLERANCE_SHARE = 0.05
"""Relative difference of `flap_hz` and the frequency of the motor log above which they
contradict each other.
"""


def setup_findings(setup: StudySettings, folder: Path) -> tuple[list[InputIssue], tuple[str, ...]]:
    """What is wrong with detector and camera of a study.yaml, and remarks on the camera."""
    try:
        keypoint_source_module(setup.detection.source)
        return [], pool_camera(setup).remarks
    except InputError as found:
        return [_with_study_folder(folder, finding) for finding in found.findings], ()


def file_findings(study: Study) -> list[InputIssue]:
    """A finding for each source and motor log that a run could not read, and for shared sources."""
    return check_files(study)[0]


def check_files(
    study: Study, progress: Callable[[float], None] = lambda _: None
) -> tuple[list[InputIssue], dict[str, dict[str, Any]], dict[str, tuple[str, ...]]]:
    """`file_findings`; what the files of sound trials say of motor log, flapping frequency and
    tail, in the words of status/ID.json; and the remarks on the footage. The last two by trial id.

    progress: called with the share of the trials done.
    """
    found = _shared_source_findings(study)
    statuses: dict[str, dict[str, Any]] = {}
    remarks: dict[str, tuple[str, ...]] = {}
    for done, trial in enumerate(study.trials, 1):
        try:
            if trial.reads_keypoints:
                statuses[trial.trial_id] = _check_keypoints(study, trial)
            else:
                found_in_film, remarks[trial.trial_id] = _check_footage(study, trial)
                statuses[trial.trial_id] = {"ok": True, **found_in_film}
        except InputError as error:
            found += [_with_study_folder(study.root, one) for one in error.findings]
        progress(done / len(study.trials))
    return merge_common_mistakes(study, found), statuses, remarks


def recording_warnings(study: Study, remarks: Mapping[str, Sequence[str]]) -> list[str]:
    """A sentence for each remark on the footage, with all trials that it holds for.

    remarks: by trial id.
    """
    trials_of: dict[str, list[str]] = {}
    for name, texts in remarks.items():
        for text in texts:
            trials_of.setdefault(text, []).append(name)
    return [f"{trial_list_text(ids, len(study.trials))}: {text}" for text, ids in trials_of.items()]


def _with_study_folder(folder: Path, finding: InputIssue) -> InputIssue:
    """The finding with the study's folder before the bare name of its file."""
    bare = finding.file == Path(finding.file).name
    return replace(finding, file=str(folder / finding.file)) if bare else finding


def _shared_source_findings(study: Study) -> list[InputIssue]:
    """A finding for each pair of trials that take the same file whole, naming the first such."""
    found: dict[tuple[str, str], InputIssue] = {}
    owner: dict[Path, str] = {}
    same_as = _duplicate_files(
        {p for t in study.trials if not t.reads_images for p in study.paths(t)}
    )
    whole = [t for t in study.trials if t.start_s is None and t.end_s is None]
    for trial, path in ((t, p) for t in whole for p in study.paths(t)):
        original = same_as.get(path, path)
        if (first := owner.setdefault(original, trial.trial_id)) != trial.trial_id:
            copy = "" if original == path else f" (the same content as {original.name})"
            name = f"{path.name}, whole, as trial {first} has it{copy}"
            expected = "a file of its own, or a part of one by start_s and end_s"
            place = str(study.root / "trials.csv"), f"trial {trial.trial_id}"
            found.setdefault((first, trial.trial_id), InputIssue(*place, name, expected))
    return list(found.values())


def _duplicate_files(paths: set[Path]) -> dict[Path, Path]:
    """File -> the first file of the same content, for copies: they are no further measurement."""
    by_size: dict[int, list[Path]] = {}
    out = {}
    for path in sorted(p for p in paths if p.is_file()):
        alike = by_size.setdefault(path.stat().st_size, [])
        original = next((one for one in alike if cmp(one, path, shallow=False)), None)
        if original is None:
            alike.append(path)
        else:
            out[path] = original
    return out


def _check_keypoints(study: Study, trial: Trial) -> dict[str, Any]:
    """What a keypoint file says of flapping frequency and tail.

    Raises: InputError where a trial's motor log or keypoints cannot be read, where the keypoints
    cannot be those of the robot, or the log is of another time or contradicts flap_hz.
    """
    path = study.paths(trial)[0]
    found = keypoint_source_module("deeplabcut").read_keypoints_of_trial(
        path, trial, study.setup.bodyparts
    )
    given = study.setup.camera
    check_within_picture(path, found, given.image_size_px if given else None)
    check_frame_count(study, trial, len(found.time_s), trial.fps or 30.0)
    _check_usable_frames(path, found)
    camera, depth = pool_camera(study.setup), study.setup.robot.keypoint_depth_m
    positions, exchanged = undo_head_tail_swaps(
        map_keypoints(camera, found, depth), study.setup.robot, trial.head_length_m
    )
    pose = checked_rigid_pose(study, trial, positions)
    status = {
        "ok": True,
        "logged_share": _check_motor_log(study, trial, float(found.time_s[-1])),
        "flapping": flapping_as_json(trial_flapping(study, trial, positions)),
        "tail_m": median_tail_length_m(positions),
        "body": body_measurements_as_json(found, positions, pose, study.setup.robot, trial),
        "exchanged_frames": exchanged,
        "turned_picture": half_turn_regression_sums(camera, found, depth),
    }
    return dict(to_json_types(status))


def _check_footage(study: Study, trial: Trial) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Of the footage of a trial: size of its pictures, and share that its motor log covers (None
    without a log), with the keys of status/ID.json; and remarks.

    Raises: InputError where a trial's motor log or footage cannot be read, or the log is of another
    time or contradicts flap_hz.
    """
    film = open_recording(
        study.paths(trial), fps=trial.fps, start_s=trial.start_s, end_s=trial.end_s
    )
    setup_in_recording_pixels(study.setup, film.size_px, f"{trial.source} (trial {trial.trial_id})")
    _check_start_in_picture(study, trial, film.size_px)
    check_frame_count(study, trial, film.frame_count_in_part, film.fps or film.nominal_fps)
    end_s = film.duration_s if trial.end_s is None else min(trial.end_s, film.duration_s)
    logged = _check_motor_log(study, trial, end_s)
    return {"size_px": list(film.size_px), "logged_share": logged}, film.remarks


def _check_motor_log(study: Study, trial: Trial, end_s: float) -> float | None:
    """Share of the recording up to end_s that the motor log covers; None without a log.

    Raises: InputError where the log cannot be read, is of another time or contradicts flap_hz.
    """
    if (log := study.motor_path(trial)) is None:
        return None
    flapping = flapping_from_log(log)
    logged = motor_log_coverage(log, flapping, (trial.start_s or 0.0, end_s))
    _check_stated_frequency(study, trial, flapping.flap_hz)
    return logged


def _check_stated_frequency(study: Study, trial: Trial, log_hz: float) -> None:
    if (
        trial.flap_hz is not None
        and abs(trial.flap_hz / log_hz - 1) > STATED_FREQUENCY_TOLERANCE_SHARE
    ):
        raise input_error(
            study.root / "trials.csv", f"trial {trial.trial_id}, flap_hz", f"{trial.flap_hz:g}",
            f"{log_hz:.3g} Hz, as {trial.motor_log} has it",
            "Leave flap_hz empty where there is a log; is the log this trial's?",
        )  # fmt: skip


def _check_start_in_picture(study: Study, trial: Trial, size_px: tuple[int, int]) -> None:
    """Nothing where the stated start of the robot lies in its pictures.

    Raises: InputError with the place and the size of the pictures.
    """
    if trial.start_px is None:
        return
    (u, v), (width, height) = trial.start_px, size_px
    if u >= width or v >= height:
        raise input_error(
            study.root / "trials.csv", f"trial {trial.trial_id}, start_x_px, start_y_px",
            f"({u:g}, {v:g})", f"a pixel of the pictures of {width} x {height}",
            "Read the place off the first frame used.",
        )  # fmt: skip


def _check_usable_frames(path: Path, found: Keypoints) -> None:
    """Raises: InputError where fewer than `MIN_POSE_FRAMES` frames show a head direction and a
    core.
    """
    sure = dict(zip(found.names, is_confident(found.likelihood.T), strict=True))
    never = np.zeros(len(found.time_s), dtype=bool)
    frames = int(
        usable_frames(np.column_stack([sure.get(name, never) for name in RIGID_PARTS])).sum()
    )
    if frames < MIN_POSE_FRAMES:
        raise input_error(
            path, "", f"{frames} of {len(found.time_s)} frames with head_tip and two of "
            f"{', '.join(RIGID_PARTS[1:])} that count by their likelihood",
            f"{MIN_POSE_FRAMES} at least",
            "Are the likelihoods there, and are the names under bodyparts: the right ones?",
        )  # fmt: skip
