"""Whether one trial shows the robot that trials.csv and study.yaml describe.

Errors of a few percent (scale, clock, offsets) are found by the search for causes. Trials with
gross errors are refused here: exchanged keypoints, the row of another trial, a cut in the
recording. One such trial would bias the fit to all trials.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from ..data import Float, KeypointPositions, Pose
from ..errors import InputError, InputIssue, input_error
from ..study import Study, Trial
from . import rigid_pose
from .common_mistakes import HeadAngleFinding, LengthFinding, seems_in_radians
from .rigid_lengths import measured_rigid_lengths, trusted_points
from .trial_comparison import (
    LENGTH_ENDPOINTS_AND_KEYS,
    MAX_KEYPOINT_ERROR_BODY_LENGTHS,
    mean_head_angle_deg,
    stated_lengths,
    wrap_angle_deg,
)

MAX_LENGTH_ERROR_SHARE = 0.25
"""Largest error of a rigid part's length on the trial's scale; a larger one is accepted if it is at
most `MAX_KEYPOINT_ERROR_BODY_LENGTHS`."""
MAX_LENGTH_SCALE_RATIO = 1.5
"""Largest ratio of measured to stated lengths of all parts together, or its inverse."""
MAX_HEAD_ANGLE_ERROR_DEG = 25.0
"""Difference of commanded and measured head angle above which a trial is refused."""
OUTSIDE_POOL_SHARE, OUTSIDE_FRAMES_SHARE = 0.1, 0.25
"""A quarter of the frames further beyond a wall than this share of the pool's longer side."""
MIN_JUMP_LENGTHS, MAX_JUMP_DURATION_S, MIN_JUMP_STEP_RATIO = 0.5, 0.1, 10.0
"""A jump: half a body length and ten usual steps within 0.1 s, without coming back."""
JUMP_PERSISTENCE_FRAMES = 3
MAX_REPEATED_FRAMES_SHARE = 0.75
"""Share of the frames that may repeat the frame before, point by point: a recording whose rate was
raised by a player shows each picture up to four times."""
TRAVEL_DIRECTION_BASE_BODY_LENGTHS = 0.25
"""Directions of travel are taken over so many body lengths, at any frame rate."""


def checked_rigid_pose(study: Study, trial: Trial, positions: KeypointPositions) -> Pose:
    """`rigid_pose` of a trial that may be as it is.

    Raises: InputError with all that cannot be right about the trial.
    """
    source, place = study.paths(trial)[0], f"trial {trial.trial_id}"
    if frozen := _repeated_frames_findings(str(source), place, positions):
        raise InputError(frozen)
    try:
        pose = rigid_pose(positions, study.setup.robot, trial.head_length_m)
    except InputError as error:
        raise InputError([replace(f, file=str(source)) for f in error.findings]) from error
    except (np.linalg.LinAlgError, ArithmeticError) as error:
        raise input_error(
            source,
            place,
            "keypoints that no rigid body can have, such as several parts in one place",
            "head_tip, hinge, core_center and tail_base at their distances",
            "Look at the labels of this trial.",
        ) from error
    if wrong := plausibility_findings(study, trial, positions, pose):
        raise InputError(wrong)
    return pose


def plausibility_findings(
    study: Study, trial: Trial, positions: KeypointPositions, pose: Pose
) -> list[InputIssue]:
    """What cannot be right about a trial, with file, found, expected and remedy."""
    table, place = str(study.root / "trials.csv"), f"trial {trial.trial_id}"
    return [
        *_length_findings(table, place, study, trial, positions),
        *_part_order_findings(str(study.paths(trial)[0]), place, positions),
        *_head_angle_findings(table, place, trial, pose),
        *_outside_pool_findings(str(study.paths(trial)[0]), place, study, pose),
        *_backwards_findings(str(study.paths(trial)[0]), place, study, pose),
        *_jump_findings(str(study.paths(trial)[0]), place, study, pose),
    ]


