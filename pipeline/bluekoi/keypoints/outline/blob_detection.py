"""Where the robot might be when nothing is known: blobs against the background, poses of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ...data import Float
from .plane import SwimmingPlaneMap
from .template import OutlineTemplate

LumaPicture = npt.NDArray[np.uint8]
POOL_MASK_ENLARGEMENT = 1.08
MIN_RELATIVE_CONTRAST = 0.4
MIN_THRESHOLD_GREY_LEVELS, THRESHOLD_NOISE_STDS = 14.0, 4.0
MAX_CHANGED_AREA_OVER_ROBOT_AREA = 4.0
MAX_THRESHOLD_GREY_LEVELS = 60.0
MORPHOLOGY_KERNEL = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class Blob:
    """Something that differs from the background.

    outline_bl: (n, 2) in the plane. area_bl2. half_width_bl: largest inscribed radius. skin: its
    grey level; contrast: how far its floor is brighter (negative: darker).
    """

    outline_bl: Float
    area_bl2: float
    half_width_bl: float
    skin: float
    contrast: float


def find_blobs(
    pictures: tuple[LumaPicture, LumaPicture],
    plane: SwimmingPlaneMap,
    noise: float,
    area_bl2: float,
) -> list[Blob]:
    """Blobs inside the pool, strongest first, found on a thinned picture and outlined there.

    pictures: luma, background. area_bl2: of the robot, roughly: only the most changed part of the
    pool, a few times as large, is looked at, so that moving light does not drown it. Darker and
    brighter blobs are kept apart; those much fainter than the strongest are left out.
    """
    step = max(1, int(plane.px_per_bl * 0.012))
    thin = (pictures[0][::step, ::step], pictures[1][::step, ::step])
    change = cv2.subtract(thin[1], thin[0], dtype=cv2.CV_16S)
    change = cv2.blur(change, (3, 3))
    pool = pool_mask(change.shape, plane.corners_px / step)
    share = (
        MAX_CHANGED_AREA_OVER_ROBOT_AREA
        * area_bl2
        * (plane.px_per_bl / step) ** 2
        / max(1, int(pool.sum()))
    )
    least = 0.1 * area_bl2 * (plane.px_per_bl / step) ** 2
    found: list[Blob | None] = []
    for sided in (change, -change):
        usual = np.quantile(sided[::3, ::3][pool[::3, ::3] > 0], max(0.0, 1 - share))
        level = max(
            MIN_THRESHOLD_GREY_LEVELS,
            THRESHOLD_NOISE_STDS * noise,
            min(float(usual), MAX_THRESHOLD_GREY_LEVELS),
        )
        solid = cv2.morphologyEx(
            (sided > level).astype(np.uint8) & pool, cv2.MORPH_OPEN, MORPHOLOGY_KERNEL
        )
        contours, _ = cv2.findContours(solid, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        large = sorted((c for c in contours if len(c) > 8), key=cv2.contourArea, reverse=True)[:4]
        found += [
            _blob_of_contour(c, thin, plane, step) for c in large if cv2.contourArea(c) > least
        ]
    known = [blob for blob in found if blob is not None]
    known.sort(key=lambda blob: -abs(blob.contrast))
    return [
        blob
        for blob in known
        if abs(blob.contrast) > MIN_RELATIVE_CONTRAST * abs(known[0].contrast)
    ]


def pool_mask(shape: tuple[int, ...], corners: Float) -> LumaPicture:
    """1 in the pool and a little around it, else 0."""
    mask = np.zeros(shape[:2], np.uint8)
    middle = corners.mean(axis=0)
    wide = middle + POOL_MASK_ENLARGEMENT * (corners - middle)
    cv2.fillConvexPoly(mask, wide.round().astype(np.int32), 1)
    return mask


def _blob_of_contour(
    contour: npt.NDArray[np.int32],
    pictures: tuple[LumaPicture, LumaPicture],
    plane: SwimmingPlaneMap,
    step: int,
) -> Blob | None:
    """Blob of a contour, outlined again at half of its own contrast."""
    x, y, w, h = _box_with_margin(cv2.boundingRect(contour), pictures[0].shape)
    luma, floor = (image[y : y + h, x : x + w].astype(np.int16) for image in pictures)
    inside = np.zeros((h, w), np.uint8)
    cv2.drawContours(inside, [contour - [x, y]], -1, 1, -1)
    contrast = _signed_contrast((floor - luma)[inside > 0])
    if abs(contrast) < 8:
        return None
    solid = ((floor - luma) / contrast > 0.5).astype(np.uint8) & cv2.dilate(
        inside, np.ones((9, 9), np.uint8)
    )
    solid = cv2.morphologyEx(solid, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    parts, _ = cv2.findContours(solid, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not parts:
        return None
    outline = max(parts, key=cv2.contourArea)
    if len(outline) < 8:
        return None
    filled = np.zeros((h + 2, w + 2), np.uint8)
    cv2.drawContours(filled, [outline + 1], -1, 1, -1)
    radius = float(cv2.distanceTransform(filled, cv2.DIST_L2, 5).max())
    places = (outline[:, 0] + np.array([x, y], dtype=float)) * step
    return Blob(
        outline_bl=plane.pixels_to_body_lengths(places),
        area_bl2=cv2.contourArea(outline) * (step / plane.px_per_bl) ** 2,
        half_width_bl=radius * step / plane.px_per_bl,
        skin=float(np.median(luma[filled[1:-1, 1:-1] > 0])),
        contrast=contrast,
    )


def _box_with_margin(
    box: tuple[int, int, int, int], shape: tuple[int, int]
) -> tuple[int, int, int, int]:
    """Box x, y, width, height with a margin, cut to the picture."""
    x, y = max(0, box[0] - 6), max(0, box[1] - 6)
    right, low = min(shape[1], box[0] + box[2] + 6), min(shape[0], box[1] + box[3] + 6)
    return x, y, right - x, low - y


def _signed_contrast(change: npt.NDArray[np.int16]) -> float:
    """Contrast of the body in a blob, of its sign; a shadow beside the body is fainter."""
    sign = 1.0 if np.median(change) >= 0 else -1.0
    return sign * float(np.percentile(sign * change, 80))


def candidate_poses(blob: Blob, template: OutlineTemplate, head_angle_rad: float) -> list[Float]:
    """Poses (4,) that lay the template over a blob: both ways round, bent as stated or straight."""
    centre, axis = _centre_and_long_axis(blob.outline_bl)
    found = []
    for bend in dict.fromkeys((head_angle_rad, 0.0, -head_angle_rad)):
        own_centre, own_axis = _centre_and_long_axis(template.closed_outline(bend))
        for way in (0.0, math.pi):
            heading = axis - own_axis + way
            c, s = math.cos(heading), math.sin(heading)
            hinge = centre - np.array([[c, -s], [s, c]]) @ own_centre
            found.append(np.array([hinge[0], hinge[1], heading, bend]))
    return found


def _centre_and_long_axis(outline: Float) -> tuple[Float, float]:
    """Centre of area (2,) and direction [rad] of the long axis of a closed outline."""
    m = cv2.moments((outline - outline.mean(axis=0)).astype(np.float32))
    centre = np.array([m["m10"], m["m01"]]) / (m["m00"] or 1e-12)
    return outline.mean(axis=0) + centre, 0.5 * math.atan2(2 * m["mu11"], m["mu20"] - m["mu02"])
