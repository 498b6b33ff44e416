"""Corners of a chessboard or ChArUco board in a grey picture, refined below the pixel."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from ..data import Float
from ..errors import input_error

GreyPicture = npt.NDArray[np.uint8]
BOARD_KINDS = ("chessboard", "charuco")
"""Kinds of calibration board."""
ARUCO_DICTIONARIES = (
    "DICT_4X4_250", "DICT_5X5_250", "DICT_6X6_250", "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_36h11",
)  # fmt: skip
"""Marker sets of OpenCV that are tried in turn on a ChArUco board."""
MARKER_SIDE_SHARE_OF_SQUARE = 0.75
"""Side of a ChArUco marker over the side of its square."""
REFINEMENT_WINDOWS_IN_SQUARES = (0.12, 0.18, 0.25, 0.32)
"""Half widths of the windows in which a corner is refined, over the side of a square; the median
of the results counts.
"""
MIN_BOARD_CORNERS = 12
"""Corners that a picture must show to be used."""
MIN_SHARE_OF_CORNERS_TO_STOP_SEARCH = 0.3
"""Share of the board's corners above which a marker set is the right one, and no other is tried."""


@dataclass(frozen=True)
class Board:
    """Inner corners (columns, rows), square side in m, and kind: chessboard or charuco."""

    columns: int
    rows: int
    square_m: float
    kind: str = "chessboard"

    @property
    def corners_m(self) -> Float:
        """Inner corners (columns * rows, 3) on the board, row by row."""
        x, y = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        flat = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        return np.asarray(flat * self.square_m, dtype=np.float64)


@dataclass(frozen=True)
class BoardView:
    """One picture of the board: its name, corners on the board (n, 3) m and in it (n, 2) px."""

    name: str
    board_m: Float
    image_px: Float


def board_from_pattern(pattern: str, square_mm: float, kind: str) -> Board:
    """Board of a pattern such as `9x6`: inner corners across and down.

    Raises: InputError where the pattern, the size or the kind cannot be.
    """
    sides = pattern.lower().split("x")
    if len(sides) != 2 or not all(side.isdigit() and 3 <= int(side) <= 60 for side in sides):
        raise input_error(
            "--pattern", "", f"'{pattern}'", "inner corners across x down, such as 9x6"
        )
    if not 0.1 <= square_mm <= 10_000:
        raise input_error("--square-mm", "", square_mm, "the side of a square in mm, 0.1 to 10000")
    if kind not in BOARD_KINDS:
        raise input_error("--board", "", f"'{kind}'", f"one of {', '.join(BOARD_KINDS)}")
    return Board(int(sides[0]), int(sides[1]), square_mm / 1000, kind)


def find_board(grey: GreyPicture, board: Board, name: str) -> BoardView | None:
    """View of the board in a picture, or None where it is not found."""
    return (
        _find_charuco_board(grey, board, name)
        if board.kind == "charuco"
        else _find_chessboard(grey, board, name)
    )


def refine_corners(grey: GreyPicture, corners_px: Float, square_px: float) -> Float:
    """Corners (n, 2) at the saddle of the picture: the median over several window sizes.

    A window that reaches the next corner or the board's edge runs away; the median of four does
    not. Source of the single step: OpenCV cornerSubPix.
    """
    start = corners_px.reshape(-1, 1, 2).astype(np.float32)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    found = []
    for share in REFINEMENT_WINDOWS_IN_SQUARES:
        half = int(np.clip(round(square_px * share), 2, 25))
        found.append(cv2.cornerSubPix(grey, start.copy(), (half, half), (-1, -1), stop))
    return np.median(np.array(found, dtype=float), axis=0).reshape(-1, 2)


def _find_chessboard(grey: GreyPicture, board: Board, name: str) -> BoardView | None:
    size = (board.columns, board.rows)
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, corners = cv2.findChessboardCorners(grey, size, flags=flags)
    if not found:
        sector = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
        found, corners = cv2.findChessboardCornersSB(grey, size, flags=sector)
    if not found:
        return None
    grid = np.asarray(corners, dtype=float).reshape(board.rows, board.columns, 2)
    steps = [np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in range(2)]
    refined = refine_corners(grey, grid.reshape(-1, 2), float(min(steps)))
    return BoardView(name, board.corners_m, refined)


def _find_charuco_board(grey: GreyPicture, board: Board, name: str) -> BoardView | None:
    best = None
    for dictionary in ARUCO_DICTIONARIES:
        detector = _charuco_detector(board, dictionary)
        corners, numbers = detector.detectBoard(grey)[:2]
        if numbers is None or len(numbers) < MIN_BOARD_CORNERS:
            continue
        if best is None or len(numbers) > len(best.board_m):
            placed = board.corners_m[np.ravel(numbers)]
            best = BoardView(name, placed, np.asarray(corners, dtype=float).reshape(-1, 2))
        if len(best.board_m) > MIN_SHARE_OF_CORNERS_TO_STOP_SEARCH * len(board.corners_m):
            break
    return best


@lru_cache(maxsize=16)
def _charuco_detector(board: Board, dictionary: str) -> cv2.aruco.CharucoDetector:
    squares = (board.columns + 1, board.rows + 1)
    markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    side = board.square_m
    return cv2.aruco.CharucoDetector(
        cv2.aruco.CharucoBoard(squares, side, side * MARKER_SIDE_SHARE_OF_SQUARE, markers)
    )
