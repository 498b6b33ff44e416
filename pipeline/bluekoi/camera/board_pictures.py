"""Pictures of a calibration board, from photographs, from videos, or from frames handed in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ..errors import input_error
from ..study import VIDEO_SUFFIXES
from .boards import Board, BoardView, GreyPicture, find_board
from .image_circle import ImageCircle, image_circle

MAX_VIDEO_FRAMES = 80
"""Frames of a calibration video that are looked at."""
BOARD_PROBE_FRAME_COUNT = 16
"""Frames, spread over a video, of which one at least shows the board: of a video that shows it in
half of its frames, all of them miss it once in 65,000 times."""
MIN_VIEW_MOVEMENT_SHARE_OF_WIDTH = 0.03
"""Movement of the board, over the picture's width, that makes another view."""


def read_grey_pictures(
    paths: Iterable[str | Path], board: Board
) -> Iterator[tuple[str, GreyPicture]]:
    """Name and grey picture of each photograph, and of up to 80 frames spread over each video; of a
    video without the board, which takes long to search, only the first look.

    Raises: InputError for a file that is missing or is no picture.
    """
    for path in map(Path, paths):
        if path.suffix.lower() in VIDEO_SUFFIXES:
            look = list(_evenly_spaced_grey_frames(path, BOARD_PROBE_FRAME_COUNT))
            shown = any(find_board(grey, board, name) for name, grey in look)
            yield from _evenly_spaced_grey_frames(path, MAX_VIDEO_FRAMES) if shown else look
        else:
            yield path.name, _read_photograph(path)


@dataclass(frozen=True)
class BoardViews:
    """Views of the board, names of pictures without it, picture size, image circle if any."""

    views: list[BoardView]
    without: list[str]
    size_px: tuple[int, int]
    circle: ImageCircle | None


def find_board_views(pictures: Iterable[tuple[str, GreyPicture]], board: Board) -> BoardViews:
    """Views of the board in all pictures.

    A picture whose board has hardly moved since an earlier view adds nothing and is skipped.

    Raises: InputError where the pictures differ in size or none shows the board.
    """
    views: list[BoardView] = []
    without: list[str] = []
    brightest: GreyPicture | None = None
    for name, grey in pictures:
        if brightest is None:
            brightest = grey
        elif grey.shape != brightest.shape:
            raise _image_size_mismatch_error(name, grey, brightest)
        brightest = np.maximum(brightest, grey)
        view = find_board(grey, board, name)
        if view is None:
            without.append(name)
        elif not _is_repeated_view(view, views, grey.shape[1]):
            views.append(view)
    if brightest is None or not views:
        raise input_error(
            "calibrate",
            "",
            f"{len(without)} pictures, none with the whole board",
            f"pictures of a board with {board.columns} x {board.rows} inner corners",
            "Count inner corners, not squares: a board of 10 x 7 squares is --pattern 9x6 "
            "(a charuco board's columns first).",
        )
    height, width = brightest.shape
    return BoardViews(views, without, (width, height), image_circle(brightest))


def _image_size_mismatch_error(name: str, grey: GreyPicture, first: GreyPicture) -> Exception:
    return input_error(
        name,
        "",
        f"{grey.shape[1]} x {grey.shape[0]} px",
        f"{first.shape[1]} x {first.shape[0]} px, as the pictures before it",
        "Calibrate each resolution and lens mode separately.",
    )


def _is_repeated_view(view: BoardView, views: list[BoardView], width: int) -> bool:
    limit = MIN_VIEW_MOVEMENT_SHARE_OF_WIDTH * width / 10
    return any(
        len(view.image_px) == len(other.image_px)
        and float(np.abs(view.image_px - other.image_px).max()) < limit
        for other in views
    )


def _read_photograph(path: Path) -> GreyPicture:
    try:
        content = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise input_error(
            path, "", f"an unreadable file ({error.strerror})", "a photograph"
        ) from error
    grey = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE) if len(content) else None
    if grey is None:
        raise input_error(
            path, "", "a file that is no picture", "a jpg or png photograph, or a video"
        )
    return np.asarray(grey, dtype=np.uint8)


def _evenly_spaced_grey_frames(path: Path, most: int) -> Iterator[tuple[str, GreyPicture]]:
    video = cv2.VideoCapture(str(path))
    try:
        count = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
        stride = max(1, -(-count // most))
        index = 0
        while video.isOpened() and video.grab():
            if index % stride == 0:
                good, picture = video.retrieve()
                if good:
                    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
                    yield f"{path.name}, frame {index}", np.asarray(grey, dtype=np.uint8)
            index += 1
    finally:
        video.release()
    if index == 0:
        raise input_error(path, "", "a video without a readable frame", "a video of the board")
