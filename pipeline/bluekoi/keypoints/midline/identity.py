"""Whether a tracked body may be another one: it jumps, or is poorly seen beside others."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..outline.target_body import MAX_SEARCH_RADIUS_LENGTHS
from .midline_fit import BendingTemplate, midline
from .track import BodyFitHistory, MidlineFit

SAME_BODY_DISTANCE_LENGTHS, CONFUSION_DISTANCE_LENGTHS = 0.12, 1.5
MIN_VISIBLE_SHARE, MIN_SAME_SCORE, MAX_TURN_RAD, MAX_MOVE_LENGTHS = 0.5, 0.55, 0.8, 0.4
"""A body is well seen if a share of more than `MIN_VISIBLE_SHARE` is seen and its score is above
`MIN_SAME_SCORE`. It jumps if it turns or moves more than this between two frames.
"""
RECOVERY_FRAMES = 4
"""Frames in a row in which a body alone has to be found after a doubt."""


def body_distance(one: BodyFitHistory, other: BodyFitHistory, shape: BendingTemplate) -> float:
    """Distance of two bodies in whole lengths."""
    a, b = one.last_seen_pose(), other.last_seen_pose()
    if a is None or b is None:
        return math.inf
    return float(np.hypot(*(a - b)[:2])) / shape.length_bl


def record_possible_identity_swap(
    target: BodyFitHistory, others: Sequence[BodyFitHistory], shape: BendingTemplate
) -> None:
    """Record the time from which the target may have been exchanged for another body.

    That is the case if another body is near and the target is poorly seen, jumps, or shares its
    midline with the other.
    """
    reach = MAX_SEARCH_RADIUS_LENGTHS if target.frames_since_seen else CONFUSION_DISTANCE_LENGTHS
    others = [body for body in others if body_distance(body, target, shape) < reach]
    if not others:
        return
    one, known = target.fits[-1], [fit for fit in target.fits[-3:-1] if fit is not None]
    sure = (
        one is not None
        and bool(known)
        and is_well_seen(one)
        and not is_jump(one, known[-1], shape)
        and not any(_is_same_body(one, body, shape) for body in others)
    )
    if not sure:
        target.doubtful_s = min(target.doubtful_s, target.times[-1])


def record_doubtful_jump(target: BodyFitHistory, shape: BendingTemplate) -> None:
    """Add the last frame to `unsure` if a body alone jumps to a place where it is not certain.

    A jump from the last certain frame is certain if that is the frame before and the body is well
    seen, or if the body has been found in `RECOVERY_FRAMES` in a row.
    """
    i, one = len(target.fits) - 1, target.fits[-1]
    last = i - 1
    while last >= 0 and (target.fits[last] is None or last in target.unsure):
        last -= 1
    before = target.fits[last] if last >= 0 else None
    if one is None or before is None:
        return
    turned = last == i - 1 and is_well_seen(one)
    recent = target.fits[-RECOVERY_FRAMES:]
    recovered = i - last >= RECOVERY_FRAMES and all(fit is not None for fit in recent)
    if is_jump(one, before, shape) and not (turned or recovered):
        target.unsure.add(i)


def is_well_seen(one: MidlineFit) -> bool:
    """Whether enough of a body is in sight and explained by the template."""
    return one.support[4] > MIN_VISIBLE_SHARE and one.support_score > MIN_SAME_SCORE


def is_jump(one: MidlineFit, before: MidlineFit, shape: BendingTemplate) -> bool:
    """Whether a body turns or moves from one fit to another by more than between two frames."""
    moved = math.hypot(*(one.pose - before.pose)[:2])
    turned = abs(math.remainder(one.pose[2] - before.pose[2], 2 * math.pi))
    return turned > MAX_TURN_RAD or moved > MAX_MOVE_LENGTHS * shape.length_bl


def _is_same_body(one: MidlineFit, body: BodyFitHistory, shape: BendingTemplate) -> bool:
    """Whether another body's midline lies on this one's."""
    other = body.last_seen_pose()
    if other is None:
        return False
    arc = np.linspace(0.1, 0.7, 5)
    a, _ = midline(one.pose, shape.length_bl, arc)
    b, _ = midline(other, shape.length_bl, arc)
    apart = min(float(np.hypot(*(a - c).T).mean()) for c in (b, b[::-1]))
    return apart < SAME_BODY_DISTANCE_LENGTHS * shape.length_bl
