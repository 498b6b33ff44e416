"""After two seconds of waiting a message states what for and how long."""

from __future__ import annotations

import io
import time

import pytest

from bluekoi.cli import progress_notice
from bluekoi.cli.progress_notice import ProgressNotice


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_time_left_is_by_the_share_done_else_as_usual():
    wait = ProgressNotice("writing", usual_s=30.0, since_s=0.0)
    assert wait.line(10.0) == "writing: about 20 s left"
    assert wait.line(40.0) == "writing: 40 s so far, longer than usual"
    wait.share = 0.25
    assert wait.line(40.0) == "writing: about 2 min left"


def test_nothing_is_said_of_what_is_done_at_once():
    with progress_notice.progress_notice("reading", stream=(stream := Terminal())):
        pass
    assert "reading" not in stream.getvalue()


@pytest.mark.parametrize("kind", [Terminal, io.StringIO])
def test_a_long_wait_is_reported_and_the_line_taken_away(kind, monkeypatch):
    monkeypatch.setattr(progress_notice, "FIRST_NOTICE_S", 0.05)
    with progress_notice.progress_notice("writing 3 trials", stream=(stream := kind())) as wait:
        wait.share = 0.5
        deadline = time.monotonic() + 10
        while "writing" not in stream.getvalue() and time.monotonic() < deadline:
            time.sleep(0.01)
    assert "writing 3 trials: about 5 s left" in stream.getvalue()
    assert stream.getvalue().endswith("\r\x1b[K" if kind is Terminal else "left\n")
