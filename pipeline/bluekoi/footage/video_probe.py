"""What one video file holds: size, rate, rotation, frames declared and frames present."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import av.error

from ..errors import InputError, input_error
from .luma_planes import Luma, luma_plane
from .mp4_boxes import ContainerBoxes

SKIP_DECODING = {"skip_frame": "all"}
"""Option of the container: packets are listed, pictures not decoded."""
MAX_SIDE_PX = 16384
MIN_LISTED_FRAMES_SHARE = 0.5
"""Share of the expected frames that a file must list where it does not state their number."""
MAX_DURATION_ROUNDING_FRAMES = (
    3  # frames that a duration in milliseconds and a mean rate may be off by
)
TRUNCATED_FILE_REMARK = "cut short"
"""First words of the remark on a file that holds fewer frames than it declares."""
MAX_REORDERED_FRAMES = 4.5  # encoders that reorder frames write an edit list of up to this many


@dataclass(frozen=True)
class VideoProperties:
    """One file: size as stored, rate, counts, duration on its own clock, remarks, key frames."""

    size_px: tuple[int, int]
    codec: str
    fps: float
    duration_s: float
    frames_declared: int
    frames_present: int
    rotation_deg: int
    capture_fps: float | None
    remarks: tuple[str, ...]
    key_stamps: tuple[int, ...] = ()
    time_base_s: float = 1.0
    first_luma: Luma | None = None


def video_properties(path: Path, boxes: ContainerBoxes | None) -> VideoProperties:
    """Probe of a file, its first picture decoded to be sure that it can be.

    Raises: InputError where the file is no video or its codec cannot be decoded.
    """
    with open_container(path) as container:
        stream = video_stream(container, path)
        fps = _frame_rate(stream)
        duration = _video_duration_s(container, stream, fps)
        declared, present = _frame_counts(stream, path, duration * fps)
        first = _first_picture(container, stream, path)
        rotation = round(first.rotation / 90.0) * 90 % 360
        keys = _key_frame_timestamps(stream, path.stat().st_size)
        return VideoProperties(
            size_px=(stream.width, stream.height),
            codec=stream.codec_context.name,
            fps=fps,
            duration_s=duration,
            frames_declared=declared,
            frames_present=present,
            rotation_deg=rotation,
            capture_fps=_capture_rate(container, stream),
            remarks=_probe_remarks(container, stream, boxes, (declared, present, rotation, fps)),
            key_stamps=keys,
            time_base_s=float(stream.time_base or 1),
            first_luma=luma_plane(first).copy() if (first.pts,) == keys[:1] else None,
        )


def open_container(path: Path) -> Any:
    """Open container of a file; InputError in a person's words where that fails.

    It opens without decoding a picture, which costs as much as several frames; only where the
    size is not known without that, it is opened again in the usual way.
    """
    try:
        container = av.open(str(path), options=SKIP_DECODING, metadata_errors="replace")
        if all(s.codec_context is None or s.width for s in container.streams.video):
            return container
        container.close()
        return av.open(str(path), metadata_errors="replace")
    except (av.error.FFmpegError, OSError, ValueError) as error:
        raise _unreadable_video_error(path, error) from error


def video_stream(container: Any, path: Path) -> Any:
    """The first real video stream (a cover picture is none), decoding on all cores."""
    for stream in container.streams.video:
        context = stream.codec_context
        if context is None or not (0 < stream.width <= MAX_SIDE_PX):
            continue
        if not context.is_open:
            stream.thread_type = "AUTO"
        return stream
    raise input_error(
        path,
        "",
        "no video stream that can be decoded",
        "H.264, HEVC or mp4v video",
        _CONVERT_REMEDY,
    )


_CONVERT_REMEDY = "Convert it: ffmpeg -i FILE -c:v libx264 -crf 12 -fps_mode passthrough NEW.mp4"


def _unreadable_video_error(path: Path, error: Exception) -> InputError:
    with path.open("rb") as file:
        head = file.read(512)
    text = head.isascii() and b"\0" not in head
    found = "a text file" if text else f"no readable video ({_decoder_message(error)})"
    return input_error(
        path, "", found, "a video (mp4, mov, avi, mkv)", "Check that the copy is complete."
    )


def _decoder_message(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error).strip()


def _frame_counts(stream: Any, path: Path, expected: float) -> tuple[int, int]:
    """Frames the index lists, and those whose bytes lie inside the file.

    expected: frames by duration and rate. Where the index lists too few (that of Matroska has
    key frames alone, a cut AVI has none) the pictures are counted, none of them decoded, and
    the header, or else `expected`, is what the file declares.
    """
    entries = [(entry.pos, entry.size) for entry in stream.index_entries]
    declared = int(stream.frames) or len(entries)
    enough = (
        int(stream.frames) or MIN_LISTED_FRAMES_SHARE * expected
    ) - MAX_DURATION_ROUNDING_FRAMES
    if not entries or len(entries) < enough:
        present, expected = _count_frames_by_reading(path), int(stream.frames) or expected
        whole = present >= expected - MAX_DURATION_ROUNDING_FRAMES
        return (present if whole else round(expected)), present
    size = path.stat().st_size
    lost = sum(1 for pos, length in entries if pos + length > size)
    return declared, declared - lost


def _count_frames_by_reading(path: Path) -> int:
    """Pictures in a file, by reading through it to where it can no longer be read."""
    found = 0
    with open_container(path) as container:
        try:
            for packet in container.demux(video_stream(container, path)):
                found += packet.size > 0
        except av.error.FFmpegError:
            pass
    return found


def _key_frame_timestamps(stream: Any, size: int) -> tuple[int, ...]:
    """Timestamps (stream units) of the key frames whose bytes are in the file."""
    entries = stream.index_entries
    return tuple(int(e.timestamp) for e in entries if e.is_keyframe and e.pos + e.size <= size)


def _first_picture(container: Any, stream: Any, path: Path) -> Any:
    """The first picture decoded, whose rotation is the turn that the file asks for."""
    try:
        for frame in container.decode(stream):
            return frame
    except av.error.FFmpegError as error:
        name = stream.codec_context.name
        found = f"{name} that cannot be decoded ({_decoder_message(error)})"
        raise input_error(path, "", found, "H.264, HEVC or mp4v video", _CONVERT_REMEDY) from error
    raise input_error(path, "", "not one readable frame", "a video with at least one frame")


def _frame_rate(stream: Any) -> float:
    rate = stream.average_rate or stream.base_rate or stream.guessed_rate
    return float(rate) if rate else 25.0


def _video_duration_s(container: Any, stream: Any, fps: float) -> float:
    """Length on the video's own clock (the container's may be that of the sound)."""
    if stream.duration and stream.time_base:
        return float(stream.duration * stream.time_base)
    if container.duration:
        return container.duration / av.time_base
    return int(stream.frames) / fps


def _capture_rate(container: Any, stream: Any) -> float | None:
    """Rate at which a telephone says it took the pictures, where it says so."""
    text = (container.metadata | stream.metadata).get("com.android.capture.fps", "")
    try:
        return float(text) or None
    except ValueError:
        return None


def _probe_remarks(
    container: Any, stream: Any, boxes: ContainerBoxes | None, counts: tuple[int, int, int, float]
) -> tuple[str, ...]:
    declared, present, rotation, fps = counts
    found = []
    if present < declared or (boxes is not None and boxes.cut and present == declared):
        found.append(
            f"{TRUNCATED_FILE_REMARK}: {present} of {declared} declared frames are in the file; "
            "the readable ones are used"
        )
    if rotation:
        found.append(_rotation_remark(rotation))
    if boxes is not None:
        found.extend(_box_remarks(container, boxes, fps))
    if _has_variable_frame_rate(stream, fps):
        found.append("variable frame rate: the timestamps of the frames are used")
    return tuple(found)


def _rotation_remark(rotation: int) -> str:
    text = f"the file asks for a turn of {rotation} degrees, which was applied"
    if rotation % 180:
        text += (
            "; width and height are swapped, so a camera matrix of the unturned picture is wrong"
        )
    return text


def _box_remarks(container: Any, boxes: ContainerBoxes, fps: float) -> list[str]:
    found = []
    if boxes.trimmed_s * fps > MAX_REORDERED_FRAMES:
        found.append(f"trimmed: an edit list leaves out the first {boxes.trimmed_s:.3f} s")
    if boxes.gopro.get("EISE") == "Y":
        found.append("filmed with stabilisation on: the picture may drift against the pool")
    if boxes.gopro and not container.streams.audio:
        found.append("a GoPro file without sound: make sure that it is no time-lapse or TimeWarp")
    return found


def _has_variable_frame_rate(stream: Any, fps: float) -> bool:
    times = sorted(entry.timestamp for entry in stream.index_entries)
    steps = [b - a for a, b in pairwise(times)]
    if len(steps) < 3 or not stream.time_base:
        return False
    usual = 1.0 / fps
    odd = sum(1 for step in steps if abs(float(step * stream.time_base) - usual) > 0.2 * usual)
    return odd > 0
