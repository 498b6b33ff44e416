"""Lens-profile json files in Gyroflow's layout (lens model: OpenCV's fisheye)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, InputIssue, input_error
from ..files import read_json
from .lens import Lens
from .lens_selection import lens_implausibilities

STRETCHED_PROFILE_MODES = ("superview", "hyperview", "super", "hyper")
"""Lens modes that stretch the picture by an unknown law; profiles of these are refused."""


def read_lens_profile(path: str | Path) -> tuple[Lens, float, int]:
    """Lens of a profile, its stated corner error in px and number of pictures.

    Raises: InputError for a file that is no profile, a lens mode that stretches the picture
    (SuperView, HyperView), or a digital lens.
    """
    content = read_json(path)
    try:
        fisheye = content["fisheye_params"]
        matrix = np.array(fisheye["camera_matrix"], dtype=float).reshape(3, 3)
        distortion = np.array(fisheye["distortion_coeffs"], dtype=float).reshape(4)
        size = (int(content["calib_dimension"]["w"]), int(content["calib_dimension"]["h"]))
        rms, count = float(fisheye.get("RMS_error", np.nan)), int(content.get("num_images", 0))
    except (KeyError, TypeError, ValueError) as error:
        raise input_error(
            path,
            "",
            f"not a lens profile ({_missing_entry_text(error)})",
            "keys fisheye_params (camera_matrix, distortion_coeffs) and calib_dimension",
        ) from error
    _refuse_distorted_profile_modes(path, content)
    lens = Lens("fisheye", matrix, distortion, size)
    if wrong := lens_implausibilities(lens, size, rms):
        raise InputError(
            InputIssue(str(path), "", reason, "a lens that can be right", "Take another profile.")
            for reason in wrong
        )
    return lens, rms, count


def _missing_entry_text(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"no key {error}"
    return "camera_matrix is 3 x 3, distortion_coeffs has 4 numbers, w and h are whole numbers"


def _refuse_distorted_profile_modes(path: str | Path, content: dict[str, Any]) -> None:
    mode = str(content.get("lens_model") or "").lower()
    stretch = [content.get(f"input_{way}_stretch") or 1.0 for way in ("horizontal", "vertical")]
    model = content.get("distortion_model") or "opencv_fisheye"
    found = {
        f"lens mode {mode}": any(word in mode for word in STRETCHED_PROFILE_MODES),
        f"a digital lens ({content.get('digital_lens')})": bool(content.get("digital_lens")),
        f"a stretch of {stretch}": stretch != [1.0, 1.0],
        f"distortion model {model}": model != "opencv_fisheye",
    }
    for words, applies in found.items():
        if applies:
            raise input_error(
                path,
                "",
                words,
                "a Wide or Linear mode in OpenCV's fisheye model",
                "Record in Linear or Wide, without stabilisation, and calibrate that mode.",
            )
