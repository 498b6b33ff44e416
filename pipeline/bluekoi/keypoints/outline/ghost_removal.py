"""The background without the robot's own traces, once its shape and places are known.

A median of a few frames holds a ghost where the robot lay in most of them. With the template laid
over each frame, every pixel's median is taken over the frames in which the robot is elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from ...numba_settings import njit
from .background import ROWS_PER_STRIP, LumaPicture, without_static_robot
from .learning import LearnedTemplate
from .template import OutlineTemplate
from .tracking import DetectionScene, OutlineFit

ROBOT_MARGIN_BL = 0.036
TAIL_MASK_LENGTH_RATIO = 1.15
MAX_HIDDEN_FRAME_SHARE = 0.25
"""Share of the frames in which the robot may hide a place of the floor without the background being
computed again, which takes time. The median is then the 1/3 quantile of the frames that show the
place: at most 0.43 standard deviations of their brightness off."""
Region = tuple[slice, slice]


def robot_mask(
    one: OutlineFit, scene: DetectionScene, template: OutlineTemplate
) -> tuple[Region, LumaPicture]:
    """Where in the picture the robot, its tail's reach and a margin lie, and their mask there."""
    x, y, heading, _ = one.pose
    turn = np.exp(1j * heading)
    base = x + 1j * y - template.core_bl * turn
    swing = np.exp(1j * np.linspace(-1.1, 1.1, 9))
    tail = np.concatenate([[base], base - TAIL_MASK_LENGTH_RATIO * template.tail_bl * turn * swing])
    shapes = [body_outline_px(one, scene, template), _nearest_pixels(scene, tail)]
    margin = round(ROBOT_MARGIN_BL * scene.plane.px_per_bl)
    height, width = scene.floor.shape
    low = np.concatenate(shapes).min(axis=0) - margin
    high = np.concatenate(shapes).max(axis=0) + margin + 1
    low, high = (np.clip(corner, 0, [width, height]) for corner in (low, high))
    mask = np.zeros(tuple(np.maximum(high - low, 0)[::-1]), np.uint8)
    if mask.size:
        for uv in shapes:
            cv2.fillPoly(mask, [uv - low], 1)
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * margin + 1, 2 * margin + 1))
        mask = cv2.dilate(mask, disc)
    return (slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))), mask


def body_outline_px(
    one: OutlineFit, scene: DetectionScene, template: OutlineTemplate
) -> npt.NDArray[np.int32]:
    """Outline (n, 2) of head and core in the picture, px."""
    x, y, heading, bend = one.pose
    outline = template.closed_outline(bend)
    body = (outline[:, 0] + 1j * outline[:, 1]) * np.exp(1j * heading) + x + 1j * y
    return _nearest_pixels(scene, body)


def _nearest_pixels(
    scene: DetectionScene, points_bl: npt.NDArray[np.complex128]
) -> npt.NDArray[np.int32]:
    """Pixels (n, 2) of points x + i y in the plane."""
    px = scene.plane.body_lengths_to_pixels(np.column_stack([points_bl.real, points_bl.imag]))
    return px.round().astype(np.int32)


def background_without_robot(outline: LearnedTemplate, scene: DetectionScene) -> LumaPicture | None:
    """Background free of the robot; None where its places hardly overlap and the median is right.

    Only the frames that the outline was learned from count. Where the robot never left, the
    background is bridged from around it.
    """
    fits = outline.samples
    template = outline.template
    masks = [robot_mask(one, scene, template) for _, one in fits]
    cut = _bounding_region([place for place, _ in masks])
    often = np.zeros(scene.floor[cut].shape, np.uint8)
    for place, mask in masks:
        often[_relative_region(place, cut)] += mask
    if often.size == 0 or int(often.max()) <= MAX_HIDDEN_FRAME_SHARE * len(fits):
        return None
    floor = scene.floor.copy()
    for strip in _row_strips(cut):
        _write_unhidden_median(
            np.stack([frame.luma[strip] for frame, _ in fits]),
            _masks_in_strip(masks, strip),
            floor[strip],
        )
    never = often == len(fits)
    if never.any():
        bridged = without_static_robot(
            floor, 2 * float(template.half.max()) * scene.plane.px_per_bl
        )
        floor[cut][never] = bridged[cut][never]
    return floor


def _bounding_region(cuts: Sequence[Region]) -> Region:
    """The smallest cut that holds all of some."""
    rows, columns = zip(*cuts, strict=True)
    return _bounding_slice(rows), _bounding_slice(columns)


def _bounding_slice(ranges: Sequence[slice]) -> slice:
    return slice(min(r.start for r in ranges), max(r.stop for r in ranges))


def _relative_region(inner: Region, outer: Region) -> Region:
    rows, columns = (
        slice(i.start - o.start, i.stop - o.start) for i, o in zip(inner, outer, strict=True)
    )
    return rows, columns


def _row_strips(cut: Region) -> Iterator[Region]:
    """A cut in strips of rows: stacks of whole 4K pictures would be 80 MB."""
    rows, columns = cut
    for y in range(rows.start, rows.stop, ROWS_PER_STRIP):
        yield slice(y, min(y + ROWS_PER_STRIP, rows.stop)), columns


def _masks_in_strip(
    masks: Sequence[tuple[Region, LumaPicture]], strip: Region
) -> npt.NDArray[np.uint8]:
    """Each mask's part in a strip that is as wide as all of them, (masks, rows, columns)."""
    rows, columns = strip
    layers = np.zeros((len(masks), rows.stop - rows.start, columns.stop - columns.start), np.uint8)
    for layer, (place, mask) in zip(layers, masks, strict=True):
        top, low = max(rows.start, place[0].start), min(rows.stop, place[0].stop)
        if top < low:
            own = slice(top, low), place[1]
            layer[_relative_region(own, strip)] = mask[_relative_region(own, place)]
    return layers


@njit(cache=True)
def _write_unhidden_median(
    stack: npt.NDArray[np.uint8], hidden: npt.NDArray[np.uint8], floor: LumaPicture
) -> None:
    """Write to `floor` the median of the frames in which a pixel is not hidden, if it is in one."""
    count, height, width = stack.shape
    seen = np.empty(count, np.int64)
    for y in range(height):
        for x in range(width):
            n = 0
            for k in range(count):
                if hidden[k, y, x]:
                    continue
                value, at = stack[k, y, x], n
                while at > 0 and seen[at - 1] > value:
                    seen[at] = seen[at - 1]
                    at -= 1
                seen[at] = value
                n += 1
            if 0 < n < count:
                floor[y, x] = (seen[(n - 1) // 2] + seen[n // 2] + 1) // 2
