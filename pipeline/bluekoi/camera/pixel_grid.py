"""A frame under a grid of pixels, to read the pool's corners off before any are known."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ..study.recording_pixels import recording_to_declared_size_ratio
from .png_file import PngPixels, write_png

MAX_GRID_LINES = 20
"""Lines over the longer side of the picture, at most."""
LIGHT_LABEL_BGR, DARK_OUTLINE_BGR = (255, 255, 255), (40, 40, 40)
"""Colours of the lines and of the outlines of their labels."""


def frame_with_pixel_grid(
    frame: PngPixels, out: str | Path, image_size_px: tuple[int, int] | None = None
) -> tuple[str, ...]:
    """A frame (height, width, 3) bgr with labelled lines every so many pixels, as a png.

    image_size_px: of study.yaml, in whose pixels the lines are labelled; None for the frame's own.

    Returns what a person has to do, in sentences. Raises: InputError where the file cannot be
    written, or the frame is not the picture of study.yaml, scaled alike in both directions.
    """
    canvas = np.ascontiguousarray(frame).copy()
    height, width = canvas.shape[:2]
    columns, rows = image_size_px or (width, height)
    scale = recording_to_declared_size_ratio(image_size_px, (width, height), "the frame")
    step = _next_round_number(max(columns, rows) / MAX_GRID_LINES)
    for at in range(step, columns, step):
        u = _to_frame_px(at, scale)
        cv2.line(canvas, (u, 0), (u, height), LIGHT_LABEL_BGR, 1)
        _draw_label(canvas, str(at), (u + 3, 16))
        _draw_label(canvas, str(at), (u + 3, height - 6))
    for at in range(step, rows, step):
        v = _to_frame_px(at, scale)
        cv2.line(canvas, (0, v), (width, v), LIGHT_LABEL_BGR, 1)
        _draw_label(canvas, str(at), (3, v - 4))
        _draw_label(canvas, str(at), (width - 60, v - 4))
    write_png(out, canvas)
    scaled = (
        f"the frame has {width} x {height} px, image_size_px says {columns} x {rows}: the lines "
        "are labelled in the pixels of image_size_px, in which corners are given",
    )
    return (
        f"{out} has a line every {step} px: u from the left edge, v from the top edge",
        *(scaled if scale != 1.0 else ()),
        "read off where the pool's four inner corners meet the water, in the order (0,0), (L,0), "
        "(L,W), (0,W), so that they go once around the pool",
        "write into study.yaml, under camera: pool_corners_px: [[u, v], [u, v], [u, v], [u, v]]",
        "then run this command again: it draws the mapped grid and finds where the edges meet",
    )


def _to_frame_px(at: int, scale: float) -> int:
    """Pixel of the frame at a pixel of the picture of study.yaml; centres lie at whole numbers."""
    return round((at + 0.5) * scale - 0.5)


def _next_round_number(least: float) -> int:
    """The next of 1, 2, 5 times a power of ten, at least 10."""
    power = 10 ** int(np.floor(np.log10(max(least, 10.0))))
    return int(next(power * k for k in (1, 2, 5, 10) if power * k >= least))


def _draw_label(canvas: PngPixels, text: str, place: tuple[int, int]) -> None:
    for colour, thick in ((DARK_OUTLINE_BGR, 3), (LIGHT_LABEL_BGR, 1)):
        cv2.putText(canvas, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, thick,
                    cv2.LINE_AA)  # fmt: skip
