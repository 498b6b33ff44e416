"""Lock of a results folder: one run at a time, and a killed run leaves no lock behind."""

from __future__ import annotations

import fcntl
import os
import re
from pathlib import Path
from typing import IO

from ..errors import input_error

TEMPORARY_FILE_NAME_PATTERN = re.compile(r"\..+-[a-z0-9_]{8}(\.\w+)?")
"""Names of the temporary files of `files.atomic_write`."""


def acquire_lock(results: Path) -> IO[str]:
    """Open file whose lock says that a run is at work in `results`; it ends with the process.

    The kernel lets go of it however the process ends, so it is never stale.

    Raises: InputError where another run holds it.
    """
    handle = (results / ".lock").open("a+", encoding="utf-8")
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        handle.seek(0)
        process = handle.read(20).strip() or "unknown"
        handle.close()
        found, expected = "another run at work in this folder", "one run at a time"
        remedy = (
            f"Wait for it to end, or end it (process {process}), or choose another results folder."
        )
        raise input_error(results, "", found, expected, remedy) from error
    except OSError:
        pass  # a file system without locks: Snakemake's own lock still stands
    handle.truncate(0)
    handle.write(f"{os.getpid()}\n")
    handle.flush()
    return handle


def remove_stale_locks(locks: Path, results: Path) -> list[Path]:
    """Snakemake's lock files on `results` taken away; only for whom that folder is held by us.

    A run that was killed leaves them behind and they hold no process id; since nobody else is at
    work in the folder, they are stale. Locks of runs on other folders stay.
    """
    prefix = f"{results}/"
    stale = [
        path
        for path in sorted(locks.glob("*.lock"))
        if any(line.startswith(prefix) for line in path.read_text("utf-8").splitlines())
    ]
    for path in stale:
        path.unlink()
    return stale


def remove_temporary_files(results: Path) -> list[Path]:
    """Half-written temporary files of a killed run taken away; `files.atomic_write` names them."""
    left = [
        path for path in results.rglob(".*-*") if TEMPORARY_FILE_NAME_PATTERN.fullmatch(path.name)
    ]
    for path in left:
        path.unlink(missing_ok=True)
    return left
