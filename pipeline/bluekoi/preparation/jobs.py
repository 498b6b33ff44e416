"""Background jobs of the set-up page: previews, a calibration, the run."""

from __future__ import annotations

import multiprocessing
import subprocess
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

from ..errors import InputError

MAX_LOG_LINES = 400
INTERNAL_ERROR_TEXT = "a defect of this program ended the work; the terminal has more"


class BackgroundJobs:
    """Calls made one after the other in a process of their own, so that the page stays quick."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        self._made: dict[str, Future[Any]] = {}

    def start(self, name: str, work: Callable[..., Any], *arguments: Any) -> None:
        """Begin a job, in the place of an earlier one of that name that is still waiting."""
        if earlier := self._made.get(name):
            earlier.cancel()
        self._made[name] = self._executor().submit(work, *arguments)

    def state(self, name: str) -> dict[str, Any]:
        """`state`: absent, waiting, running, done (with `result`) or failed (with `error`)."""
        job = self._made.get(name)
        if job is None:
            return {"state": "absent"}
        if not job.done():
            return {"state": "running" if job.running() else "waiting"}
        if job.cancelled():
            return {"state": "absent"}
        if (error := job.exception()) is not None:
            text = (
                str(error)
                if isinstance(error, InputError)
                else f"{INTERNAL_ERROR_TEXT} ({error!r})"
            )
            if not isinstance(error, InputError):
                self._pool = None
            return {"state": "failed", "error": text}
        return {"state": "done", "result": job.result()}

    def close(self) -> None:
        """End the process; jobs that wait are dropped."""
        if self._pool is None:
            return
        # shutdown would wait for the job at work, and a calibration may take minutes
        processes = list((getattr(self._pool, "_processes", None) or {}).values())
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()

    def _executor(self) -> ProcessPoolExecutor:
        if self._pool is None:
            spawn = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(1, mp_context=spawn)
        return self._pool


class AnalysisProcess:
    """The run of the study, begun from the page and followed there line by line."""

    def __init__(self, words: Sequence[str], report: Path) -> None:
        self.words, self.report = list(words), report
        self._lines: deque[str] = deque(maxlen=MAX_LOG_LINES)
        self._process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        """Begin, unless a run is at work."""
        if self.running:
            return
        self._lines.clear()
        # A session of its own: Ctrl-C in the terminal comes to the page, which ends it in order.
        self._process = subprocess.Popen(  # noqa: S603
            self.words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            text=True, errors="replace", start_new_session=True,
        )  # fmt: skip
        threading.Thread(
            target=self._collect_output_lines, args=(self._process,), daemon=True
        ).start()

    def stop(self) -> None:
        """Ask the run to end after the jobs at work; what is done is kept."""
        if self._process is not None and self.running:
            self._process.terminate()

    @property
    def running(self) -> bool:
        """Whether a run is at work."""
        return self._process is not None and self._process.poll() is None

    def state(self) -> dict[str, Any]:
        """Lines of the run so far, whether it runs, its exit code, whether there is a report."""
        code = self._process.poll() if self._process else None
        begun = self._process is not None
        return {
            "begun": begun, "running": self.running, "exit_code": code, "lines": list(self._lines),
            "report": self.report.is_file(),
        }  # fmt: skip

    def _collect_output_lines(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            self._lines.append(line.rstrip())
