"""H.264 videos that any browser plays, written whole or not at all."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import numpy.typing as npt

from ..files import atomic_write

TICK_S = Fraction(1, 90000)
Picture = npt.NDArray[np.uint8]


class Encoder:
    """An open H.264 file; `write` adds a picture (height, width) grey or (height, width, 3) bgr."""

    def __init__(self, container: Any, stream: Any, rate: Fraction) -> None:
        self._container, self._stream, self._rate = container, stream, rate
        self._count, self._last = 0, -1

    def write(self, picture: Picture, time_s: float | None = None) -> None:
        """Add a picture, shown from `time_s` on (from its place at the nominal rate without it).

        Raises: ValueError where the time is not after the last picture's.
        """
        kind = "gray" if picture.ndim == 2 else "bgr24"
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=kind)
        frame = frame.reformat(width=self._stream.width, height=self._stream.height)
        shown_s = self._count / self._rate if time_s is None else time_s
        frame.time_base, frame.pts = TICK_S, round(shown_s / TICK_S)
        if frame.pts <= self._last:
            raise ValueError(f"a picture at {float(shown_s):.6f} s is not after the one before it")
        self._count, self._last = self._count + 1, frame.pts
        self._container.mux(self._stream.encode(frame))

    def finish(self) -> None:
        """Write what the encoder still holds back."""
        self._container.mux(self._stream.encode(None))


@contextmanager
def encoder(
    path: str | Path, *, fps: float, size: tuple[int, int], crf: int = 23
) -> Iterator[Encoder]:
    """An `Encoder` for pictures of `size` (width, height; made even), yuv420p, index in front."""
    options = {"movflags": "faststart"}
    with (
        atomic_write(path) as temporary,
        av.open(str(temporary), "w", format="mp4", options=options) as out,
    ):
        rate = Fraction(fps).limit_denominator(1001)
        stream = out.add_stream("libx264", rate=rate)
        stream.width, stream.height = (side - side % 2 for side in size)
        stream.pix_fmt, stream.codec_context.time_base = "yuv420p", TICK_S
        stream.options = {"crf": str(crf), "preset": "veryfast"}
        one = Encoder(out, stream, rate)
        yield one
        one.finish()


def encode(
    path: str | Path, pictures: Iterable[Picture], *, fps: float, size: tuple[int, int]
) -> int:
    """Number of pictures written to an H.264 mp4 (yuv420p, index in front)."""
    count = 0
    with encoder(path, fps=fps, size=size) as out:
        for picture in pictures:
            out.write(picture)
            count += 1
    return count
