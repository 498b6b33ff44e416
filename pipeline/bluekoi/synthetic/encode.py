"""Frames into an mp4 such as an action camera writes: full range, no B frames, short groups."""

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from bluekoi.files import atomic_write
from bluekoi.synthetic.frame_drawing import ImagePlanes

GOPRO_FRAME_RATE_HZ = Fraction(30000, 1001)
KEYFRAME_INTERVAL_FRAMES = 15
ENCODERS = {"h264": ("libx264", "x264-params"), "hevc": ("libx265", "x265-params")}


def _as_video_frame(planes: ImagePlanes) -> av.VideoFrame:
    height, width = planes.luma.shape
    frame = av.VideoFrame(width, height, "yuvj420p")
    for plane, values in zip(frame.planes, (planes.luma, *planes.chroma), strict=True):
        room = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
        room[: values.shape[0], : values.shape[1]] = values
    return frame


def _open_stream(
    container: av.container.OutputContainer, size_px: tuple[int, int], *, rate: Fraction, codec:
    str, mbit_s: float, preset: str, threads: int,
) -> av.VideoStream:  # fmt: skip
    encoder, key = ENCODERS[codec]
    kbit = round(mbit_s * 1000)
    interval = KEYFRAME_INTERVAL_FRAMES
    rules = f"keyint={interval}:min-keyint={interval}:scenecut=0:bframes=0:ref=1"
    rules += f":vbv-maxrate={round(1.2 * kbit)}:vbv-bufsize={kbit}"
    if codec == "hevc":
        rules += f":log-level=error:pools={threads}:frame-threads=1"
    stream = container.add_stream(encoder, rate=rate, options={"preset": preset, key: rules})
    stream.width, stream.height = size_px
    stream.pix_fmt = "yuvj420p"
    stream.bit_rate = kbit * 1000
    stream.codec_context.color_range = 2
    stream.codec_context.thread_count = threads
    stream.codec_context.time_base = 1 / rate
    return stream


def write_video(
    path: Path,
    frames: Iterator[ImagePlanes],
    *,
    size_px: tuple[int, int],
    rate: Fraction = GOPRO_FRAME_RATE_HZ,
    codec: str = "h264",
    mbit_s: float = 45.0,
    preset: str = "ultrafast",
    threads: int = 1,
) -> int:
    """Number of frames written to `path` (mp4), whole or not at all; frame i stands at `i/rate`."""
    count = 0
    with atomic_write(path) as target, av.open(str(target), "w", format="mp4") as container:
        stream = _open_stream(
            container,
            size_px,
            rate=rate,
            codec=codec,
            mbit_s=mbit_s,
            preset=preset,
            threads=threads,
        )
        for count, planes in enumerate(frames, start=1):
            frame = _as_video_frame(planes)
            frame.pts, frame.time_base = count - 1, 1 / rate
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return count
