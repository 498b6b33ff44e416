"""The pool corners of a study checked against the edges in a frame, and drawn on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ..data import Float
from ..errors import InputError, input_error
from ..study import StudySettings
from ..study.recording_pixels import setup_in_recording_pixels, to_study_pixels
from .boards import GreyPicture
from .png_file import PngPixels, write_png
from .pool_corner_fit import EDGE_NAMES, CornerFit, fit_corners
from .pool_projection import PoolCamera, pool_to_pixels
from .resection import CORNER_NAMES, pool_diagonal_px
from .study_camera import (
    CORNER_TOLERANCE_SHARE_OF_POOL_DIAGONAL,
    lens_of_camera_section,
    pool_camera,
    pool_corners_m,
)

GRID_SPACING_M = 0.2
"""Spacing of the grid drawn over the pool."""
GIVEN_CORNERS_BGR, MAPPED_GRID_BGR, SEEN_EDGES_BGR, FITTED_CORNERS_BGR = (
    (60, 60, 255),
    (230, 200, 60),
    (60, 220, 60),
    (255, 60, 255),
)
"""Colours (blue, green, red) of the corners given, the grid mapped from them, the edges seen and
the corners fitted.
"""
MAX_POOL_CORNER_OFFSET_SIGMAS = 3.0
"""Standard deviations by which a given corner may be off the fitted one."""


@dataclass(frozen=True)
class CornersCheck:
    """What the edges in a frame say about the corners given.

    suggested_px: (4, 2) where the edges meet, NaN where two were not both found; std_px: (4,) of
    their coordinates. off_px: (4,) distance of the corners given from there. sentences: the same
    in words. confirmed: whether the edges are certain and the corners given agree with them.
    Corners are in the pixels of study.yaml, whatever the frame's size.
    """

    suggested_px: Float
    std_px: Float
    off_px: Float
    sentences: tuple[str, ...]
    confirmed: bool


@dataclass(frozen=True)
class CornersComparison:
    """The corners given beside those fitted, in the pixels of the frame.

    given_px: (4, 2). camera: by the corners given, None where they fit no camera. check: the same
    in the pixels of study.yaml and in words.
    """

    given_px: Float
    fit: CornerFit
    camera: PoolCamera | None
    check: CornersCheck


def pool_corners_picture(frame: PngPixels, setup: StudySettings, out: str | Path) -> CornersCheck:
    """Corners, mapped grid and pool edges drawn on a frame (height, width[, 3] bgr), as a png.

    Red: corners as given. Light blue: a 0.2 m grid in the plane of the corners, as the camera maps
    it. Green: edges found in the frame. Magenta: corners where those edges meet. Corners that fit
    no camera are drawn all the same, with the error in `sentences`.

    Raises: InputError where the file cannot be written or the frame's shape cannot be.
    """
    grey, canvas = _grey_and_colour(frame)
    found = compare_corners(grey, setup)
    if found.camera is not None:
        for image in projected_pool_grid_px(found.camera):
            _draw_polyline(canvas, image, MAPPED_GRID_BGR, 1)
    for points in edge_points_px(found.fit):
        _draw_edge_points(canvas, points)
    _draw_given_corners(canvas, found.given_px)
    _draw_fitted_corners(canvas, found.fit.corners_px)
    write_png(out, canvas)
    return found.check


def compare_corners(grey: GreyPicture, setup: StudySettings) -> CornersComparison:
    """The corners of a study compared with the edges of the pool in a frame (height, width).

    Raises: InputError where the frame's shape is not that of the study's picture.
    """
    size = (grey.shape[1], grey.shape[0])
    filmed = setup_in_recording_pixels(setup, size).camera
    given = np.array(filmed.pool_corners_px, dtype=float)
    fit = fit_corners(grey, given, lens_of_camera_section(filmed), pool_corners_m(setup))
    camera, about = _camera_from_given_corners(setup, size)
    off = np.linalg.norm(fit.corners_px - given, axis=1)
    doubts = (*fit.doubts, *_pose_misfit_sentence(setup, size, fit))
    wrong = _displaced_corner_sentences(off, fit, given)
    sentences = (
        *_scaled_frame_remark(setup, size),
        *about,
        *_pool_edge_fit_sentences(fit),
        *doubts,
        *wrong,
    )
    check = CornersCheck(
        suggested_px=to_study_pixels(setup, size, fit.corners_px),
        std_px=fit.std_px,
        off_px=off,
        sentences=(*sentences, *_corner_suggestion_lines(setup, size, fit, certain=not doubts)),
        confirmed=camera is not None and not doubts and not wrong,
    )
    return CornersComparison(given, fit, camera, check)


def _camera_from_given_corners(
    setup: StudySettings, size: tuple[int, int]
) -> tuple[PoolCamera | None, tuple[str, ...]]:
    """Camera by the corners given, and how well they fit a pose (which takes a camera matrix)."""
    try:
        camera = pool_camera(setup, size)
    except InputError as error:
        return None, (str(error),)
    if camera.lens is None:
        return camera, camera.remarks
    miss = f"the corners given miss the best pose by {camera.rms_px:.2f} px rms"
    return camera, (miss, *camera.remarks)


def _pose_misfit_sentence(
    setup: StudySettings, size: tuple[int, int], fit: CornerFit
) -> tuple[str, ...]:
    """A doubt where the corners found fit no pose of the lens over a pool of this size."""
    if setup.camera.matrix is None or not np.isfinite(fit.corners_px).all():
        return ()
    try:
        camera = pool_camera(
            settings_with_pool_corners(setup, to_study_pixels(setup, size, fit.corners_px)), size
        )
    except InputError as error:
        return (f"the corners found fit no camera: {error}",)
    if camera.rms_px <= CORNER_TOLERANCE_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(fit.corners_px):
        return ()
    return (f"the corners found miss the best pose by {camera.rms_px:.1f} px rms",)


def settings_with_pool_corners(setup: StudySettings, corners_px: Float) -> StudySettings:
    """Setup with other pool corners (4, 2), in the pixels of study.yaml."""
    corners = tuple((float(u), float(v)) for u, v in corners_px)
    camera = setup.camera.model_copy(update={"pool_corners_px": corners})
    return setup.model_copy(update={"camera": camera})


def corner_tolerance_px(fit: CornerFit, given_px: Float) -> Float:
    """Distance (4,) px by which a corner given by eye may lie from the one found."""
    return np.hypot(
        MAX_POOL_CORNER_OFFSET_SIGMAS * fit.std_px,
        CORNER_TOLERANCE_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(given_px),
    )


def _displaced_corner_sentences(off_px: Float, fit: CornerFit, given_px: Float) -> tuple[str, ...]:
    far = off_px > corner_tolerance_px(fit, given_px)
    return tuple(
        f"corner {CORNER_NAMES[k]} lies {off_px[k]:.1f} px from where the edges meet"
        for k in np.flatnonzero(far)
    )


def _scaled_frame_remark(setup: StudySettings, size: tuple[int, int]) -> tuple[str, ...]:
    """A remark on a frame that is the study's picture scaled."""
    stated = setup.camera.image_size_px
    if stated is None or tuple(stated) == size:
        return ()
    return (
        f"the frame has {size[0]} x {size[1]} px, image_size_px says {stated[0]} x {stated[1]}: "
        "corners are given in the pixels of image_size_px, all else in those of the frame",
    )


