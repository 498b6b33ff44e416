"""Whether a second body of the robot's shape is in the picture: points might be of either."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .background import Image
from .learning import Lesson
from .search import Blob
from .template import Template
from .tracking import Fit, Scene, found_among

LEAST_FRAMES = 2


def alike_remark(lesson: Lesson, scene: Scene) -> tuple[str, ...]:
    """A remark where some of the pictures that taught the outline show it at a second place."""
    pictures = zip(lesson.samples, lesson.blobs, strict=True)
    found = [
        (frame.time_s, second)
        for (frame, one), seen in pictures
        if (second := _second(frame.luma, seen, scene, lesson.template, one))
    ]
    if len(found) < LEAST_FRAMES:
        return ()
    time_s, (x, y, *_) = found[0][0], found[0][1].pose.tolist()
    return (
        f"a second body of the robot's shape in {len(found)} of {lesson.frames} pictures "
        f"looked at (at {time_s:.2f} s near x {x:.2f} m, y {y:.2f} m): the path may be of either",
    )


def _second(
    luma: Image, seen: Sequence[Blob], scene: Scene, template: Template, one: Fit
) -> Fit | None:
    """A good fit to a blob that lies a body's length from the robot."""
    apart = template.head_m + template.core_m
    others = [blob for blob in seen if _distance(blob, one) > apart]
    return found_among(others, luma, scene, template, template.shape())


def _distance(blob: Blob, one: Fit) -> float:
    x, y = blob.outline_m.mean(axis=0) - one.pose[:2]
    return math.hypot(x, y)
