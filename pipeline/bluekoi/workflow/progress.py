"""Progress of a run in one line: stage, trial, finished and total jobs, remaining time."""

from __future__ import annotations

import contextlib
import logging
import re
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any, TextIO

from snakemake_interface_logger_plugins.common import LogEvent

from ..errors import INTERRUPTED_MESSAGE, escape_control_characters
from ..files import read_json
from ..stages.result_paths import ResultPaths
from .preload import ForkServerProcess
from .remaining_time import RemainingTimeEstimator, duration_text, durations_of_last_run_s

HIDDEN_LOG_EVENTS = {
    LogEvent.WORKFLOW_STARTED,
    LogEvent.RESOURCES_INFO,
    LogEvent.RUN_INFO,
    LogEvent.JOB_INFO,
    LogEvent.JOB_STARTED,
    LogEvent.JOB_FINISHED,
    LogEvent.SHELLCMD,
    LogEvent.PROGRESS,
    LogEvent.JOB_ERROR,
    LogEvent.GROUP_INFO,
    LogEvent.GROUP_ERROR,
}
HIDDEN_MESSAGES = (
    "CalledProcessError",
    "At least one job did not complete",
    "Exiting because a job",
)
LOCKED_MESSAGE = (
    "Another run is at work in this folder. Wait for it to end. If none is running, the last one "
    "was killed: `snakemake --unlock`, then start again; finished trials are kept."
)
KILLED_MESSAGE = (
    "A stage was killed from outside ({}), by a person or for want of memory. Start again; what is "
    "done is kept. With `--cores 1` less memory is needed at once."
)
TRACEBACK_HEADER = "Traceback (most recent call last)"
INTERRUPT_EXCEPTION_NAMES = ("KeyboardInterrupt", "CancelledError")
PROGRESS_LINE_INTERVAL_S = 2.0
"""Time between lines of progress."""
TERMINAL_UPDATE_INTERVAL_S = 1.0
"""Time between updates of the line on a terminal."""
RUNNING_JOB_NOTE_AFTER_S = 30.0
"""On a file, so long without a job that ends brings a line on the one that runs."""
FILE_CLOCK_TOLERANCE_S = 2.0  # by so much a file system's clock may lag behind ours
MAX_LOG_LINE_CHARACTERS = 60
"""Characters of a stage's own last word."""


class SnakemakeMessageFilter(logging.Filter):
    """Leaves out what `SnakemakeProgressHandler` prints, from the start of the run on."""

    begun = False

    def __init__(self, progress: SnakemakeProgressHandler) -> None:
        super().__init__()
        self.progress = progress

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether Snakemake's own text of this record is shown."""
        event = getattr(record, "event", None)
        first = event == LogEvent.WORKFLOW_STARTED or "shared filesystem" in record.getMessage()
        self.begun = self.begun or first
        quiet = (
            event in HIDDEN_LOG_EVENTS
            or record.levelno < logging.WARNING
            or _is_reported_by_progress(record)
        )
        return not (self.begun and (quiet or self._is_caused_by_interruption(record)))

    def _is_caused_by_interruption(self, record: logging.LogRecord) -> bool:
        """Whether a reported fault is only Snakemake's way of being interrupted."""
        text = record.getMessage()
        return TRACEBACK_HEADER in text and (self.progress.stopped or _is_user_interrupt(text))


def _is_reported_by_progress(record: logging.LogRecord) -> bool:
    text = record.getMessage()
    return any(words in text for words in HIDDEN_MESSAGES) or "cannot be locked" in text


def _is_user_interrupt(text: str) -> bool:
    return any(name in text for name in INTERRUPT_EXCEPTION_NAMES)


