"""Frames of a recording, one after the other, as the decoder gives them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from typing import Any

import av
import av.error
import numpy as np

from ..data import Frame, sample_evenly
from .image_sequence import image_sequence_frames
from .luma_planes import Luma, luma_plane
from .prefetch import MIN_BUFFERED_ITEMS, Prefetcher
from .recording import IMAGE_SEQUENCE_CODEC, Recording
from .video_probe import open_container, video_stream

TIME_TOLERANCE_S = 1e-6
PREFETCH_BYTES = 40 * 10**6
"""Memory for frames that are decoded ahead."""
MAX_BUFFERED_FRAMES = 12
BYTES_PER_PIXEL = 1.5
Size = tuple[int, int]


class FrameSource:
    """Frames of a recording: iterate for all of them, as often as wanted, or take a few that are
    `evenly_spaced_frames`.

    A file opened for these is used again by the next iteration: opening one costs as much as
    several frames.
    """

    def __init__(
        self, recording: Recording, colour: bool = False, bgr_size: Size | None = None
    ) -> None:
        self.recording, self.colour, self.bgr_size = recording, colour, bgr_size
        self._open: dict[int, Any] = {}

    def __iter__(self) -> Iterator[Frame]:
        """All frames of the recording's part, in order."""
        return _iterate_frames(self.recording, self.colour, self._open, self.bgr_size)

    def prefetched(self) -> Prefetcher[Frame]:
        """All frames as by iteration, decoded by a thread of their own from now on.

        As many as PREFETCH_BYTES hold, at least MIN_BUFFERED_ITEMS: while something is learned from
        the first of them the decoder should not have to wait.
        """
        width, height = self.recording.size_px
        room = int(PREFETCH_BYTES / (BYTES_PER_PIXEL * width * height))
        return Prefetcher(iter(self), max(MIN_BUFFERED_ITEMS, min(room, MAX_BUFFERED_FRAMES)))

    def evenly_spaced(self, count: int, at_most: int = 0) -> Iterator[Frame]:
        """About `count` frames evenly spaced over the recording's part, decoded alone; up to
        `at_most` where no others have to be decoded for these.
        """
        return evenly_spaced_frames(self.recording, count, at_most=at_most, ready=self._open)


def frames(
    recording: Recording, *, colour: bool = False, bgr_size: Size | None = None
) -> FrameSource:
    """Frames of the recording's part in order, times in s from its first frame shown.

    The luma is a view into the decoder's own picture where the format allows (no copy); bgr only
    if `colour`, reduced to `bgr_size` (width, height) where that is given. Unreadable pictures are
    left out; frames whose time repeats or goes back too. `index` counts the frames read from the
    recording's start, those before start_s included.
    """
    return FrameSource(recording, colour, bgr_size)


def _iterate_frames(
    recording: Recording, colour: bool, ready: dict[int, Any], bgr_size: Size | None = None
) -> Iterator[Frame]:
    if recording.codec == IMAGE_SEQUENCE_CODEC:
        yield from image_sequence_frames(recording, colour=colour, bgr_size=bgr_size)
        return
    last = -np.inf
    for index, (time_s, picture) in enumerate(_timed_pictures(recording, ready)):
        if recording.end_s is not None and time_s > recording.end_s + TIME_TOLERANCE_S:
            return
        if time_s <= last or time_s < (recording.start_s or 0.0) - TIME_TOLERANCE_S:
            continue
        last = time_s
        bgr = _bgr_from_picture(picture, recording, bgr_size) if colour else None
        yield Frame(index, time_s, _rotate_upright(luma_plane(picture), recording), bgr)


def evenly_spaced_frames(
    recording: Recording,
    count: int,
    *,
    at_most: int = 0,
    ready: dict[int, Any] | None = None,
) -> Iterator[Frame]:
    """About `count` frames evenly spaced over the recording's part, decoded alone.

    Only key frames are decoded, all cores at once: a background needs a few pictures, not all.
    Where there are more, up to `at_most` are taken. Of a recording with fewer key frames than
    `count`, some of all, each of which is decoded.
    """
    if recording.codec == IMAGE_SEQUENCE_CODEC:
        yield from image_sequence_frames(recording, colour=False, count=max(count, at_most))
        return
    ready = {} if ready is None else ready
    keys = [(i, key) for i, stamps in enumerate(recording.key_stamps) for key in stamps]
    keys = [(i, key) for i, key in keys if _lies_in_wanted_part(recording, i, key)]
    if len(keys) < count:
        yield from sample_evenly(_iterate_frames(recording, False, {}), count)
        return
    wanted = max(1, count, min(at_most, len(keys)))
    chosen = [keys[j] for j in np.linspace(0, len(keys) - 1, wanted).round().astype(int)]
    for i in range(len(recording.paths)):
        stamps = [key for chapter, key in chosen if chapter == i]
        if stamps:
            yield from _decode_key_frames(recording, i, stamps, ready)


