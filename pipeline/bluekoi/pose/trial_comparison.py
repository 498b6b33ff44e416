"""What the trials of a study show of the robot, compared with each other and with study.yaml.

Errors that are too small to refuse a trial by itself stand out beside the other trials: a head
angle that only one trial has wrong, files of two trials exchanged, a recording that is part of
another one, a body whose lengths are the same in all trials but not those of study.yaml.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from ..data import Float, KeypointPositions, Keypoints, Pose
from ..data.majority_deviation import deviations_from_majority
from ..study import Robot, Study, Trial
from .gap_filled_frames import filled_gap_warnings, longest_filled_gap
from .rigid_lengths import measured_rigid_lengths, trusted_points

MIN_HEAD_ANGLE_DEVIATION_DEG = 2.0
"""Head angles that deviate less from those of the other trials are a servo's accuracy: seven times
its usual repeatability."""
MIN_ANGLES_FOR_SERVO_GAIN = 4
"""Different stated angles that show an error of the servo's gain beside one wrong angle."""
MAX_KEYPOINT_ERROR_BODY_LENGTHS = 0.06
"""ASSUME largest error of a length that misplaced keypoints explain: 2 cm of the published robot.
Larger ones are those of another robot, head or body part, and the trial is refused."""
MIN_PART_ERROR_SHARE, MIN_PART_ERROR_BODY_LENGTHS = 0.05, 0.024
"""ASSUME error of one part's length beside the others above which the lengths of study.yaml are
doubted, both as a share and in body lengths (8 mm of the published robot). In the 32 simulated
studies of docs/evidence.md (`tidal_lock` 9405, `harbour_dock` 9204, `campus_pool` 5871) it is 2.6 %
and 1.1 mm at most; people place keypoints less accurately."""
FRAME_HASHES, MIN_COMMON_HASHES = 64, 4
"""Frames of a trial that are compared with those of others: those with the smallest hashes (bottom
sketch; Broder, Proc. SEQUENCES 1997, 21), and how many two trials may not have in common."""
LENGTH_ENDPOINTS_AND_KEYS = {
    "head_m": ("head_tip to hinge", "head_length_m in trials.csv"),
    "hinge_m": ("hinge to core_center", "robot.hinge_to_com_m"),
    "tail_m": (
        "core_center to tail_base",
        "robot.body_length_m - robot.head_length_m - robot.hinge_to_com_m",
    ),
}
"""Length -> the keypoints between which it is measured, and the keys that state it."""
MIN_FRAMES_WITH_POSE_SHARE = 0.5
"""Share of the frames of a trial with a pose, below which most of its track is interpolated: there
is a warning."""
STRAIGHT_TAIL_QUANTILE = 0.95
"""ASSUME quantile of the distance from core_center to tail_tip that stands for a straight tail: a
beating tail is straight twice a beat, where the distance is largest, and single frames have errors.
"""


def body_measurements_as_json(
    keypoints: Keypoints, positions: KeypointPositions, pose: Pose, robot: Robot, trial: Trial
) -> dict[str, Any]:
    """Head angle and lengths of a trial, as status/ID.json holds them, and hashes of its frames."""
    body = measured_rigid_lengths(*trusted_points(positions), robot, trial.head_length_m)
    stated = stated_lengths(robot, trial)
    return {
        "head_angle_deg": mean_head_angle_deg(pose),
        "length_ratios": {
            name: getattr(body, name) / length for name, length in stated.items() if length > 0
        },
        "core_to_tail_tip_m": _core_to_tail_tip_m(positions),
        "pose_share": float(np.isfinite(pose.values).all(axis=1).mean()),
        "frame_hashes": _frame_hashes(keypoints),
        "filled_gap": longest_filled_gap(keypoints),
    }


def _core_to_tail_tip_m(positions: KeypointPositions) -> float | None:
    """Distance from core_center to tail_tip with a straight tail, where tail_base is not tracked,
    which would show the length of the core; else None.
    """
    base_seen = "tail_base" in positions.names and np.isfinite(positions.part("tail_base")).any()
    if base_seen or not {"core_center", "tail_tip"} <= {*positions.names}:
        return None
    apart = np.linalg.norm(positions.part("tail_tip") - positions.part("core_center"), axis=1)
    apart = apart[np.isfinite(apart)]
    return float(np.quantile(apart, STRAIGHT_TAIL_QUANTILE)) if len(apart) else None