def killing_signal_name(text: str) -> str:
    """Name of the signal that ended a command, by Snakemake's words on it; else nothing.

    A stage that is killed leaves its shell, which returns 128 and the signal's number.
    """
    if found := re.search(r"died with <Signals\.(\w+)", text):
        return found[1]
    status = re.search(r"returned non-zero exit status (\d+)", text)
    number = int(status[1]) - 128 if status else 0
    return signal.Signals(number).name if number in set(signal.Signals) else ""


class SnakemakeProgressHandler(logging.Handler):
    """Log handler that turns Snakemake's events into short lines on `stream`.

    On a terminal the line is rewritten in place each second; in a file a line comes every two
    seconds while jobs end, else every half minute. A stage that runs long is shown with the last
    line of its log.
    """

    def __init__(self, report: Path, stream: TextIO = sys.stderr) -> None:
        super().__init__(logging.INFO)
        self.report, self.stream = report, stream
        self.live = stream.isatty()
        self.timing = RemainingTimeEstimator(durations_of_last_run_s(report.parent))
        self.logs: dict[int, tuple[Path, float]] = {}
        self.last_s = 0.0
        self.stopped = False
        self.preloaded: ForkServerProcess | None = None
        self.over = threading.Event()
        self.ticker = threading.Thread(target=self._update_periodically, daemon=True)

    def emit(self, record: logging.LogRecord) -> None:
        """Show one event."""
        event, found = getattr(record, "event", None), record.__dict__
        if event == LogEvent.RUN_INFO and "stats" in found:
            self.timing.set_expected_jobs(found["stats"])
        elif event == LogEvent.JOB_INFO:
            self._on_job_started(found)
        elif event == LogEvent.JOB_FINISHED:
            self._on_job_finished(found["job_id"])
        elif event == LogEvent.JOB_ERROR:
            self._report_failed_job(found)
        elif name := killing_signal_name(record.getMessage()):
            self._report_killed_stage(name)
        elif "cannot be locked" in record.getMessage():
            self._print(LOCKED_MESSAGE)
        elif TRACEBACK_HEADER in record.getMessage() and _is_user_interrupt(record.getMessage()):
            self._report_interruption()
        elif record.getMessage().startswith("Nothing to be done"):
            self._print("Everything is up to date.")
            self.print_final_summary()

    def _report_killed_stage(self, name: str) -> None:
        if name != "SIGINT":
            self._print(KILLED_MESSAGE.format(name))
        else:
            self._report_interruption()

    def _report_interruption(self) -> None:
        if not self.stopped:
            self.stopped = True
            self._print(INTERRUPTED_MESSAGE)

    def _on_job_started(self, found: dict[str, Any]) -> None:
        self.timing.job_started(found["jobid"], found["rule_name"], time.monotonic())
        if logs := found.get("log"):
            self.logs[found["jobid"]] = (Path(logs[0]), time.time())
        self._print_progress_line(_job_name(found), now=not self.live and self.last_s == 0.0)
        if not self.ticker.ident:
            self.ticker.start()

    def _on_job_finished(self, job: int) -> None:
        self.logs.pop(job, None)
        if done := self.timing.job_finished(job, time.monotonic()):
            ended = self.timing.finished_job_count == self.timing.total_job_count
            self._print_progress_line(self.timing.running_rule_names() or done, now=ended)

    def _update_periodically(self) -> None:
        """Show jobs that run long, until the run is over."""
        while not self.over.wait(TERMINAL_UPDATE_INTERVAL_S):
            with self.lock or threading.RLock():
                self.print_if_silent()

    def print_if_silent(self) -> None:
        """Print what runs if nothing was printed for a while."""
        silent = time.monotonic() - self.last_s > (
            TERMINAL_UPDATE_INTERVAL_S if self.live else RUNNING_JOB_NOTE_AFTER_S
        )
        if silent and self.timing.started and not self.stopped:
            self._print_progress_line(self.timing.running_rule_names(), now=True)

    def _print_progress_line(self, name: str, *, now: bool) -> None:
        moment = time.monotonic()
        if not (self.live or now or moment - self.last_s > PROGRESS_LINE_INTERVAL_S):
            return
        self.last_s = moment
        left = self.timing.remaining_s(moment)
        ends = f"  about {duration_text(left)} left" if left is not None else ""
        head = f"[{self.timing.finished_job_count}/{self.timing.total_job_count}]"
        text = f"{head} {name}{self._last_log_line()}{ends}".rstrip()
        self.stream.write(f"\r\x1b[K{text}" if self.live else text + "\n")
        self.stream.flush()

    def _last_log_line(self) -> str:
        """Last line that a job that runs has written to its log, after a colon; or nothing."""
        for path, since in reversed(self.logs.values()):
            with contextlib.suppress(OSError):
                if path.stat().st_mtime < since - FILE_CLOCK_TOLERANCE_S:
                    continue  # of an earlier run
                words = [line for line in path.read_text("utf-8", "replace").split("\n") if line]
                if words:
                    return f": {escape_control_characters(words[-1])[:MAX_LOG_LINE_CHARACTERS]}"
        return ""

    def _report_failed_job(self, found: dict[str, Any]) -> None:
        if self.stopped:
            return  # a person stopped it: no stage is at fault
        paths = [Path(name) for name in found.get("log") or []]
        text = "\n".join(p.read_text("utf-8", "replace") for p in paths if p.is_file()).strip()
        lines = [line for line in text.splitlines() if line.strip()]
        if _is_user_interrupt("\n".join(lines[-12:])):
            # caught by a library on the way, so that the stage ended with a status of its own
            self._report_interruption()
            return
        shown = lines if found["rule_name"] == "outcome" else lines[-12:]
        if shown:
            self._print("\n".join(shown))
        if found["rule_name"] != "outcome":
            self._print(
                f"The stage {found['rule_name']} ended there; more in {', '.join(map(str, paths))}"
            )

    def _print(self, text: str) -> None:
        self.stream.write(("\r\x1b[K" if self.live else "") + text + "\n")
        self.stream.flush()

    def print_final_summary(self) -> None:
        """Warnings, the verdict and the report, where there are any; nothing more is shown, and
        nothing of this after an interruption.
        """
        self.over.set()
        if self.preloaded:
            self.preloaded.close()
        if self.stopped:
            return  # what stands in the results is of an earlier run
        for name in ("outcome.json", "mismatch.json"):
            for text in _warnings_in_result_file(self.report.with_name(name)):
                self._print(f"Warning: {text}")
        if text := _verdict_sentence(self.report.with_name("mismatch.json")):
            self._print(f"Verdict: {text}")
        if ResultPaths(self.report.parent).report_is_current():
            self._print(f"Report: {self.report}")


def _warnings_in_result_file(result: Path) -> list[str]:
    """Warnings in a result, of the trials or of the search; none where there is no such file."""
    return list(read_json(result).get("warnings", [])) if result.is_file() else []


def _verdict_sentence(mismatch: Path) -> str:
    """The verdict in one sentence; empty before the search."""
    return str(read_json(mismatch).get("sentence", "")) if mismatch.is_file() else ""


def _job_name(found: dict[str, Any]) -> str:
    of = " ".join(str(value) for value in (found.get("wildcards") or {}).values())
    return f"{found['rule_name']} {of}".strip()


def attach_progress(workflow: Any, report: Path) -> SnakemakeProgressHandler:
    """Progress attached to a Snakemake workflow that is about to run.

    A dry run, `--verbose` and the jobs of a cluster keep Snakemake's own words.
    """
    progress, settings = SnakemakeProgressHandler(report), workflow.output_settings
    if workflow.is_main_process and not (settings.dryrun or settings.verbose):
        logger = logging.getLogger("snakemake.logging")
        for handler in logger.handlers:
            if handler.name == "DefaultStreamHandler":
                handler.addFilter(SnakemakeMessageFilter(progress))
        logger.addHandler(progress)
    return progress
