"""Paths, keypoints and the empty pool, drawn in pixels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
import numpy.typing as npt

from ..camera.pool import PoolCamera, project
from ..data import Float, Keypoints

Picture = npt.NDArray[np.uint8]
Colour = tuple[int, int, int]

STRIP_PX = 40
NEAR_S = 1 / 60
"""A detection is drawn on a frame no further away in time."""
CONFIDENT = 0.6
SHIFT = 4  # OpenCV draws at 1/16 px with this many fractional bits

# bgr; told apart by the colour-blind, and by dashes and width as well
DARK: Colour = (46, 38, 32)
MEASURED: Colour = (255, 255, 255)
BEFORE: Colour = (0, 130, 255)
AFTER: Colour = (255, 200, 60)
POINT: Colour = (80, 240, 250)


@dataclass(frozen=True)
class Line:
    """A path in pixels of the raw frame, (n, 2), with its times, (n,), s."""

    name: str
    time_s: Float
    xy_px: Float
    colour: Colour
    dashed: bool = False
    width_px: int = 2


@dataclass(frozen=True)
class Scene:
    """All that is drawn on one trial's frames; size_px: width and height of the raw frame."""

    label: str
    size_px: tuple[int, int]
    lines: tuple[Line, ...]
    keypoints: Keypoints | None = None
    floor: Picture = field(default_factory=lambda: np.zeros((0, 0, 3), np.uint8))


def annotated(picture: Picture, scene: Scene, time_s: float, scale: float) -> Picture:
    """The picture with all lines up to `time_s`, the keypoints of that moment, and a key."""
    canvas = np.ascontiguousarray(picture)
    for line in scene.lines:
        _draw_line(canvas, line, time_s, scale)
    if scene.keypoints is not None:
        _draw_points(canvas, scene.keypoints, time_s, scale)
    return np.vstack([_strip(scene, time_s, canvas.shape[1]), canvas])


def empty_pool(camera: PoolCamera, width_px: int) -> Picture:
    """The pool as the camera would see it empty: walls, and a grid every 0.5 m at the surface."""
    scale = width_px / camera.size_px[0]
    height = 2 * round(scale * camera.size_px[1] / 2)
    canvas = np.full((height, width_px, 3), (96, 88, 80), np.uint8)
    length, width = camera.pool_size_m
    rim = _edges(length, width)
    cv2.fillPoly(canvas, [_fixed(scale * project(camera, rim))], (190, 172, 140), shift=SHIFT)
    for line in _grid(length, width):
        _polyline(canvas, scale * project(camera, line), (205, 190, 165), 1)
    _polyline(canvas, scale * project(camera, rim), (235, 235, 235), 2)
    return canvas


def _draw_line(canvas: Picture, line: Line, time_s: float, scale: float) -> None:
    shown = (line.time_s <= time_s + 1e-6) & np.isfinite(line.xy_px).all(axis=1)
    way = scale * line.xy_px[shown]
    if len(way) == 0:
        return
    pieces = _dashes(way) if line.dashed else [way]
    for piece in pieces if line.width_px > 2 else []:
        _polyline(canvas, piece, DARK, line.width_px + 2)
    for piece in pieces:
        _polyline(canvas, piece, line.colour, line.width_px)
    end = _fixed(way[-1])
    cv2.circle(canvas, end, 5 << SHIFT, DARK, -1, cv2.LINE_AA, SHIFT)
    cv2.circle(canvas, end, 3 << SHIFT, line.colour, -1, cv2.LINE_AA, SHIFT)


def _draw_points(canvas: Picture, found: Keypoints, time_s: float, scale: float) -> None:
    i = int(np.argmin(np.abs(found.time_s - time_s)))
    if abs(found.time_s[i] - time_s) > NEAR_S:
        return
    sure = (found.likelihood[i] >= CONFIDENT) & np.isfinite(found.xy_px[i]).all(axis=1)
    for point in scale * found.xy_px[i][sure]:
        cv2.circle(canvas, _fixed(point), 4 << SHIFT, DARK, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(canvas, _fixed(point), 40, POINT, -1, cv2.LINE_AA, SHIFT)


def _dashes(way: Float, length_px: float = 9.0) -> list[Float]:
    """Every other piece of a path, pieces about `length_px` long."""
    gone = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    if gone[-1] <= length_px:
        return [way]
    marks = np.arange(0.0, gone[-1], length_px)
    ends = np.append(marks[1:], gone[-1])
    out = []
    for low, high in list(zip(marks, ends, strict=True))[::2]:
        at = np.concatenate([[low], gone[(gone > low) & (gone < high)], [high]])
        out.append(np.column_stack([np.interp(at, gone, way[:, k]) for k in (0, 1)]))
    return out


def _polyline(canvas: Picture, way: Float, colour: Colour, width: int) -> None:
    cv2.polylines(canvas, [_fixed(way)], False, colour, width, cv2.LINE_AA, SHIFT)


def _fixed(points: Float) -> npt.NDArray[np.int32]:
    """Pixels in OpenCV's fixed point, kept inside what its integers hold."""
    return np.round(np.clip(points, -1e5, 1e5) * (1 << SHIFT)).astype(np.int32)


def _strip(scene: Scene, time_s: float, width: int) -> Picture:
    """Label, time and key, (STRIP_PX, width, 3)."""
    strip = np.full((STRIP_PX, width, 3), DARK, np.uint8)
    _write(strip, f"{scene.label}   t = {time_s:.2f} s", (8, 15), MEASURED)
    entries = [(line.name, line.colour) for line in scene.lines]
    if scene.keypoints is not None:
        entries.insert(0, ("keypoints", POINT))
    for i, (name, colour) in enumerate(entries):
        left = 8 + 155 * i
        dot = name == "keypoints"
        end = (left + 4 if dot else left + 18, 30)
        cv2.line(strip, (left, 30), end, colour, 4 if dot else 2, cv2.LINE_AA)
        _write(strip, name, (left + 24, 34), MEASURED)
    return strip


def _write(strip: Picture, text: str, at: tuple[int, int], colour: Colour) -> None:
    cv2.putText(strip, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)


def _edges(length: float, width: float) -> Float:
    """Rim of the pool at the water surface, (n, 3), m, densely so that a lens may bend it."""
    s = np.linspace(0, 1, 40)
    zero, one = np.zeros(40), np.ones(40)
    x = np.concatenate([s, one, s[::-1], zero])
    y = np.concatenate([zero, s, one, s[::-1]])
    return np.column_stack([length * x, width * y, np.zeros(160)])


def _grid(length: float, width: float, every_m: float = 0.5) -> Iterator[Float]:
    s = np.linspace(0, 1, 40)
    for x in np.arange(every_m, length, every_m):
        yield np.column_stack([np.full(40, x), width * s, np.zeros(40)])
    for y in np.arange(every_m, width, every_m):
        yield np.column_stack([length * s, np.full(40, y), np.zeros(40)])
