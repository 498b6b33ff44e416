"""Pictures of a calibration board, from photographs, from videos, or from frames handed in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np

from ..data import Frame
from ..faults import fault
from .boards import Board, Grey, View, detect

VIDEO_SUFFIXES = (".mp4", ".mov", ".avi", ".mkv", ".m4v")
VIDEO_FRAMES = 80
NEW_VIEW_SHARE = 0.03


def grey_pictures(paths: Iterable[str | Path]) -> Iterator[tuple[str, Grey]]:
    """Name and grey picture of each photograph, and of up to 80 frames spread over each video.

    Raises: Fault for a file that is missing or is no picture.
    """
    for path in map(Path, paths):
        if path.suffix.lower() in VIDEO_SUFFIXES:
            yield from _frames(path)
        else:
            yield path.name, _photograph(path)


def from_frames(frames: Iterable[Frame]) -> Iterator[tuple[str, Grey]]:
    """Name and grey picture of frames that are already decoded."""
    for frame in frames:
        yield f"frame {frame.index}", frame.luma


def find_views(
    pictures: Iterable[tuple[str, Grey]], board: Board
) -> tuple[list[View], list[str], tuple[int, int]]:
    """Views of the board, names of pictures without it, and the pictures' size in px.

    A picture whose board has hardly moved since an earlier view adds nothing and is passed over.

    Raises: Fault where the pictures differ in size or none shows the board.
    """
    views: list[View] = []
    without: list[str] = []
    size: tuple[int, int] | None = None
    for name, grey in pictures:
        found = (grey.shape[1], grey.shape[0])
        if size is not None and found != size:
            raise fault(
                name,
                "",
                f"{found[0]} x {found[1]} px",
                f"{size[0]} x {size[1]} px, as the pictures before it",
                "Calibrate each resolution and lens mode for itself.",
            )
        size = found
        view = detect(grey, board, name)
        if view is None:
            without.append(name)
        elif not _seen_before(view, views, size[0]):
            views.append(view)
    if size is None or not views:
        raise fault(
            "calibrate",
            "",
            f"{len(without)} pictures, none with the whole board",
            f"pictures of a board with {board.columns} x {board.rows} inner corners",
            "Count inner corners, not squares: a board of 10 x 7 squares is --pattern 9x6 "
            "(a charuco board's columns first).",
        )
    return views, without, size


def _seen_before(view: View, views: list[View], width: int) -> bool:
    limit = NEW_VIEW_SHARE * width / 10
    return any(
        len(view.image_px) == len(other.image_px)
        and float(np.abs(view.image_px - other.image_px).max()) < limit
        for other in views
    )


def _photograph(path: Path) -> Grey:
    try:
        content = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise fault(path, "", f"an unreadable file ({error.strerror})", "a photograph") from error
    grey = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE) if len(content) else None
    if grey is None:
        raise fault(path, "", "a file that is no picture", "a jpg or png photograph, or a video")
    return np.asarray(grey, dtype=np.uint8)


def _frames(path: Path) -> Iterator[tuple[str, Grey]]:
    video = cv2.VideoCapture(str(path))
    try:
        count = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
        stride = max(1, count // VIDEO_FRAMES)
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
        raise fault(path, "", "a video without a readable frame", "a video of the board")
