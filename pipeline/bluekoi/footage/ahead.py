"""Things of an iterator made ahead of their use, by a thread of their own."""

from __future__ import annotations

from collections.abc import Iterator
from queue import Empty, Full, Queue
from threading import Event, Thread
from types import TracebackType
from typing import Generic, TypeVar

T = TypeVar("T")
MOST = 3
PATIENCE_S = 0.05


class Ahead(Generic[T]):
    """An iterator over `source`, of which up to `most` things are made before they are asked for.

    What the source raises is raised where its thing would have come. `close`, or leaving it as a
    context, ends the thread and closes the source.
    """

    def __init__(self, source: Iterator[T], most: int = MOST) -> None:
        self._made: Queue[tuple[T | None, BaseException | None]] = Queue(most)
        self._stop = Event()
        self._thread = Thread(target=self._make, args=(source,), daemon=True)
        self._thread.start()

    def __iter__(self) -> Iterator[T]:
        return self

    def __next__(self) -> T:
        if self._stop.is_set():
            raise StopIteration
        thing, error = self._made.get()
        if error is not None:
            self._stop.set()
            raise error
        assert thing is not None
        return thing

    def __enter__(self) -> Ahead[T]:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the thread; nothing more comes."""
        self._stop.set()
        while self._thread.is_alive():
            self._drop()
            self._thread.join(PATIENCE_S)
        self._drop()

    def _drop(self) -> None:
        while True:
            try:
                self._made.get_nowait()
            except Empty:
                return

    def _make(self, source: Iterator[T]) -> None:
        try:
            for thing in source:
                if not self._put(thing, None):
                    break
            else:
                self._put(None, StopIteration())
        except BaseException as error:
            self._put(None, error)
        finally:
            if hasattr(source, "close"):
                source.close()

    def _put(self, thing: T | None, error: BaseException | None) -> bool:
        """Whether it was taken in; not once the end was asked for."""
        while not self._stop.is_set():
            try:
                self._made.put((thing, error), timeout=PATIENCE_S)
            except Full:
                continue
            return True
        return False
