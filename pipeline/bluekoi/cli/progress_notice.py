"""What a command that takes longer than two seconds says while a person waits for it."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TextIO

FIRST_NOTICE_S = 2.0
"""Time after which the first notice of a long job is printed."""
NOTICE_EVERY_S = 30.0
"""Time between later notices where the output is a file."""


@dataclass
class ProgressNotice:
    """Work under way. usual_s: how long it takes where nothing better is known; share: done."""

    what: str
    usual_s: float
    since_s: float = field(default_factory=time.monotonic)
    share: float = 0.0

    def line(self, now_s: float) -> str:
        """What is being done and how long it still takes, by the share done, else as usual."""
        from ..workflow.remaining_time import duration_text  # noqa: PLC0415

        spent = now_s - self.since_s
        left = spent * (1 / self.share - 1) if self.share > 0 else self.usual_s - spent
        late = left <= 0 and self.share <= 0
        return f"{self.what}: " + (
            f"{duration_text(spent)} so far, longer than usual"
            if late
            else f"about {duration_text(left)} left"
        )


@contextmanager
def progress_notice(
    what: str, usual_s: float = 10.0, stream: TextIO | None = None
) -> Iterator[ProgressNotice]:
    """`ProgressNotice` to note progress on; shown on standard error from the third second on.

    On a terminal one line, rewritten each second and taken away at the end; in a file a line
    every half minute.
    """
    wait, over, out = ProgressNotice(what, usual_s), threading.Event(), stream or sys.stderr
    teller = threading.Thread(target=_print_progress, args=(wait, over, out), daemon=True)
    teller.start()
    try:
        yield wait
    finally:
        over.set()
        teller.join()


def _print_progress(wait: ProgressNotice, over: threading.Event, out: TextIO) -> None:
    live = out.isatty()
    pause = FIRST_NOTICE_S
    while not over.wait(pause):
        text = wait.line(time.monotonic())
        out.write(f"\r\x1b[K{text}" if live else text + "\n")
        out.flush()
        pause = 1.0 if live else NOTICE_EVERY_S
    if live:
        out.write("\r\x1b[K")
        out.flush()
