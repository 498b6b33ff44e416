"""Paths, keypoints and the empty pool, drawn in the pixels of a frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
import numpy.typing as npt

from ..camera.pool_projection import PoolCamera, pool_to_pixels
from ..data import Float, Keypoints, is_confident

BgrImage = npt.NDArray[np.uint8]
BgrColour = tuple[int, int, int]

LEGEND_STRIP_HEIGHT_PX = 40
MAX_DETECTION_TO_FRAME_S = 1 / 60
"""Largest time between a detection and the frame it is drawn on."""
OPENCV_FRACTIONAL_BITS = 4  # OpenCV draws at 1/16 px with this many fractional bits

# BGR; distinguishable with colour vision deficiencies, and by dashes and width
LEGEND_STRIP_BGR: BgrColour = (46, 38, 32)
MEASURED_BGR: BgrColour = (255, 255, 255)
BEFORE_BGR: BgrColour = (0, 130, 255)
AFTER_BGR: BgrColour = (255, 200, 60)
KEYPOINT_BGR: BgrColour = (80, 240, 250)


@dataclass(frozen=True)
class OverlayPath:
    """A path in pixels of the raw frame, (n, 2), with its times, (n,), s."""

    name: str
    time_s: Float
    xy_px: Float
    colour: BgrColour
    dashed: bool = False
    width_px: int = 2


@dataclass(frozen=True)
class OverlayContent:
    """Content drawn on the frames of a trial; size_px: width and height of the raw frame."""

    label: str
    size_px: tuple[int, int]
    lines: tuple[OverlayPath, ...]
    keypoints: Keypoints | None = None
    background: BgrImage = field(default_factory=lambda: np.zeros((0, 0, 3), np.uint8))


def annotated_frame(
    picture: BgrImage, scene: OverlayContent, time_s: float, scale: float
) -> BgrImage:
    """The frame with paths up to `time_s`, the keypoints at that time, and a legend."""
    canvas = np.ascontiguousarray(picture)
    for line in scene.lines:
        _draw_path_until(canvas, line, time_s, scale)
    if scene.keypoints is not None:
        _draw_keypoints(canvas, scene.keypoints, time_s, scale)
    return np.vstack([_draw_legend_strip(scene, time_s, canvas.shape[1]), canvas])


def empty_pool_image(camera: PoolCamera, width_px: int) -> BgrImage:
    """The empty pool in the camera's view: walls, and a 0.5 m grid on the water surface."""
    scale = width_px / camera.size_px[0]
    height = 2 * round(scale * camera.size_px[1] / 2)
    canvas = np.full((height, width_px, 3), (96, 88, 80), np.uint8)
    length, width = camera.pool_size_m
    rim = _pool_rim(length, width)
    cv2.fillPoly(
        canvas,
        [_to_fixed_point_pixels(scale * pool_to_pixels(camera, rim))],
        (190, 172, 140),
        shift=OPENCV_FRACTIONAL_BITS,
    )
    for line in _pool_grid(length, width):
        _polyline(canvas, scale * pool_to_pixels(camera, line), (205, 190, 165), 1)
    _polyline(canvas, scale * pool_to_pixels(camera, rim), (235, 235, 235), 2)
    return canvas


def _draw_path_until(canvas: BgrImage, line: OverlayPath, time_s: float, scale: float) -> None:
    shown = (line.time_s <= time_s + 1e-6) & np.isfinite(line.xy_px).all(axis=1)
    path = scale * line.xy_px[shown]
    if len(path) == 0:
        return
    pieces = _dash_segments(path) if line.dashed else [path]
    for piece in pieces if line.width_px > 2 else []:
        _polyline(canvas, piece, LEGEND_STRIP_BGR, line.width_px + 2)
    for piece in pieces:
        _polyline(canvas, piece, line.colour, line.width_px)
    end = _to_fixed_point_pixels(path[-1])
    cv2.circle(
        canvas,
        end,
        5 << OPENCV_FRACTIONAL_BITS,
        LEGEND_STRIP_BGR,
        -1,
        cv2.LINE_AA,
        OPENCV_FRACTIONAL_BITS,
    )
    cv2.circle(
        canvas,
        end,
        3 << OPENCV_FRACTIONAL_BITS,
        line.colour,
        -1,
        cv2.LINE_AA,
        OPENCV_FRACTIONAL_BITS,
    )


