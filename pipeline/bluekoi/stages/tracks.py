"""Pose, smoothed motion and steady state of one trial."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..camera.calibration_uncertainty import calibration_covariance_at_points
from ..camera.keypoint_displacement_field import remove_keypoint_displacements
from ..camera.picture_bounds import check_within_picture
from ..camera.pool_projection import PoolCamera, map_keypoints
from ..camera.study_camera import pool_camera
from ..camera.turned_picture import half_turn_regression_sums
from ..data import FlappingFrequency, SteadyState, Track, write_pose, write_track
from ..errors import InputError, input_error
from ..files import read_json
from ..keypoints import NO_ROBOT_REMARK
from ..keypoints.deeplabcut import read_detections
from ..motor import flapping_as_json, trial_flapping
from ..motor.swimming_plausibility import (
    CHECK_LENGTHS_REMEDY,
    dimensionless_swimming_numbers,
    implausible_numbers_text,
    median_tail_length_m,
)
from ..pose.gap_filled_frames import without_filled_frames
from ..pose.head_tail_swap import undo_head_tail_swaps
from ..pose.plausibility import checked_rigid_pose
from ..pose.trial_comparison import body_measurements_as_json
from ..smoothing import smoothed_track_and_noise_ratio
from ..smoothing.systematic_error import with_systematic_error
from ..steady import steady_state, write_steady
from ..study import Study, Trial, load_study
from .compiling import precompile_smoother as preload
from .depth import keypoint_depth
from .head_angle_sign import head_angle_sign_finding
from .keypoint_errors_file import displacements_of_trial
from .pool_edges import check_pool_edges
from .result_paths import ResultPaths
from .status import run_with_status

__all__ = ["preload", "tracks"]

MAX_MOTOR_CLOCK_DIFFERENCE_SHARE = 0.01
"""Clocks of motor and video that differ by a larger share make a steady speed doubtful."""


def tracks(study: Path, results: Path, trial_id: str, *, inputs: str = "") -> None:
    """Write poses/ID.csv, tracks/ID.csv, steady/ID.csv and how the trial went."""
    loaded, layout = load_study(study, only=trial_id), ResultPaths(results)
    trial = loaded.trial(trial_id)
    run_with_status(
        layout.status(trial_id),
        trial_id,
        lambda: _write_track(loaded, trial, layout),
        source=trial.source,
        products=layout.track_files(trial_id),
        inputs=inputs,
    )


def _write_track(study: Study, trial: Trial, layout: ResultPaths) -> dict[str, Any]:
    detection = read_json(layout.detection_status(trial.trial_id))
    if not detection["ok"]:
        return detection
    size = detection.get("size_px")
    camera = pool_camera(study.setup, (size[0], size[1]) if size else None)
    found = read_detections(layout.keypoints(trial.trial_id), trial)
    if trial.reads_keypoints and study.setup.camera:
        check_within_picture(study.paths(trial)[0], found, study.setup.camera.image_size_px)
    depth = keypoint_depth(study.setup, layout)
    displaced = displacements_of_trial(trial, layout)
    mapped = remove_keypoint_displacements(
        map_keypoints(camera, without_filled_frames(found), depth),
        displaced,
    )
    positions, exchanged = undo_head_tail_swaps(mapped, study.setup.robot, trial.head_length_m)
    try:
        pose = checked_rigid_pose(study, trial, positions)
    except InputError:
        if sign := head_angle_sign_finding(study, trial, camera, depth):
            raise InputError([sign]) from None
        if no_robot := _no_robot_error(study, trial, detection["remarks"]):
            raise no_robot from None
        raise
    flapping = trial_flapping(study, trial, positions)
    try:
        track, shown = smoothed_track_and_noise_ratio(pose, _flap_hz_in_video_clock(flapping))
        steady = _with_clock_remark(steady_state(track, flapping, trial.head_angle_rad), flapping)
    except (np.linalg.LinAlgError, FloatingPointError, ZeroDivisionError) as error:
        raise _smoothing_failed_error(study, trial, error) from error
    write_pose(layout.pose(trial.trial_id), pose)
    whole = _with_calibration_std(with_systematic_error(track, pose, shown), camera, depth)
    write_track(layout.track(trial.trial_id), whole)
    write_steady(layout.trial_steady(trial.trial_id), {trial.trial_id: steady})
    edges, moved = check_pool_edges(study, trial)
    remarks = [*moved, *detection["remarks"], *camera.remarks, *track.remarks, *flapping.remarks]
    if not study.setup.robot.keypoint_depth_given:
        remarks.append(
            f"keypoints taken to lie {1000 * depth:.0f} mm deep; study.yaml says nothing"
        )
    swimming = dimensionless_swimming_numbers(steady, flapping, positions, study.setup.robot)
    if odd := implausible_numbers_text([swimming]):
        remarks.append(f"{odd}. {CHECK_LENGTHS_REMEDY}")
    return {
        **detection,
        "remarks": list(dict.fromkeys(remarks)),
        "flapping": flapping_as_json(flapping),
        "swimming": swimming,
        "tail_m": median_tail_length_m(positions),
        "body": body_measurements_as_json(found, positions, pose, study.setup.robot, trial),
        "exchanged_frames": exchanged,
        "turned_picture": {} if displaced else half_turn_regression_sums(camera, found, depth),
        "pool_edges": edges,
    }


def _flap_hz_in_video_clock(flapping: FlappingFrequency) -> float:
    """Flapping frequency in the video's clock, where that is another than the motor's."""
    wrong = not flapping.agrees and np.isfinite(flapping.ratio)
    return flapping.flap_hz * (flapping.ratio if wrong else 1.0)


def _no_robot_error(study: Study, trial: Trial, remarks: Sequence[str]) -> InputError | None:
    """Where the detector found no robot: with the reason that it gives; else None."""
    reasons = [text.removeprefix(NO_ROBOT_REMARK) for text in remarks
               if text.startswith(NO_ROBOT_REMARK)]  # fmt: skip
    if not reasons:
        return None
    return input_error(
        study.paths(trial)[0],
        f"trial {trial.trial_id}",
        f"no robot by the detector ({reasons[0]})",
        "a robot that the detector finds",
        f"`bluekoi setup {study.root}` shows the detection in twenty frames of each video.",
    )


def _smoothing_failed_error(study: Study, trial: Trial, error: Exception) -> InputError:
    return input_error(
        study.paths(trial)[0],
        f"trial {trial.trial_id}",
        f"a motion that cannot be smoothed ({error})",
        "a path that a swimming robot can have",
        "Check fps, start_s and end_s in trials.csv, and the keypoints of this trial.",
    )


def _with_clock_remark(steady: SteadyState, flapping: FlappingFrequency) -> SteadyState:
    """The steady state; where the clocks disagree, the remark on that precedes other reasons."""
    if flapping.agrees or abs(flapping.ratio - 1) < MAX_MOTOR_CLOCK_DIFFERENCE_SHARE:
        return steady
    return replace(steady, reason="; ".join(filter(None, (flapping.remarks[-1], steady.reason))))


def _with_calibration_std(track: Track, camera: PoolCamera, depth_m: float) -> Track:
    """The track whose positions' deviations hold the calibration's, common to all frames."""
    cov = calibration_covariance_at_points(camera, np.column_stack([track.x_m, track.y_m]), depth_m)
    x, y = (
        np.hypot(np.sqrt(cov[:, 0, 0]), track.x_m_std),
        np.hypot(np.sqrt(cov[:, 1, 1]), track.y_m_std),
    )
    return replace(track, x_m_std=x, y_m_std=y)
