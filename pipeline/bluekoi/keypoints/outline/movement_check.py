"""Check of a robot found in a background that was interpolated across its place.

The interpolation also removes other long dark things, such as the rim of the pool, and the template
then fits the rim, at any place along it. If the template lies at different places in two pictures,
a real body changes the pictures there; a rim does not.
"""

from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np
import numpy.typing as npt

from .blob_detection import MIN_THRESHOLD_GREY_LEVELS, THRESHOLD_NOISE_STDS
from .ghost_removal import ROBOT_MARGIN_BL, body_outline_px
from .learning import LearnedTemplate, fits_with_near_best_support
from .template import OutlineTemplate
from .tracking import DetectionScene, OutlineFit


def frames_change_where_body_moved(outline: LearnedTemplate, scene: DetectionScene) -> bool:
    """Whether two pictures differ by what a body must differ from its background, where the body
    lies in only one of them. True where it stays at its place.

    Of the well-fitted pictures that the outline was learned from, the two with the largest distance
    of the fits are compared.
    """
    pairs = list(combinations(fits_with_near_best_support(outline.samples), 2))
    if not pairs:
        return True
    (first, one), (second, other) = max(pairs, key=lambda p: _distance_bl(p[0][1], p[1][1]))
    if _distance_bl(one, other) < ROBOT_MARGIN_BL:
        return True
    masks = [_body_mask(fit, scene, outline.template) for fit in (one, other)]
    change = cv2.absdiff(first.luma, second.luma)
    uncovered = [change[a & ~b] for a, b in (masks, masks[::-1])]
    level = max(MIN_THRESHOLD_GREY_LEVELS, THRESHOLD_NOISE_STDS * scene.noise)
    seen = [float(np.median(part)) for part in uncovered if len(part)]
    return not seen or max(seen) > level


def _distance_bl(one: OutlineFit, other: OutlineFit) -> float:
    return float(np.hypot(*(one.pose[:2] - other.pose[:2])))


def _body_mask(
    one: OutlineFit, scene: DetectionScene, template: OutlineTemplate
) -> npt.NDArray[np.bool_]:
    """Where head and core lie in the picture (height, width)."""
    mask = np.zeros(scene.floor.shape, np.uint8)
    cv2.fillPoly(mask, [body_outline_px(one, scene, template)], 1)
    return mask > 0