def _pool_edge_fit_sentences(fit: CornerFit) -> tuple[str, ...]:
    return tuple(
        f"edge {name}: straight within {line.bend_px:.1f} px rms, {100 * line.share:.0f} % of it "
        "seen"
        for name, line in zip(EDGE_NAMES, fit.lines, strict=True)
        if line is not None
    )


def _corner_suggestion_lines(
    setup: StudySettings, size: tuple[int, int], fit: CornerFit, *, certain: bool
) -> tuple[str, ...]:
    lines = []
    if np.isfinite(fit.corners_px).all():
        count = f"after {fit.iterations} iterations"
        std = f"each within {np.max(fit.std_px):.1f} px (standard deviation)"
        trust = f"{std}, {count}" if certain else f"NOT certain, {count}: check by eye"
        lines.append(
            f"{_corners_as_yaml_key(setup, size, fit.corners_px)}   # where the edges meet; {trust}"
        )
    if fit.outer_px > 0:
        lines.append(f"another rim lies {fit.outer_px:.0f} px outside; the inner one is used")
    if fit.rim_px > 0:
        lines.append(f"{_corners_as_yaml_key(setup, size, fit.inner_rim_px)}   # the inner rim")
    return tuple(lines)


def _corners_as_yaml_key(setup: StudySettings, size: tuple[int, int], corners_px: Float) -> str:
    corners = to_study_pixels(setup, size, corners_px)
    return f"pool_corners_px: [{', '.join(f'[{u:.1f}, {v:.1f}]' for u, v in corners)}]"


