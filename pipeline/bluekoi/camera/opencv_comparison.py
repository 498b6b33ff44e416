"""Held-out error of OpenCV's own calibration, for comparison."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from .boards import BoardView
from .lens import Lens
from .lens_bundle_adjustment import START_FOCAL_LENGTHS_IN_WIDTHS

Float32 = npt.NDArray[np.float32]
PINHOLE_FLAGS = {4: cv2.CALIB_FIX_K3, 5: 0, 8: cv2.CALIB_RATIONAL_MODEL}
FISHEYE_FLAG_NAMESPACE = cv2.fisheye if hasattr(cv2.fisheye, "CALIB_FIX_SKEW") else cv2
"""OpenCV 5 moved the flags of the fisheye model and changed their values."""


def opencv_lens(
    views: Sequence[BoardView], model: str, terms: int, size_px: tuple[int, int]
) -> Lens | None:
    """Lens by OpenCV's calibration of the same model; None where it fails for every start.

    The fisheye calibration needs a starting focal length on many sets: the best of several counts.
    """
    board = [view.board_m.astype(np.float32).reshape(1, -1, 3) for view in views]
    image = [view.image_px.astype(np.float32).reshape(1, -1, 2) for view in views]
    if model == "pinhole":
        start = np.zeros((terms if terms > 5 else 5, 1))
        try:
            _, matrix, distortion, *_ = cv2.calibrateCamera(
                board, image, size_px, np.eye(3), start, flags=PINHOLE_FLAGS[terms]
            )
        except cv2.error:
            return None
        return Lens(model, matrix, distortion.ravel()[:terms], size_px)
    fits = [
        fit
        for share in START_FOCAL_LENGTHS_IN_WIDTHS
        if (fit := _calibrate_fisheye(board, image, size_px, share))
    ]
    return min(fits, key=lambda fit: fit[0])[1] if fits else None


def _calibrate_fisheye(
    board: list[Float32], image: list[Float32], size_px: tuple[int, int], share: float
) -> tuple[float, Lens] | None:
    flags = (
        FISHEYE_FLAG_NAMESPACE.CALIB_RECOMPUTE_EXTRINSIC
        | FISHEYE_FLAG_NAMESPACE.CALIB_FIX_SKEW
        | FISHEYE_FLAG_NAMESPACE.CALIB_USE_INTRINSIC_GUESS
    )
    focal, (u, v) = share * size_px[0], (np.array(size_px) - 1) / 2
    matrix = np.array([[focal, 0, u], [0, focal, v], [0, 0, 1.0]])
    try:
        rms, matrix, distortion, *_ = cv2.fisheye.calibrate(
            board, image, size_px, matrix, np.zeros((4, 1)), flags=flags
        )
    except cv2.error:
        return None
    if not (np.isfinite(rms) and np.isfinite(matrix).all()):
        return None
    return float(rms), Lens("fisheye", matrix, distortion.ravel(), size_px)
