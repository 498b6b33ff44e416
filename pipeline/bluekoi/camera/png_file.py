"""A drawn picture as a png file, whole or not at all."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from ..errors import input_error
from ..files import atomic_write

PngPixels = npt.NDArray[np.uint8]


def write_png(out: str | Path, canvas: PngPixels) -> None:
    """Write (height, width, 3) bgr. Raises: InputError where it cannot be written."""
    good, content = cv2.imencode(".png", canvas)
    if not good:
        raise input_error(out, "", "a picture that cannot be encoded", "a frame of a recording")
    with atomic_write(out) as temporary:
        temporary.write_bytes(content.tobytes())
