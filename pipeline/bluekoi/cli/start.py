"""Snakemake as `bluekoi run` starts it: Ctrl-C ends it in one line, whatever it is at.

By itself it shows a traceback when it is interrupted while it plans, or when a thread of its own
is still at work as it tears down.
"""

from __future__ import annotations

import logging
import signal
import sys
import threading

from ..errors import INTERRUPTED, STOPPED


def main() -> None:
    """Run Snakemake on the words of the command line.

    Raises SystemExit as Snakemake does, with 130 where it was interrupted.
    """
    of_threads = threading.excepthook
    threading.excepthook = lambda fault: None if _already_reported() else of_threads(fault)
    logging.getLogger("snakemake.logging").addFilter(_is_no_announcement)
    try:
        from snakemake.cli import main as snakemake  # noqa: PLC0415

        try:
            snakemake()
        finally:  # all is done: a late Ctrl-C finds nothing to stop
            signal.signal(signal.SIGINT, signal.SIG_IGN)
    except (KeyboardInterrupt, RuntimeError) as error:
        # asyncio raises the latter where an interrupted event loop is closed while it runs
        if isinstance(error, RuntimeError) and not _already_reported():
            raise
        if not _already_reported():
            sys.stderr.write(f"\n{STOPPED}\n")
        raise SystemExit(INTERRUPTED) from None


def _is_no_announcement(record: logging.LogRecord) -> bool:
    """Whether a record is more than Snakemake's remark on its configuration file."""
    return not record.getMessage().startswith("Config file")


def _already_reported() -> bool:
    """Whether the line of progress has reported that the run was interrupted."""
    return any(getattr(handler, "stopped", False) for handler in _snakemakes_handlers())


def _snakemakes_handlers() -> list[logging.Handler]:
    return logging.getLogger("snakemake.logging").handlers


if __name__ == "__main__":
    main()