def mean_head_angle_deg(pose: Pose) -> float:
    """Mean head angle in the second half of a recording, deg; NaN where it is not seen."""
    angle = pose.values[len(pose.values) // 2 :, 3]
    angle = angle[np.isfinite(angle)]
    return float(np.degrees(np.angle(np.exp(1j * angle).mean()))) if len(angle) else float("nan")


def comparison_warnings(study: Study, statuses: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A sentence for each doubt that the trials raise together. statuses: by trial id."""
    trials = {trial.trial_id: trial for trial in study.trials}
    seen = _body_measurements(trials, statuses)
    return [
        *_head_angle_warnings(trials, statuses),
        *_repeated_recording_warnings(seen),
        *_length_warnings(study.setup.robot, trials, seen),
        *_tail_tip_warnings(study.setup.robot, seen),
        *_interpolated_track_warnings(seen),
        *filled_gap_warnings({n: gap for n, r in seen.items() if (gap := r.get("filled_gap"))}),
    ]


def _body_measurements(
    trials: Mapping[str, Trial], statuses: Mapping[str, Mapping[str, Any]]
) -> dict[str, Mapping[str, Any]]:
    """`body_measurements_as_json` of the trials that have a track."""
    return {
        name: record
        for name, status in statuses.items()
        if status.get("ok") and name in trials and (record := status.get("body"))
    }


def stated_lengths(robot: Robot, trial: Trial) -> dict[str, float]:
    """Lengths (m) that study.yaml and trials.csv state, as in `LENGTH_ENDPOINTS_AND_KEYS`."""
    return {
        "head_m": trial.head_length_m,
        "hinge_m": robot.hinge_to_com_m,
        "tail_m": robot.com_to_tail_base_m,
    }


def _frame_hashes(keypoints: Keypoints) -> list[str]:
    """The smallest hashes of the frames in which four numbers or more were measured."""
    rows = np.round(keypoints.xy_px.reshape(len(keypoints.time_s), -1), 2)
    moving = np.isfinite(rows).sum(axis=1) >= 4
    digests = {hashlib.blake2b(row.tobytes(), digest_size=6).hexdigest() for row in rows[moving]}
    return sorted(digests)[:FRAME_HASHES]


@dataclass(frozen=True)
class HeadAngleComparison:
    """Head angles that contradict trials.csv.

    angles_deg: trial -> head angle in the recording. deviating: trials that differ from the stated
    angle otherwise than most do. exchanged: trial -> another one, where each shows the angle that
    the other states.
    """

    angles_deg: Mapping[str, float]
    deviating: tuple[str, ...]
    exchanged: Mapping[str, str]

    @property
    def contradicted(self) -> tuple[str, ...]:
        """Trials whose head angle is not the stated one."""
        return tuple(dict.fromkeys([*self.deviating, *self.exchanged]))


def compare_head_angles(
    trials: Mapping[str, Trial], statuses: Mapping[str, Mapping[str, Any]]
) -> HeadAngleComparison:
    """Head angles in the recordings beside those of trials.csv. statuses: by trial id."""
    angles = {n: a for n, r in _body_measurements(trials, statuses).items()
              if (a := r.get("head_angle_deg")) is not None}  # fmt: skip
    off = {n: wrap_angle_deg(a - trials[n].head_angle_deg) for n, a in angles.items()}
    stated = np.array([trials[n].head_angle_deg for n in off])
    residuals = _without_servo_gain_error(np.array(list(off.values())), stated)
    odd = deviations_from_majority(residuals, np.zeros(len(off)), MIN_HEAD_ANGLE_DEVIATION_DEG)
    wrong = [name for name, by in off.items() if abs(by) > MIN_HEAD_ANGLE_DEVIATION_DEG]
    exchanged = {
        name: other
        for one, two in combinations(wrong, 2)
        if _head_angle_agrees(angles[one], trials[two])
        and _head_angle_agrees(angles[two], trials[one])
        for name, other in ((one, two), (two, one))
    }
    deviating = tuple(name for name, by in zip(off, odd, strict=True) if by)
    return HeadAngleComparison(angles, deviating, exchanged)


def _without_servo_gain_error(off_deg: Float, stated_deg: Float) -> Float:
    """Differences (n,) less their part in proportion to the stated angles, which is an error of the
    servo's gain that all trials share (slope of Theil and Sen).
    """
    if len(np.unique(stated_deg)) < MIN_ANGLES_FOR_SERVO_GAIN:
        return off_deg
    one, two = (np.array(k) for k in zip(*combinations(range(len(off_deg)), 2), strict=True))
    apart = stated_deg[two] != stated_deg[one]
    rise, run = (v[two][apart] - v[one][apart] for v in (off_deg, stated_deg))
    return np.asarray(off_deg - np.median(rise / run) * stated_deg)


def _head_angle_warnings(
    trials: Mapping[str, Trial], statuses: Mapping[str, Mapping[str, Any]]
) -> Iterator[str]:
    found = compare_head_angles(trials, statuses)
    for name in found.contradicted:
        text = f"Trial {name}: the head is turned by {found.angles_deg[name]:.0f} degrees"
        stated = f"head_angle_deg is {trials[name].head_angle_deg:g}"
        if other := found.exchanged.get(name):
            yield f"{text}, as trial {other} states, and {stated}. Are their files exchanged?"
        elif any(_head_angle_agrees(found.angles_deg[name], trial) for trial in trials.values()):
            yield (
                f"{text}, {stated}, and the other trials agree with theirs better. Is it the file "
                "of another trial?"
            )
        else:
            yield (
                f"{text}, {stated}, and the other trials agree with theirs better. No trial states "
                "that angle. Was the head set differently, or is the camera's lens or depth wrong, "
                "which changes angles most near the edges of the picture?"
            )


def _head_angle_agrees(angle_deg: float, trial: Trial) -> bool:
    return abs(wrap_angle_deg(angle_deg - trial.head_angle_deg)) <= MIN_HEAD_ANGLE_DEVIATION_DEG


def wrap_angle_deg(angle_deg: float) -> float:
    """An angle as a turn from -180 to 180 degrees."""
    return (angle_deg + 180) % 360 - 180


def _repeated_recording_warnings(seen: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    owners: dict[str, str] = {}
    for name, record in seen.items():
        hashes = record.get("frame_hashes") or ()
        common = [owners[h] for h in hashes if h in owners]
        first = max(common, key=common.count, default="")
        if common.count(first) >= MIN_COMMON_HASHES:
            yield (
                f"Trial {name}: many of its frames have the keypoints of trial {first}, to the "
                "last digit. A part of a recording is no repeat: leave one of them out, or choose "
                "separate parts by start_s and end_s."
            )
        for digest in hashes:
            owners.setdefault(digest, name)


def _length_warnings(
    robot: Robot, trials: Mapping[str, Trial], seen: Mapping[str, Mapping[str, Any]]
) -> Iterator[str]:
    """A sentence for each part of the body whose length is another beside the other parts'."""
    ratios = {n: r["length_ratios"] for n, r in seen.items() if len(r.get("length_ratios", ())) > 2}
    if not ratios:
        return
    least_m = MIN_PART_ERROR_BODY_LENGTHS * robot.body_length_m
    for part, (points, key) in LENGTH_ENDPOINTS_AND_KEYS.items():
        shares = [r[part] / float(np.median(list(r.values()))) - 1 for r in ratios.values()]
        stated = float(np.median([stated_lengths(robot, trials[n])[part] for n in ratios]))
        off = float(np.median(shares))
        if abs(off) > MIN_PART_ERROR_SHARE and abs(off) * stated > least_m:
            yield (
                f"{points} measures {1000 * stated * (1 + off):.0f} mm on the scale of the other "
                f"parts, {1000 * stated:.0f} mm are stated ({key}). Check these lengths, and where "
                "the keypoints are placed."
            )


def _tail_tip_warnings(robot: Robot, seen: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """A sentence where the tail tip of files without tail_base is not at its stated distance."""
    lengths = [v for r in seen.values() if (v := r.get("core_to_tail_tip_m")) is not None]
    if not lengths:
        return
    stated, found = robot.com_to_tail_base_m + robot.tail_length_m, float(np.median(lengths))
    least_m = MIN_PART_ERROR_BODY_LENGTHS * robot.body_length_m
    if abs(found - stated) > max(MIN_PART_ERROR_SHARE * stated, least_m):
        yield (
            f"core_center to tail_tip measures {1000 * found:.0f} mm with a straight tail, "
            f"{1000 * stated:.0f} mm are stated (robot.body_length_m - robot.head_length_m - "
            "robot.hinge_to_com_m + robot.tail_length_m). Is body_length_m measured to the root of "
            "the tail, not to its tip? Check these lengths, and where the keypoints are placed."
        )


def _interpolated_track_warnings(seen: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """A sentence for each trial whose track is interpolated in most frames."""
    for name, record in seen.items():
        share = record.get("pose_share")
        if share is not None and share < MIN_FRAMES_WITH_POSE_SHARE:
            yield (
                f"Trial {name}: {100 * share:.0f} % of the frames show a pose, the others are "
                "interpolated. Leave the trial out, or choose a better part by start_s and end_s."
            )
