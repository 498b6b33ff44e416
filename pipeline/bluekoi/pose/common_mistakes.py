"""One message for a mistake that most trials show alike: a length of study.yaml, or head angles in
radians.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, radians

import numpy as np

from ..data import Float
from ..errors import InputIssue
from ..study import Study
from .trial_comparison import (
    MAX_KEYPOINT_ERROR_BODY_LENGTHS,
    MIN_HEAD_ANGLE_DEVIATION_DEG,
    MIN_PART_ERROR_BODY_LENGTHS,
    wrap_angle_deg,
)

MIN_AGREEING_TRIALS = 2
"""Trials without which a mistake is not called common to them."""
MAX_STATED_HEAD_ANGLE_RAD = radians(120)
"""Largest head angle that trials.csv may state, in radians."""
CHECK_CORE_LABEL_REMEDY = (
    "Is core_center the centre of mass, and does each keypoint bear its own name?"
)


@dataclass(frozen=True)
class LengthFinding(InputIssue):
    """A part of another length than stated; seen_m, stated_m: head, hinge and tail as in
    `PART_SOURCES`.
    """

    trial_id: str = ""
    seen_m: tuple[float, ...] = ()
    stated_m: tuple[float, ...] = ()


@dataclass(frozen=True)
class HeadAngleFinding(InputIssue):
    """A head angle that is not the stated one."""

    trial_id: str = ""
    seen_deg: float = 0.0
    stated_deg: float = 0.0


def merge_common_mistakes(study: Study, found: Sequence[InputIssue]) -> list[InputIssue]:
    """The findings, those of a mistake that most trials show alike replaced by one."""
    return _with_merged_angle_findings(study, _with_merged_length_findings(study, found))


def seems_in_radians(seen_deg: float, stated_deg: float) -> bool:
    """Whether a stated head angle is the one seen if its number is in radians."""
    if stated_deg == 0 or abs(stated_deg) > MAX_STATED_HEAD_ANGLE_RAD:
        return False
    return abs(wrap_angle_deg(seen_deg - degrees(stated_deg))) <= MIN_HEAD_ANGLE_DEVIATION_DEG


def _with_merged_angle_findings(study: Study, found: Sequence[InputIssue]) -> list[InputIssue]:
    wrong = [one for one in found if isinstance(one, HeadAngleFinding)]
    stated = [abs(trial.head_angle_deg) for trial in study.trials]
    alike = all(seems_in_radians(one.seen_deg, one.stated_deg) for one in wrong)
    if len(wrong) < MIN_AGREEING_TRIALS or max(stated) > MAX_STATED_HEAD_ANGLE_RAD or not alike:
        return list(found)
    first = wrong[0]
    text = (
        f"{first.stated_deg:g} where the head is turned by {first.seen_deg:.0f} degrees (trial "
        f"{first.trial_id}), and alike in {len(wrong)} trials"
    )
    remedy = "The numbers are radians: multiply the column by 180/pi."
    one = InputIssue(first.file, "head_angle_deg", text, "degrees", remedy)
    return [one, *(other for other in found if not isinstance(other, HeadAngleFinding))]


def _with_merged_length_findings(study: Study, found: Sequence[InputIssue]) -> list[InputIssue]:
    wrong = [one for one in found if isinstance(one, LengthFinding)]
    unit_m = study.setup.robot.body_length_m
    keys = {
        one.trial_id: _length_that_explains_errors(_length_errors_m(one) / unit_m) for one in wrong
    }
    key, times = Counter(keys.values()).most_common(1)[0] if keys else ("", 0)
    trials = sum(trial.reads_keypoints for trial in study.trials)
    if not key or times < MIN_AGREEING_TRIALS or 2 * times <= trials:
        return list(found)
    alike = [one for one in wrong if keys[one.trial_id] == key]
    seen = np.median([one.seen_m for one in alike], axis=0)
    count = f"in {times} of {trials} trials"
    make = _hinge_to_com_finding if key == "hinge" else _body_or_head_length_finding
    merged = {one.trial_id for one in alike}
    others = (
        other
        for other in found
        if not (isinstance(other, LengthFinding) and other.trial_id in merged)
    )
    return [make(study, seen, count), *others]


def _length_errors_m(one: LengthFinding) -> Float:
    return np.array(one.seen_m) - np.array(one.stated_m)


def _length_that_explains_errors(errors: Float) -> str:
    """The length of study.yaml that alone explains the errors of head, hinge and tail, in body
    lengths: `hinge` (hinge_to_com_m), `body` (body_length_m or head_length_m); "" where neither
    does.
    """
    head, hinge, tail = errors
    if abs(head) > MAX_KEYPOINT_ERROR_BODY_LENGTHS:
        return ""
    if abs(hinge) > MAX_KEYPOINT_ERROR_BODY_LENGTHS:
        return "hinge" if abs(hinge + tail) <= MAX_KEYPOINT_ERROR_BODY_LENGTHS else ""
    return "body" if abs(tail) > MAX_KEYPOINT_ERROR_BODY_LENGTHS else ""


def _hinge_to_com_finding(study: Study, seen_m: Float, count: str) -> InputIssue:
    stated = study.setup.robot.hinge_to_com_m
    return InputIssue(
        str(study.root / "study.yaml"),
        "robot.hinge_to_com_m",
        f"{stated:g} m, while hinge to core_center measures {seen_m[1]:.3f} m {count}",
        "the same length",
        CHECK_CORE_LABEL_REMEDY,
    )


def _body_or_head_length_finding(study: Study, seen_m: Float, count: str) -> InputIssue:
    """Only the difference of body_length_m and head_length_m is seen: the latter is named first
    where a trial has the head that would fit.
    """
    robot = study.setup.robot
    core = float(seen_m[2]) + robot.hinge_to_com_m
    fitting = {
        "head_length_m": robot.body_length_m - core,
        "body_length_m": robot.head_length_m + core,
    }
    apart = [abs(trial.head_length_m - fitting["head_length_m"]) for trial in study.trials]
    names = (
        list(fitting)
        if min(apart) <= MIN_PART_ERROR_BODY_LENGTHS * robot.body_length_m
        else list(fitting)[::-1]
    )
    key, other = names
    remedy = "body_length_m is nose to root of the tail with the head of robot.head_length_m."
    apart_m = abs(seen_m[2] - robot.com_to_tail_base_m - robot.tail_length_m)
    if apart_m <= MAX_KEYPOINT_ERROR_BODY_LENGTHS * robot.body_length_m:
        remedy = (
            f"The difference equals tail_length_m, {robot.tail_length_m:g} m: are tail_base and "
            f"tail_tip exchanged, in the file or in `bodyparts:`? If not, {remedy}"
        )
    also = f" (or robot.{other} {fitting[other]:.3f})" if fitting[other] > 0 else ""
    return InputIssue(
        str(study.root / "study.yaml"),
        f"robot.{key}",
        f"{getattr(robot, key):g} m, by which core_center to tail_base is "
        f"{robot.com_to_tail_base_m:.3f} m, while it measures {seen_m[2]:.3f} m {count}",
        f"{fitting[key]:.3f} m{also}",
        remedy,
    )
