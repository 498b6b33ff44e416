"""Why no robot was found: what differs from the background, against what study.yaml states."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from .background import LumaPicture, median_image, noise_level
from .blob_detection import MIN_THRESHOLD_GREY_LEVELS, THRESHOLD_NOISE_STDS, pool_mask
from .plane import SwimmingPlaneMap

MIN_ROBOT_LENGTH_PX = 40.0
EXTENT_RATIO_RANGE = (0.6, 1.7)


def robot_not_found_reason(
    images: Sequence[LumaPicture], plane: SwimmingPlaneMap, length_bl: float, *, bending: bool
) -> str:
    """The likely reason with its numbers, and a remedy.

    length_bl: nose to caudal base, body lengths. bending: a bending body was looked for, not a
    rigid one.
    """
    stated = length_bl * plane.px_per_bl
    if stated < MIN_ROBOT_LENGTH_PX:
        return (
            f"the robot is {stated:.0f} px long, at least {MIN_ROBOT_LENGTH_PX:.0f} are needed: "
            "film from nearer or with more pixels, or check body_length_m and pool_corners_px"
        )
    floor = median_image(images)
    level = max(MIN_THRESHOLD_GREY_LEVELS, THRESHOLD_NOISE_STDS * noise_level(images, floor))
    seen = [_contrast_and_extents_px(image, floor, level, plane) for image in images]
    most = max(contrast for contrast, _ in seen)
    if most < level:
        return (
            f"nothing differs from the background by more than {most:.0f} grey levels, at least "
            f"{level:.0f} are needed: the robot must move between the frames and be darker or "
            "brighter than the floor"
        )
    return _compare_extents_with_stated([extents for _, extents in seen], stated, bending=bending)


def _compare_extents_with_stated(
    seen: Sequence[npt.NDArray[np.float64]], stated: float, *, bending: bool
) -> str:
    """What the extents [px] of the things in each picture say against the stated length."""
    fitting = [
        int(np.sum((own > EXTENT_RATIO_RANGE[0] * stated) & (own < EXTENT_RATIO_RANGE[1] * stated)))
        for own in seen
    ]
    if np.median(fitting) > 1:
        things = float(np.median([len(own) for own in seen]))
        if things > np.median(fitting):
            return (
                f"{things:.0f} things differ from the background, {np.median(fitting):.0f} of them "
                f"about as long as the robot ({stated:.0f} px): if one of them is the robot, give "
                "start_x_px and start_y_px in trials.csv; if they are moving light or reflections, "
                "is the robot in the picture?"
            )
        return (
            f"{np.median(fitting):.0f} bodies of about the stated {stated:.0f} px are in the "
            "picture: give start_x_px and start_y_px in trials.csv"
        )
    if max(fitting) == 1 and bending:
        return (
            f"a thing of about the stated {stated:.0f} px is there, but its midline could not be "
            "followed: check body_length_m and the contrast to the floor"
        )
    if max(fitting) == 1:
        return (
            f"a thing of about the stated {stated:.0f} px is there, but its outline is not a rigid "
            "head and core: check head_length_m and head_angle_deg, or set detection.body to "
            "bending"
        )
    largest = float(np.median([own.max() if len(own) else 0.0 for own in seen]))
    return (
        f"the largest thing that moves is {largest:.0f} px long, the robot by study.yaml "
        f"{stated:.0f} px: check body_length_m, the pool's size and pool_corners_px"
    )


def _contrast_and_extents_px(
    image: LumaPicture, floor: LumaPicture, level: float, plane: SwimmingPlaneMap
) -> tuple[float, npt.NDArray[np.float64]]:
    """Greatest contrast in the pool, and the extents [px] of what differs by more than a level."""
    change = cv2.blur(cv2.absdiff(image, floor), (3, 3)) * pool_mask(image.shape, plane.corners_px)
    contours, _ = cv2.findContours(
        (change > level).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    boxes = [cv2.minAreaRect(one)[1] for one in contours if len(one) > 4]
    extents = np.array([math.hypot(*box) for box in boxes], dtype=float)
    return float(change.max()), extents