def _repeated_frames_findings(
    source: str, place: str, positions: KeypointPositions
) -> list[InputIssue]:
    xy, _ = trusted_points(positions)
    xy = xy[np.isfinite(xy).any(axis=(1, 2))]
    same = [np.array_equal(a, b, equal_nan=True) for a, b in itertools.pairwise(xy)]
    if len(same) < 2 or np.mean(same) <= MAX_REPEATED_FRAMES_SHARE:
        return []
    share = 100 * np.mean(same)
    found = f"keypoints that stay in place, to the last digit, in {share:.0f} % of the frames"
    remedy = "Was the tracking stopped, or a lost robot filled in with its last place?"
    return [InputIssue(source, place, found, "keypoints measured in each frame", remedy)]


def _length_findings(
    table: str, place: str, study: Study, trial: Trial, positions: KeypointPositions
) -> list[InputIssue]:
    robot = study.setup.robot
    body = measured_rigid_lengths(*trusted_points(positions), robot, trial.head_length_m)
    names = [points for points, _ in LENGTH_ENDPOINTS_AND_KEYS.values()]
    seen = np.array([getattr(body, part) for part in LENGTH_ENDPOINTS_AND_KEYS])
    said = np.array(list(stated_lengths(robot, trial).values()))
    scale = float(np.median(seen / said)) if (said > 0).all() else 1.0
    if not 1 / MAX_LENGTH_SCALE_RATIO < scale < MAX_LENGTH_SCALE_RATIO:
        return [_length_scale_finding(place, study, scale)]
    off = np.abs(seen - scale * said)
    by_keypoints_m = MAX_KEYPOINT_ERROR_BODY_LENGTHS * robot.body_length_m
    bad = off > np.maximum(MAX_LENGTH_ERROR_SHARE * scale * said, by_keypoints_m)
    remedy = "Is head_length_m that of this trial, and does each keypoint bear its own name?"
    return [
        LengthFinding(
            table,
            place,
            f"{name} of {1000 * a:.0f} mm in the pool",
            f"{1000 * b:.0f} mm",
            remedy,
            trial_id=trial.trial_id,
            seen_m=tuple(seen.tolist()),
            stated_m=tuple(said.tolist()),
        )
        for name, a, b, wrong in zip(names, seen, said, bad, strict=True)
        if wrong
    ]


def _length_scale_finding(place: str, study: Study, scale: float) -> InputIssue:
    return InputIssue(
        str(study.root / "study.yaml"),
        place,
        f"a robot {scale:.2f} times as long as stated, in all its parts",
        "the lengths under robot, and head_length_m",
        "Are the keypoints of a picture of another size than the pool's corners, or is the pool's "
        "size wrong?",
    )


def _part_order_findings(source: str, place: str, positions: KeypointPositions) -> list[InputIssue]:
    xy, _ = trusted_points(positions)
    hinge, core, tail = xy[:, 1], xy[:, 2], xy[:, 3]
    along = np.sum((hinge - core) * (core - tail), axis=1)
    along = along[np.isfinite(along)]
    if len(along) == 0 or np.median(along) > 0:
        return []
    found = "hinge, core_center and tail_base in another order along the body"
    remedy = "Does each keypoint bear its own name? bodyparts: in study.yaml can exchange names."
    return [InputIssue(source, place, found, "this order, from the head to the tail", remedy)]


def _head_angle_findings(table: str, place: str, trial: Trial, pose: Pose) -> list[InputIssue]:
    seen = mean_head_angle_deg(pose)
    if not abs(wrap_angle_deg(seen - trial.head_angle_deg)) > MAX_HEAD_ANGLE_ERROR_DEG:
        return []
    found = f"a head angle of {seen:.0f} degrees in the second half of the recording"
    stated = trial.head_angle_deg
    return [
        HeadAngleFinding(
            table,
            place,
            found,
            f"head_angle_deg {stated:g}",
            _head_angle_remedy(seen, stated),
            trial_id=trial.trial_id,
            seen_deg=seen,
            stated_deg=stated,
        )
    ]


def _head_angle_remedy(seen_deg: float, stated_deg: float) -> str:
    """What a head angle that is not the stated one is usually due to."""
    if seems_in_radians(seen_deg, stated_deg):
        return "Is it in radians? Write degrees."
    convention = "head_angle_deg is positive where the head points to the robot's right."
    if abs(wrap_angle_deg(seen_deg + stated_deg)) > MAX_HEAD_ANGLE_ERROR_DEG / 2:
        return f"{convention} Is it another trial's row?"
    return (
        "The sign is the other one: change it in trials.csv if the head really turned to the other "
        f"side. {convention} If it did not, the picture is mirrored: are x and y exchanged in the "
        "keypoint file, or are the pool's corners in another order?"
    )


