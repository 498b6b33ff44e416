"""Whether what was found in a bridged background can be a body: a straight rim of the pool is not.

Where a robot hardly leaves its place, its background is bridged from around it, and with it
whatever else is long and dark. Along a rim the template slides, while the pictures stay as they
are. A robot stays at its place, or the floor is uncovered where it leaves.
"""

from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np
import numpy.typing as npt

from .blob_detection import LEVEL_NOISE_STDS, MIN_LEVEL_GREY_LEVELS
from .ghost_removal import ROBOT_MARGIN_BL
from .learning import LearnedTemplate
from .template import OutlineTemplate
from .tracking import DetectionScene, OutlineFit


def pictures_agree_with_movement(outline: LearnedTemplate, scene: DetectionScene) -> bool:
    """Whether a body that lies at two places in the pictures that the outline was learned from
    uncovers the floor: where it lies in one picture and not in the other, they differ by what a
    body must differ from its background.
    """
    pairs = list(combinations(outline.samples, 2))
    if not pairs:
        return True
    (first, one), (second, other) = max(pairs, key=lambda p: _distance_bl(p[0][1], p[1][1]))
    if _distance_bl(one, other) < ROBOT_MARGIN_BL:
        return True
    masks = [_body_mask(fit, scene, outline.template) for fit in (one, other)]
    change = cv2.absdiff(first.luma, second.luma)[masks[0] & ~masks[1]]
    level = max(MIN_LEVEL_GREY_LEVELS, LEVEL_NOISE_STDS * scene.noise)
    return float(np.median(change)) > level


def _distance_bl(one: OutlineFit, other: OutlineFit) -> float:
    return float(np.hypot(*(one.pose[:2] - other.pose[:2])))


def _body_mask(
    one: OutlineFit, scene: DetectionScene, template: OutlineTemplate
) -> npt.NDArray[np.bool_]:
    """Where head and core lie in the picture."""
    x, y, heading, bend = one.pose
    c, s = np.cos(heading), np.sin(heading)
    body = template.outline(bend) @ np.array([[c, s], [-s, c]]) + [x, y]
    mask = np.zeros(scene.floor.shape, np.uint8)
    cv2.fillPoly(mask, [scene.plane.pixels(body).round().astype(np.int32)], 1)
    return mask > 0