def _draw_keypoints(canvas: BgrImage, found: Keypoints, time_s: float, scale: float) -> None:
    i = int(np.argmin(np.abs(found.time_s - time_s)))
    if abs(found.time_s[i] - time_s) > MAX_DETECTION_TO_FRAME_S:
        return
    sure = is_confident(found.likelihood[i]) & np.isfinite(found.xy_px[i]).all(axis=1)
    for point in scale * found.xy_px[i][sure]:
        cv2.circle(
            canvas,
            _to_fixed_point_pixels(point),
            4 << OPENCV_FRACTIONAL_BITS,
            LEGEND_STRIP_BGR,
            -1,
            cv2.LINE_AA,
            OPENCV_FRACTIONAL_BITS,
        )
        cv2.circle(
            canvas,
            _to_fixed_point_pixels(point),
            40,
            KEYPOINT_BGR,
            -1,
            cv2.LINE_AA,
            OPENCV_FRACTIONAL_BITS,
        )


def _dash_segments(path: Float, length_px: float = 9.0) -> list[Float]:
    """Every other piece of a path cut into pieces of `length_px`."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    if length[-1] <= length_px:
        return [path]
    marks = np.arange(0.0, length[-1], length_px)
    ends = np.append(marks[1:], length[-1])
    out = []
    for low, high in list(zip(marks, ends, strict=True))[::2]:
        at = np.concatenate([[low], length[(length > low) & (length < high)], [high]])
        out.append(np.column_stack([np.interp(at, length, path[:, k]) for k in (0, 1)]))
    return out


def _polyline(canvas: BgrImage, path: Float, colour: BgrColour, width: int) -> None:
    cv2.polylines(
        canvas,
        [_to_fixed_point_pixels(path)],
        False,
        colour,
        width,
        cv2.LINE_AA,
        OPENCV_FRACTIONAL_BITS,
    )


def _to_fixed_point_pixels(points: Float) -> npt.NDArray[np.int32]:
    """Pixels in OpenCV's fixed-point format, clipped to its integer range."""
    return np.round(np.clip(points, -1e5, 1e5) * (1 << OPENCV_FRACTIONAL_BITS)).astype(np.int32)


def _draw_legend_strip(scene: OverlayContent, time_s: float, width: int) -> BgrImage:
    """Label, time and legend, (LEGEND_STRIP_HEIGHT_PX, width, 3)."""
    strip = np.full((LEGEND_STRIP_HEIGHT_PX, width, 3), LEGEND_STRIP_BGR, np.uint8)
    _write_text(strip, f"{scene.label}   t = {time_s:.2f} s", (8, 15), MEASURED_BGR)
    entries = [(line.name, line.colour) for line in scene.lines]
    if scene.keypoints is not None:
        entries.insert(0, ("keypoints", KEYPOINT_BGR))
    for i, (name, colour) in enumerate(entries):
        left = 8 + 155 * i
        dot = name == "keypoints"
        end = (left + 4 if dot else left + 18, 30)
        cv2.line(strip, (left, 30), end, colour, 4 if dot else 2, cv2.LINE_AA)
        _write_text(strip, name, (left + 24, 34), MEASURED_BGR)
    return strip


def _write_text(strip: BgrImage, text: str, at: tuple[int, int], colour: BgrColour) -> None:
    cv2.putText(strip, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)


def _pool_rim(length: float, width: float) -> Float:
    """Rim of the pool at the water surface, (n, 3), m, sampled densely for curved projections."""
    s = np.linspace(0, 1, 40)
    zero, one = np.zeros(40), np.ones(40)
    x = np.concatenate([s, one, s[::-1], zero])
    y = np.concatenate([zero, s, one, s[::-1]])
    return np.column_stack([length * x, width * y, np.zeros(160)])


def _pool_grid(length: float, width: float, every_m: float = 0.5) -> Iterator[Float]:
    s = np.linspace(0, 1, 40)
    for x in np.arange(every_m, length, every_m):
        yield np.column_stack([np.full(40, x), width * s, np.zeros(40)])
    for y in np.arange(every_m, width, every_m):
        yield np.column_stack([length * s, np.full(40, y), np.zeros(40)])
