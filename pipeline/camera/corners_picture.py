"""The picture that helps a person give the four pool corners."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ..data import Float
from ..faults import Fault, fault
from ..study import Setup
from ..study.filmed import in_study
from .boards import Grey
from .corners import pool_camera
from .edges import EDGES, Edge, find_edges, suggested_corners
from .png import Picture, write_png
from .pool import PoolCamera, project

GRID_M = 0.2
GIVEN, MAPPED, SEEN, BETTER = (60, 60, 255), (230, 200, 60), (60, 220, 60), (255, 60, 255)


@dataclass(frozen=True)
class CornersCheck:
    """What the frame says of the corners given.

    suggested_px: (4, 2), NaN where two edges were not both found. offset_px, bend_px, share: (4,)
    mean offset of each pool edge, rms bend about a straight edge, part of the edge seen.
    sentences: the same in words, the fault of corners that fit no camera among them. fits: whether
    they fit one. Corners are in the pixels of study.yaml, whatever the frame's size.
    """

    suggested_px: Float
    offset_px: Float
    bend_px: Float
    share: Float
    sentences: tuple[str, ...]
    fits: bool = True


def pool_corners_picture(frame: Picture, setup: Setup, out: str | Path) -> CornersCheck:
    """Corners, mapped grid and pool edges drawn on a frame (height, width[, 3] bgr), as a png.

    Red: corners as given. Light blue: a 0.2 m grid in the plane of the corners, as the camera maps
    it. Green: edges found in the frame. Magenta: corners where those edges meet. Corners that fit
    no camera are drawn all the same, and the fault is told in `sentences`.

    Raises: Fault where the file cannot be written or the frame's shape cannot be.
    """
    grey, canvas = _grey_and_colour(frame)
    size = (grey.shape[1], grey.shape[0])
    try:
        camera = pool_camera(setup, size)
    except Fault as error:
        _draw_given(canvas, np.array(setup.camera.pool_corners_px, dtype=float))
        write_png(out, canvas)
        empty = np.full(4, np.nan)
        nowhere = np.full((4, 2), np.nan)
        return CornersCheck(nowhere, empty, empty, np.zeros(4), (str(error),), fits=False)
    edges = find_edges(grey, camera)
    corners = suggested_corners(camera, edges)
    _draw_grid(canvas, camera)
    for edge in edges:
        _draw_edge(canvas, edge)
    _draw_given(canvas, camera.corners_px)
    _draw_better(canvas, corners)
    write_png(out, canvas)
    told = in_study(setup, size, corners)
    return CornersCheck(
        suggested_px=told,
        offset_px=np.array([(edge.start_px + edge.end_px) / 2 for edge in edges]),
        bend_px=np.array([edge.bend_px for edge in edges]),
        share=np.array([edge.share for edge in edges]),
        sentences=(*_other_size(setup, size), *_sentences(camera, edges, told)),
    )


def _other_size(setup: Setup, size: tuple[int, int]) -> tuple[str, ...]:
    """A word on a frame that is the study's picture scaled."""
    said = setup.camera.image_size_px
    if said is None or tuple(said) == size:
        return ()
    return (
        f"the frame has {size[0]} x {size[1]} px, image_size_px says {said[0]} x {said[1]}: "
        "corners are told in the pixels of image_size_px, all else in those of the frame",
    )


def _sentences(camera: PoolCamera, edges: tuple[Edge, ...], corners: Float) -> tuple[str, ...]:
    lines = [f"corners miss the best pose by {camera.rms_px:.2f} px rms", *camera.remarks]
    for name, edge in zip(EDGES, edges, strict=True):
        if np.isfinite(edge.start_px):
            lines.append(
                f"edge {name}: {edge.start_px:+.1f} px off at its start, {edge.end_px:+.1f} at its "
                f"end, bent by {edge.bend_px:.1f} px rms, {100 * edge.share:.0f} % of it seen"
            )
        else:
            lines.append(f"edge {name}: no straight step in brightness found near it")
    if np.all(np.isfinite(corners)):
        pairs = ", ".join(f"[{u:.1f}, {v:.1f}]" for u, v in corners)
        lines.append(f"pool_corners_px: [{pairs}]   # where the edges meet; check by eye")
    return tuple(lines)


def _grey_and_colour(frame: Picture) -> tuple[Grey, Picture]:
    if frame.ndim == 2:
        return frame, np.ascontiguousarray(np.repeat(frame[:, :, None], 3, axis=2))
    if frame.ndim != 3 or frame.shape[2] != 3:
        raise fault("frame", "", f"shape {frame.shape}", "(height, width) or (height, width, 3)")
    grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    return np.asarray(grey, dtype=np.uint8), np.ascontiguousarray(frame).copy()


def _draw_grid(canvas: Picture, camera: PoolCamera) -> None:
    length, width = camera.pool_size_m
    height = float(camera.corners_m[0, 2])
    xs = np.append(np.arange(0, length, GRID_M), length)
    ys = np.append(np.arange(0, width, GRID_M), width)
    fine_x, fine_y = np.linspace(0, length, 100), np.linspace(0, width, 100)
    lines = [np.column_stack([np.full(100, x), fine_y]) for x in xs]
    lines += [np.column_stack([fine_x, np.full(100, y)]) for y in ys]
    for line in lines:
        image = project(camera, np.column_stack([line, np.full(100, height)]))
        _polyline(canvas, image, MAPPED, 1)


def _draw_edge(canvas: Picture, edge: Edge) -> None:
    seen = np.isfinite(edge.offset_px)
    points = edge.curve_px[seen] + edge.normal_px[seen] * edge.offset_px[seen, None]
    for u, v in np.round(points).astype(int):
        cv2.circle(canvas, (int(u), int(v)), max(1, canvas.shape[1] // 900), SEEN, -1)


def _draw_given(canvas: Picture, corners: Float) -> None:
    scale = canvas.shape[1] / 1920
    _polyline(canvas, np.vstack([corners, corners[:1]]), GIVEN, max(1, round(scale)))
    for label, (u, v) in zip(("0,0", "L,0", "L,W", "0,W"), corners, strict=True):
        place = (round(u), round(v))
        cv2.drawMarker(canvas, place, GIVEN, cv2.MARKER_CROSS, round(40 * scale) + 8, 2)
        cv2.putText(
            canvas, label, (place[0] + 12, place[1] - 12), cv2.FONT_HERSHEY_SIMPLEX,
            max(0.5, scale), GIVEN, 2, cv2.LINE_AA,
        )  # fmt: skip


def _draw_better(canvas: Picture, corners: Float) -> None:
    for u, v in corners[np.isfinite(corners[:, 0])]:
        cv2.circle(canvas, (round(u), round(v)), max(6, canvas.shape[1] // 160), BETTER, 2)


def _polyline(canvas: Picture, points: Float, colour: tuple[int, int, int], width: int) -> None:
    whole = points[np.isfinite(points).all(axis=1)]
    fixed = np.round(whole * 16).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(canvas, [fixed], False, colour, width, cv2.LINE_AA, 4)