def _bgr_from_picture(picture: Any, recording: Recording, size: Size | None) -> Luma:
    """Colours of a decoded picture; reduced before they are converted, which costs a tenth."""
    if size is not None:
        width, height = size[::-1] if recording.rotation_deg % 180 else size
        picture = picture.reformat(width, height, "bgr24", interpolation="AREA")
    return _rotate_upright(picture.to_ndarray(format="bgr24"), recording)


def _rotate_upright(image: Luma, recording: Recording) -> Luma:
    turns = recording.rotation_deg // 90
    return np.ascontiguousarray(np.rot90(image, turns)) if turns else image


def _timed_pictures(recording: Recording, ready: dict[int, Any]) -> Iterator[tuple[float, Any]]:
    """Time and picture of every readable frame of all chapters."""
    count = 0
    for i in range(len(recording.paths)):
        for own_s, picture in _timed_pictures_of_chapter(recording, i, ready):
            given = recording.fps
            yield (count / given if given else recording.offset_s[i] + own_s), picture
            count += 1


def _timed_pictures_of_chapter(
    recording: Recording, i: int, ready: dict[int, Any]
) -> Iterator[tuple[float, Any]]:
    """Time on the file's own clock (0 at its first frame) and picture of each readable frame."""
    path = recording.paths[i]
    with ready.pop(i, None) or open_container(path) as container:
        stream = video_stream(container, path)
        origin: float | None = None
        for count, picture in enumerate(_decode_packets(container, stream)):
            time_s = picture.time
            if time_s is None:
                time_s = count / recording.nominal_fps
            if origin is None:
                origin = time_s
            if picture.width == stream.width and picture.height == stream.height:
                yield time_s - origin, picture


def _decode_packets(container: Any, stream: Any) -> Iterator[Any]:
    """Pictures that can be decoded: a damaged packet costs its own picture only."""
    for packet in _demux_packets(container, stream):
        with suppress(av.error.FFmpegError):
            yield from packet.decode()


def _demux_packets(container: Any, stream: Any) -> Iterator[Any]:
    with suppress(av.error.FFmpegError):
        yield from container.demux(stream)


def _lies_in_wanted_part(recording: Recording, i: int, stamp: int) -> bool:
    """Whether a key frame lies in the wanted part."""
    time_s = stamp * recording.time_base_s + recording.offset_s[i]
    if recording.fps is not None:  # the file's own clock does not count
        time_s *= recording.nominal_fps / recording.fps
    end = np.inf if recording.end_s is None else recording.end_s
    return (recording.start_s or 0.0) <= time_s <= end


def _decode_key_frames(
    recording: Recording, i: int, stamps: list[int], ready: dict[int, Any]
) -> Iterator[Frame]:
    """Key frames at these stamps, by the decoder that the whole chapter is decoded with later.

    A second decoder would take its threads, and memory for its pictures, again. The packets are
    sought first: seeking empties the decoder, which works on several at a time.
    """
    path = recording.paths[i]
    container = open_container(path)
    stream = video_stream(container, path)
    offset_s = recording.offset_s[i]
    known = recording.first_luma if i == 0 else None
    if known is not None and stamps[0] == recording.key_stamps[0][0]:
        yield Frame(
            -1, stamps[0] * recording.time_base_s + offset_s, _rotate_upright(known, recording)
        )
        stamps = stamps[1:]
    for packet in [*_seek_key_packets(container, stream, stamps), None]:
        with suppress(av.error.FFmpegError):
            for picture in stream.codec_context.decode(packet):
                time_s = float((picture.pts or 0) * stream.time_base)
                image = _rotate_upright(luma_plane(picture), recording)
                yield Frame(-1, time_s + offset_s, image)
    container.seek(recording.key_stamps[i][0], stream=stream, backward=True)
    ready[i] = container


def _seek_key_packets(container: Any, stream: Any, stamps: list[int]) -> Iterator[Any]:
    """The key packet at each stamp."""
    for stamp in stamps:
        container.seek(stamp, stream=stream, backward=True)
        yield from islice((packet for packet in container.demux(stream) if packet.is_keyframe), 1)
