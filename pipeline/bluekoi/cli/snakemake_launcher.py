"""Starts Snakemake for `bluekoi run`; Ctrl-C ends it at any time with one line.

By itself it shows tracebacks when it is interrupted while it plans or closes an event loop, from
its log, from its threads and from objects that it deletes. Here all of them are off from the moment
of the interrupt_handler: they only report how Snakemake stops.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import logging
import signal
import sys
import threading
import warnings
from typing import NoReturn

from ..errors import EXIT_INTERRUPTED, EXIT_USAGE, INTERRUPTED_MESSAGE

PR_SET_PDEATHSIG = 1
"""Linux: the signal that a process gets when its parent ends (prctl(2))."""


class InterruptHandler:
    """Handler of Ctrl-C: turns off all that Snakemake says, then raises KeyboardInterrupt.

    taken: whether there was one.
    """

    def __init__(self) -> None:
        self.taken = False
        self._handlers: list[logging.Handler] = []
        self._of_threads, self._of_deletions = threading.excepthook, sys.unraisablehook
        threading.excepthook = lambda fault: None if self.taken else self._of_threads(fault)
        sys.unraisablehook = lambda fault: None if self.taken else self._of_deletions(fault)
        if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:  # as in the background of a shell
            signal.signal(signal.SIGINT, self)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # `bluekoi run` blocked it

    def __call__(self, *_: object) -> None:
        """Take one Ctrl-C.

        Raises KeyboardInterrupt.
        """
        if not self.taken:
            self.taken = True
            self._handlers = list(logging.getLogger("snakemake.logging").handlers)
            logging.disable()
            warnings.simplefilter("ignore")
        raise KeyboardInterrupt

    def print_interrupted_message(self) -> None:
        """Print that the run was interrupted, unless the line of progress has."""
        if not any(getattr(handler, "stopped", False) for handler in self._handlers):
            sys.stderr.write(f"\n{INTERRUPTED_MESSAGE}\n")


def end_with_parent() -> None:
    """Let Snakemake end, after the jobs at work, where the command that started it was killed."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def main() -> None:
    """Run Snakemake on the words of the command line.

    Snakemake imports pandas where it is installed, to see whether a parameter is a table; none is,
    and that import is an eighth of a run in which nothing is due.
    Raises SystemExit as Snakemake does, with 130 where it was interrupted before all was done.
    """
    end_with_parent()
    interrupt_handler = InterruptHandler()
    logging.getLogger("snakemake.logging").addFilter(_is_not_config_file_notice)
    sys.modules.setdefault("pandas", None)  # type: ignore[arg-type]
    try:
        from snakemake.cli import main as snakemake  # noqa: PLC0415

        argparse.ArgumentParser.error = _refuse_option  # type: ignore[assignment]
        try:
            snakemake()
        finally:  # all is done: a late Ctrl-C finds nothing to stop
            signal.signal(signal.SIGINT, signal.SIG_IGN)
    except BaseException as end:
        if not interrupt_handler.taken or (isinstance(end, SystemExit) and end.code in (None, 0)):
            raise
        interrupt_handler.print_interrupted_message()
        raise SystemExit(EXIT_INTERRUPTED) from None


def _refuse_option(_: argparse.ArgumentParser, message: str) -> NoReturn:
    """One line for an option that Snakemake does not have, in place of all that it has."""
    sys.stderr.write(f"Options after --: {message}. `snakemake --help` lists them.\n")
    raise SystemExit(EXIT_USAGE)


def _is_not_config_file_notice(record: logging.LogRecord) -> bool:
    """Whether a record is more than Snakemake's remark on its configuration file."""
    return not record.getMessage().startswith("Config file")


if __name__ == "__main__":
    main()
