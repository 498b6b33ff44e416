"""Frames made ahead by a thread of their own: the same ones, its faults raised, its end clean."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest
from test_footage import STEADY_TIMES, write_video

from bluekoi.data import SeekableFilm
from bluekoi.footage import frames, open_recording
from bluekoi.footage.frame_reading import FrameSource
from bluekoi.footage.prefetch import MIN_BUFFERED_ITEMS, Prefetcher
from bluekoi.footage.recording import Recording
from bluekoi.keypoints.outline.background import sample_frames


class CountingSource:
    """Numbers up to a count, or to a error; knows how many it gave and whether it was closed."""

    def __init__(self, count: int, error: Exception | None = None) -> None:
        self.given, self.closed = 0, False
        self._count, self._error = count, error

    def __iter__(self) -> Iterator[int]:
        return self

    def __next__(self) -> int:
        if self.given == self._count:
            raise self._error or StopIteration
        self.given += 1
        return self.given - 1

    def close(self) -> None:
        self.closed = True


@pytest.mark.parametrize("count", [0, 1, MIN_BUFFERED_ITEMS, 5 * MIN_BUFFERED_ITEMS])
def test_all_come_in_order_and_then_the_end(count):
    source = CountingSource(count)
    with Prefetcher(source) as made:
        assert list(made) == list(range(count))
        assert list(made) == []
    assert source.closed


def test_no_more_is_made_than_there_is_room_for():
    source = CountingSource(1000)
    with Prefetcher(source) as made:
        assert next(made) == 0
        time.sleep(0.1)
        assert MIN_BUFFERED_ITEMS <= source.given <= MIN_BUFFERED_ITEMS + 2
    assert source.closed
    assert source.given <= MIN_BUFFERED_ITEMS + 3


def test_a_fault_is_raised_in_its_place():
    with Prefetcher(CountingSource(3, OSError("card pulled"))) as made:
        assert [next(made) for _ in range(3)] == [0, 1, 2]
        with pytest.raises(OSError, match="card pulled"):
            next(made)


def test_leaving_early_ends_the_thread():
    before = threading.active_count()
    source = CountingSource(1000)
    made = Prefetcher(source)
    assert next(made) == 0
    assert threading.active_count() == before + 1
    made.close()
    assert threading.active_count() == before
    assert list(made) == []
    assert source.closed


def test_a_film_read_ahead_is_the_film(tmp_path):
    film = frames(open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)]))
    plain = [(frame.index, frame.time_s, int(frame.luma.sum())) for frame in film]
    few = [frame.time_s for frame in film.evenly_spaced(3)]
    with film.prefetched() as made:
        late = [frame.time_s for frame in film.evenly_spaced(3)]
        ahead = [(frame.index, frame.time_s, int(frame.luma.sum())) for frame in made]
    assert ahead == plain
    assert late == few
    again = [(frame.index, frame.time_s, int(frame.luma.sum())) for frame in film]
    assert again == plain


def test_pictures_for_the_background_are_decoded_alone(tmp_path, monkeypatch):
    """Run through for these, a recording was decoded twice or three times."""
    film = frames(open_recording([write_video(tmp_path / "a.mp4", STEADY_TIMES)]))
    assert isinstance(film, SeekableFilm)
    few = [frame.time_s for frame in film.evenly_spaced(3)]
    monkeypatch.setattr(FrameSource, "__iter__", lambda _: pytest.fail("run through"))
    assert [frame.time_s for frame in sample_frames(film, 3)] == few


@pytest.mark.parametrize(
    ("size_px", "room"), [((1920, 1080), 12), ((3840, 2160), MIN_BUFFERED_ITEMS)]
)
def test_as_many_are_made_ahead_as_their_memory_allows(monkeypatch, size_px, room):
    source = CountingSource(1000)
    monkeypatch.setattr(FrameSource, "__iter__", lambda film: source)
    recording = Recording((), size_px, "h264", 1000, 1000, 30.0, (0.0,))
    with FrameSource(recording).prefetched():
        time.sleep(0.1)
        assert room <= source.given <= room + 1