def _outside_pool_findings(source: str, place: str, study: Study, pose: Pose) -> list[InputIssue]:
    seen = pose.values[np.isfinite(pose.values[:, :2]).all(axis=1), :2]
    pool = study.setup.pool
    beyond = np.maximum(-seen, seen - np.array([pool.length_m, pool.width_m])).max(axis=1)
    out = beyond > OUTSIDE_POOL_SHARE * max(pool.length_m, pool.width_m)
    if len(seen) == 0 or out.mean() < OUTSIDE_FRAMES_SHARE:
        return []
    x, y = np.median(seen[out], axis=0)
    found = f"a robot outside of the pool, near x = {x:.2f} m, y = {y:.2f} m"
    expected = f"a robot within {pool.length_m:g} x {pool.width_m:g} m"
    remedy = (
        "Are these keypoints of the whole frame (not of a cropped or resized one), x before y, and "
        "pool_corners_px those of this recording?"
    )
    return [InputIssue(source, place, found, expected, remedy)]


def _backwards_findings(source: str, place: str, study: Study, pose: Pose) -> list[InputIssue]:
    seen = np.isfinite(pose.values[:, :3]).all(axis=1)
    xy, heading = pose.values[seen, :2], pose.values[seen, 2]
    length = study.setup.robot.body_length_m
    kept = waypoints(xy, TRAVEL_DIRECTION_BASE_BODY_LENGTHS * length)
    way, heading = np.diff(xy[kept], axis=0), heading[kept][:-1]
    gone = np.linalg.norm(way, axis=1)
    if gone.sum() < length:
        return []
    ahead = float(np.sum(way * np.column_stack([np.cos(heading), np.sin(heading)])))
    if ahead > 0:
        return []
    found = f"a robot that swims backwards for {gone.sum():.1f} m"
    remedy = "Head and tail seem exchanged: are head_length_m and head_angle_deg this trial's?"
    return [InputIssue(source, place, found, "a robot that swims ahead", remedy)]


def _jump_findings(source: str, place: str, study: Study, pose: Pose) -> list[InputIssue]:
    seen = np.isfinite(pose.values[:, :2]).all(axis=1)
    t, xy = pose.time_s[seen], pose.values[seen, :2]
    length = study.setup.robot.body_length_m
    at = first_jump(t, xy, MIN_JUMP_LENGTHS * length)
    if at is None:
        return []
    way = float(np.linalg.norm(xy[at + 1] - xy[at]))
    found = f"a robot that jumps {way:.2f} m between {t[at]:.2f} and {t[at + 1]:.2f} s"
    remedy = (
        "Is there a cut in the recording (start_s and end_s choose a part), another body, a "
        "keypoint that is missing in part of the frames, a gap filled in with the last pose, or "
        "fps far too high?"
    )
    return [InputIssue(source, place, found, "one path", remedy)]


def waypoints(xy_m: Float, apart_m: float) -> list[int]:
    """Frames of a path (n, 2) that are each `apart_m` or more from the one before."""
    kept = [0] if len(xy_m) else []
    for k, place in enumerate(xy_m):
        if np.linalg.norm(place - xy_m[kept[-1]]) >= apart_m:
            kept.append(k)
    return kept


def first_jump(time_s: Float, xy_m: Float, least_m: float) -> int | None:
    """Frame before the first jump of a path, (n,) s and (n, 2) m; None where there is none."""
    steps = np.linalg.norm(np.diff(xy_m, axis=0), axis=1)
    if len(steps) < 2:
        return None
    large = (steps > max(least_m, MIN_JUMP_STEP_RATIO * float(np.median(steps)))) & (
        np.diff(time_s) <= MAX_JUMP_DURATION_S
    )
    for k in np.flatnonzero(large).tolist():
        before, after = (
            xy_m[max(k - JUMP_PERSISTENCE_FRAMES, 0)],
            xy_m[min(k + 1 + JUMP_PERSISTENCE_FRAMES, len(xy_m) - 1)],
        )
        if np.linalg.norm(after - before) > 0.6 * steps[k]:
            return k
    return None
