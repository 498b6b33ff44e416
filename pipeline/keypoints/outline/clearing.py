"""The background without the robot's own traces, once its shape and places are known.

A median of a few frames holds a ghost where the robot lay in most of them. With the template laid
over each frame, every pixel's median is taken over the frames in which the robot is elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from ...data import Frame
from .background import Image, without_resident
from .learning import Lesson
from .template import Template
from .tracking import Fit, Scene

Float = npt.NDArray[np.float64]
MARGIN_M = 0.012
TAIL_REACH = 1.15


def mask_of(one: Fit, scene: Scene, template: Template) -> Image:
    """Picture-sized mask (0, 1) of the robot, its tail's reach and a margin."""
    x, y, heading, bend = one.pose
    turn = np.exp(1j * heading)
    outline = template.outline(bend)
    body = (outline[:, 0] + 1j * outline[:, 1]) * turn + x + 1j * y
    base = x + 1j * y - template.core_m * turn
    swing = np.exp(1j * np.linspace(-1.1, 1.1, 9))
    tail = np.concatenate([[base], base - TAIL_REACH * template.tail_m * turn * swing])
    mask = np.zeros(scene.floor.shape, np.uint8)
    for shape in (body, tail):
        uv = scene.plane.pixels(np.column_stack([shape.real, shape.imag]))
        cv2.fillPoly(mask, [uv.round().astype(np.int32)], 1)
    return _widened(mask, round(MARGIN_M * scene.plane.px_per_m))


def _widened(mask: Image, margin: int) -> Image:
    """Mask grown by a margin, worked on where it is alone."""
    x, y, w, h = cv2.boundingRect(mask)
    top, left = max(0, y - margin), max(0, x - margin)
    cut = slice(top, y + h + margin), slice(left, x + w + margin)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * margin + 1, 2 * margin + 1))
    mask[cut] = cv2.dilate(mask[cut], disc)
    return mask


def cleared(samples: Sequence[Frame], lesson: Lesson, scene: Scene) -> Image | None:
    """Background free of the robot; None where its places do not overlap and the median is right.

    Frames in which the lesson found no robot are left out. Where the robot never left, the
    background is bridged from around it.
    """
    known = {id(frame): one for frame, one in lesson.samples}
    samples = [frame for frame in samples if id(frame) in known]
    template = lesson.template
    masks = [mask_of(known[id(frame)], scene, template) for frame in samples]
    often: Image = np.array(masks).sum(axis=0, dtype=np.uint8)
    if int(often.max()) < 2:
        return None
    x, y, w, h = cv2.boundingRect((often > 0).astype(np.uint8))
    cut = slice(y, y + h), slice(x, x + w)
    stack = np.array([frame.luma[cut] for frame in samples], dtype=np.float32)
    for values, mask in zip(stack, masks, strict=True):
        values[mask[cut] > 0] = np.nan
    floor = scene.floor.copy()
    free = ~np.isnan(stack).all(axis=0)
    where = free & (often[cut] > 0)
    floor[cut][where] = np.nanmedian(stack[:, where], axis=0).round().astype(np.uint8)
    if not free.all():
        bridged = without_resident(floor, 2 * float(template.half.max()) * scene.plane.px_per_m)
        floor[cut][~free] = bridged[cut][~free]
    return floor
