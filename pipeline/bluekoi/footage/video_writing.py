"""H.264 videos that any browser plays, written whole or not at all."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import numpy.typing as npt

from ..files import atomic_write

TIME_BASE_S = Fraction(1, 90000)
RecordedPixels = npt.NDArray[np.uint8]


def encode_h264(
    path: str | Path, pictures: Iterable[RecordedPixels], *, fps: float, size: tuple[int, int],
    crf: int = 23,
) -> int:  # fmt: skip
    """Number of pictures written to an H.264 mp4 (yuv420p, index in front).

    pictures: (height, width) grey or (height, width, 3) bgr; size: width and height, made even.
    """
    rate, count = Fraction(fps).limit_denominator(1001), 0
    options = {"movflags": "faststart"}
    with (
        atomic_write(path) as temporary,
        av.open(str(temporary), "w", format="mp4", options=options) as out,
    ):
        stream = out.add_stream("libx264", rate=rate)
        stream.width, stream.height = (side - side % 2 for side in size)
        stream.pix_fmt, stream.codec_context.time_base = "yuv420p", TIME_BASE_S
        stream.options = {"crf": str(crf), "preset": "superfast"}
        for count, picture in enumerate(pictures, 1):
            kind = "gray" if picture.ndim == 2 else "bgr24"
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=kind)
            frame = frame.reformat(width=stream.width, height=stream.height)
            frame.time_base, frame.pts = TIME_BASE_S, round((count - 1) / rate / TIME_BASE_S)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    return count
