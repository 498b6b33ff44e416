"""Whether a second body of the robot's shape is in the picture: points might be of either."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .background import LumaPicture
from .blob_detection import Blob
from .learning import LearnedTemplate, robot_sized_blobs
from .target_body import TargetBody
from .template import OutlineTemplate
from .tracking import DetectionScene, OutlineFit, best_fit_of_blobs

MIN_FRAMES = 2


def second_body_remark(
    outline: LearnedTemplate, scene: DetectionScene, length_bl: float, *, start_is_known: bool
) -> tuple[str, ...]:
    """A remark where some pictures that the outline was learned from show it at a second place.

    length_bl: of the robot. start_is_known: it was stated which body is meant.
    """
    pictures = [(f, one, robot_sized_blobs(f, scene, length_bl)) for f, one in outline.samples]
    found = [
        (frame.time_s, second)
        for frame, one, seen in pictures
        if (second := _fit_second_body(frame.luma, seen, scene, outline.template, one))
    ]
    if len(found) < MIN_FRAMES:
        return ()
    time_s, (u, v) = (
        found[0][0],
        scene.plane.body_lengths_to_pixels(found[0][1].pose[None, :2])[0].tolist(),
    )
    return (
        f"a second body of the robot's shape in {len(found)} of {outline.learning_frame_count} "
        f"pictures looked at (at {time_s:.2f} s near pixel {u:.0f}, {v:.0f}): the path "
        + (
            "is of the one that began at start_x_px, start_y_px"
            if start_is_known
            else "may be of either; give start_x_px and start_y_px in trials.csv"
        ),
    )


def _fit_second_body(
    luma: LumaPicture,
    seen: Sequence[Blob],
    scene: DetectionScene,
    template: OutlineTemplate,
    one: OutlineFit,
) -> OutlineFit | None:
    """A good fit to a blob that lies a body's length from the robot."""
    apart = template.head_bl + template.core_bl
    others = [blob for blob in seen if _distance_bl(blob, one) > apart]
    return best_fit_of_blobs(
        others, luma, scene, TargetBody(template, None), template.outline_arrays()
    )


def _distance_bl(blob: Blob, one: OutlineFit) -> float:
    x, y = blob.outline_bl.mean(axis=0) - one.pose[:2]
    return math.hypot(x, y)
