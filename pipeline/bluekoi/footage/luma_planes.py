"""Brightness of a decoded picture as eight bits, without a copy where the format allows."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Luma = npt.NDArray[np.uint8]


def luma_plane(picture: Any) -> Luma:
    """Brightness (height, width) of a decoded picture; a view where it is planar and 8 bit."""
    plane, name = picture.planes[0], picture.format.name
    if name.startswith(("yuv", "gray", "nv")) and not name.startswith("yuyv"):
        depth = picture.format.components[0].bits
        if depth == 8:
            return _plane_as_array(plane, np.uint8)[: picture.height, : picture.width]
        if name.endswith("le"):
            wide = _plane_as_array(plane, np.dtype("<u2"))[: picture.height, : picture.width]
            narrow = np.empty(wide.shape, np.uint8)
            return np.right_shift(wide, depth - 8, out=narrow, casting="unsafe")
    return picture.to_ndarray(format="gray")


def _plane_as_array(plane: Any, dtype: Any) -> npt.NDArray[Any]:
    width = plane.line_size // np.dtype(dtype).itemsize
    return np.frombuffer(plane, dtype)[: plane.height * width].reshape(plane.height, width)