def _grey_and_colour(frame: PngPixels) -> tuple[GreyPicture, PngPixels]:
    if frame.ndim == 2:
        return frame, np.ascontiguousarray(np.repeat(frame[:, :, None], 3, axis=2))
    if frame.ndim != 3 or frame.shape[2] != 3:
        raise input_error(
            "frame", "", f"shape {frame.shape}", "(height, width) or (height, width, 3)"
        )
    grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    return np.asarray(grey, dtype=np.uint8), np.ascontiguousarray(frame).copy()


def projected_pool_grid_px(camera: PoolCamera) -> list[Float]:
    """Images (n, 2) of a 0.2 m grid in the plane of the corners, a polyline each."""
    length, width = camera.pool_size_m
    height = float(camera.corners_m[0, 2])
    xs = np.append(np.arange(0, length, GRID_SPACING_M), length)
    ys = np.append(np.arange(0, width, GRID_SPACING_M), width)
    fine_x, fine_y = np.linspace(0, length, 100), np.linspace(0, width, 100)
    lines = [np.column_stack([np.full(100, x), fine_y]) for x in xs]
    lines += [np.column_stack([fine_x, np.full(100, y)]) for y in ys]
    return [pool_to_pixels(camera, np.column_stack([line, np.full(100, height)])) for line in lines]


def edge_points_px(fit: CornerFit) -> list[Float]:
    """Points (n, 2) of each edge where it was seen; none of an edge that was not found."""
    found = []
    for curve, line in zip(fit.curves, fit.lines, strict=True):
        if line is None:
            found.append(np.empty((0, 2)))
            continue
        seen = np.isfinite(line.steps_px)
        found.append(curve.points_px[seen] + curve.normal_px[seen] * line.steps_px[seen, None])
    return found


def _draw_edge_points(canvas: PngPixels, points: Float) -> None:
    for u, v in np.round(points).astype(int):
        cv2.circle(canvas, (int(u), int(v)), max(1, canvas.shape[1] // 900), SEEN_EDGES_BGR, -1)


def _draw_given_corners(canvas: PngPixels, corners: Float) -> None:
    scale = canvas.shape[1] / 1920
    _draw_polyline(
        canvas, np.vstack([corners, corners[:1]]), GIVEN_CORNERS_BGR, max(1, round(scale))
    )
    for label, (u, v) in zip(("0,0", "L,0", "L,W", "0,W"), corners, strict=True):
        place = (round(u), round(v))
        cv2.drawMarker(canvas, place, GIVEN_CORNERS_BGR, cv2.MARKER_CROSS, round(40 * scale) + 8, 2)
        cv2.putText(
            canvas, label, (place[0] + 12, place[1] - 12), cv2.FONT_HERSHEY_SIMPLEX,
            max(0.5, scale), GIVEN_CORNERS_BGR, 2, cv2.LINE_AA,
        )  # fmt: skip


def _draw_fitted_corners(canvas: PngPixels, corners: Float) -> None:
    for u, v in corners[np.isfinite(corners[:, 0])]:
        cv2.circle(
            canvas, (round(u), round(v)), max(6, canvas.shape[1] // 160), FITTED_CORNERS_BGR, 2
        )


def _draw_polyline(
    canvas: PngPixels, points: Float, colour: tuple[int, int, int], width: int
) -> None:
    whole = points[np.isfinite(points).all(axis=1)]
    fixed = np.round(whole * 16).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(canvas, [fixed], False, colour, width, cv2.LINE_AA, 4)
