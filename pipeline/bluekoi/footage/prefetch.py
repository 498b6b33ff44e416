"""Items of an iterator prepared in the background, by a thread."""

from __future__ import annotations

from collections.abc import Iterator
from queue import Empty, Full, Queue
from threading import Event, Thread
from types import TracebackType
from typing import Generic, TypeVar

T = TypeVar("T")
MIN_BUFFERED_ITEMS = 3
JOIN_TIMEOUT_S = 0.05


class Prefetcher(Generic[T]):
    """An iterator over `source` that prepares up to `size` items before they are asked for.

    What the source raises is raised where its item would have come. `close`, or leaving it as a
    context, ends the thread and closes the source.
    """

    def __init__(self, source: Iterator[T], size: int = MIN_BUFFERED_ITEMS) -> None:
        self._buffer: Queue[tuple[T | None, BaseException | None]] = Queue(size)
        self._stop = Event()
        self._thread = Thread(target=self._fill, args=(source,), daemon=True)
        self._thread.start()

    def __iter__(self) -> Iterator[T]:
        return self

    def __next__(self) -> T:
        if self._stop.is_set():
            raise StopIteration
        item, error = self._buffer.get()
        if error is not None:
            self._stop.set()
            raise error
        assert item is not None
        return item

    def __enter__(self) -> Prefetcher[T]:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the thread; no item comes after."""
        self._stop.set()
        while self._thread.is_alive():
            self._discard_buffered_items()
            self._thread.join(JOIN_TIMEOUT_S)
        self._discard_buffered_items()

    def _discard_buffered_items(self) -> None:
        while True:
            try:
                self._buffer.get_nowait()
            except Empty:
                return

    def _fill(self, source: Iterator[T]) -> None:
        try:
            for item in source:
                if not self._put(item, None):
                    break
            else:
                self._put(None, StopIteration())
        except BaseException as error:
            self._put(None, error)
        finally:
            if hasattr(source, "close"):
                source.close()

    def _put(self, item: T | None, error: BaseException | None) -> bool:
        """Whether it was taken in; not once the end was asked for."""
        while not self._stop.is_set():
            try:
                self._buffer.put((item, error), timeout=JOIN_TIMEOUT_S)
            except Full:
                continue
            return True
        return False
