"""Where the robot might be when nothing is known: blobs against the background, poses of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from .plane import Plane
from .template import Template

Float = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]
MARGIN_PX = 1.08
FAINT = 0.4


@dataclass(frozen=True)
class Blob:
    """Something that differs from the background.

    outline_m: (n, 2) in the plane. area_m2. half_width_m: largest inscribed radius. skin: its
    grey level; contrast: how far its floor is brighter (negative: darker).
    """

    outline_m: Float
    area_m2: float
    half_width_m: float
    skin: float
    contrast: float


def blobs(luma: Image, floor: Image, plane: Plane, noise: float) -> list[Blob]:
    """Blobs inside the pool, largest first, found on a thinned picture and outlined there.

    Those much fainter than the strongest are shadows and moving light.
    """
    step = max(1, int(plane.px_per_m * 0.004))
    picture, clear = luma[::step, ::step], floor[::step, ::step]
    change = cv2.GaussianBlur(cv2.absdiff(picture, clear), (3, 3), 0)
    mask = (change > max(14.0, 5.0 * noise)).astype(np.uint8)
    mask &= _pool_mask(mask.shape, plane.corners_px / step)
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    least = 0.0015 * (plane.px_per_m / step) ** 2
    large = sorted((c for c in contours if len(c) > 8), key=cv2.contourArea, reverse=True)[:6]
    found = [_blob(c, (picture, clear), plane, step) for c in large if cv2.contourArea(c) > least]
    known = [blob for blob in found if blob is not None]
    strongest = max((abs(blob.contrast) for blob in known), default=0.0)
    return [blob for blob in known if abs(blob.contrast) > FAINT * strongest]


def _pool_mask(shape: tuple[int, int], corners: Float) -> Image:
    mask = np.zeros(shape, np.uint8)
    middle = corners.mean(axis=0)
    wide = middle + MARGIN_PX * (corners - middle)
    cv2.fillConvexPoly(mask, wide.round().astype(np.int32), 1)
    return mask


def _blob(
    contour: npt.NDArray[np.int32], pictures: tuple[Image, Image], plane: Plane, step: int
) -> Blob | None:
    """Blob of a contour, outlined anew at half of its own contrast."""
    x, y, w, h = cv2.boundingRect(contour)
    luma, floor = (image[y : y + h, x : x + w].astype(np.int16) for image in pictures)
    inside = np.zeros((h, w), np.uint8)
    cv2.drawContours(inside, [contour - [x, y]], -1, 1, -1)
    contrast = _contrast((floor - luma)[inside > 0])
    if abs(contrast) < 8:
        return None
    solid = ((floor - luma) / contrast > 0.5).astype(np.uint8) & cv2.dilate(
        inside, np.ones((5, 5), np.uint8)
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
        outline_m=plane.metres(places),
        area_m2=cv2.contourArea(outline) * (step / plane.px_per_m) ** 2,
        half_width_m=radius * step / plane.px_per_m,
        skin=float(np.median(luma[filled[1:-1, 1:-1] > 0])),
        contrast=contrast,
    )


def _contrast(change: npt.NDArray[np.int16]) -> float:
    """Contrast of the body in a blob, of its sign; a shadow beside the body is fainter."""
    sign = 1.0 if np.median(change) >= 0 else -1.0
    return sign * float(np.percentile(sign * change, 80))


def poses_of(blob: Blob, template: Template, head_angle_rad: float) -> list[Float]:
    """Poses (4,) that lay the template over a blob: both ways round, bent as told, or straight."""
    centre, axis = _axis(blob.outline_m)
    found = []
    for bend in dict.fromkeys((head_angle_rad, 0.0, -head_angle_rad)):
        own_centre, own_axis = _axis(template.outline(bend))
        for way in (0.0, math.pi):
            heading = axis - own_axis + way
            c, s = math.cos(heading), math.sin(heading)
            hinge = centre - np.array([[c, -s], [s, c]]) @ own_centre
            found.append(np.array([hinge[0], hinge[1], heading, bend]))
    return found


def _axis(outline: Float) -> tuple[Float, float]:
    """Centre of area (2,) and direction [rad] of the long axis of a closed outline."""
    x, y = outline.T - outline.mean(axis=0)[:, None]
    nx, ny = np.roll(x, -1), np.roll(y, -1)
    cross = x * ny - nx * y
    area = cross.sum() / 2 or 1e-12
    cx, cy = ((x + nx) * cross).sum() / (6 * area), ((y + ny) * cross).sum() / (6 * area)
    xx = ((x * x + x * nx + nx * nx) * cross).sum() / (12 * area) - cx * cx
    yy = ((y * y + y * ny + ny * ny) * cross).sum() / (12 * area) - cy * cy
    xy = ((x * ny + 2 * x * y + 2 * nx * ny + nx * y) * cross).sum() / (24 * area) - cx * cy
    return outline.mean(axis=0) + np.array([cx, cy]), 0.5 * math.atan2(2 * xy, xx - yy)
