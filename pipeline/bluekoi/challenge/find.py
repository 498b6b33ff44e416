"""The finder sent over the folders of a challenge, in processes shut out from the seals."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from queue import SimpleQueue
from threading import Thread

from ..errors import input_error
from ..files import read_json
from .make import sealed_folder

Progress = Callable[[str, int, int], None]


def studies_of(folder: Path) -> list[str]:
    """Names of the studies that a challenge publishes.

    Raises: InputError where there is no challenge.
    """
    if not (folder / "challenge.json").is_file():
        raise input_error(
            folder, "", "no challenge.json", "a folder that `challenge make` has written"
        )
    return sorted(read_json(folder / "challenge.json")["studies"])


def results_of(folder: Path, name: str) -> Path:
    """Where the results of a study stand."""
    return folder / "results" / name


def find(folder: Path, *, workers: int, again: bool, progress: Progress) -> int:
    """How many studies ended without a verdict; the others have results in `results/NAME`."""
    names = studies_of(folder)
    todo = [n for n in names if again or not (results_of(folder, n) / "times.json").is_file()]
    parts = [todo[i::workers] for i in range(workers)]
    running = [_start(folder, part, workers) for part in parts if part]
    for done, line in enumerate(_lines(running), start=1):
        progress(line.strip(), done, len(todo))
    for process in running:
        process.wait()
    return sum(not (results_of(folder, n) / "mismatch.json").is_file() for n in names)


def _lines(running: Sequence[subprocess.Popen[str]]) -> Iterator[str]:
    """Lines of all processes as they come."""
    told: SimpleQueue[str | None] = SimpleQueue()

    def follow(process: subprocess.Popen[str]) -> None:
        for line in process.stdout or ():
            told.put(line)
        told.put(None)

    for process in running:
        Thread(target=follow, args=(process,), daemon=True).start()
    open_yet = len(running)
    while open_yet:
        line = told.get()
        if line is None:
            open_yet -= 1
        else:
            yield line


def _start(folder: Path, names: Sequence[str], workers: int) -> subprocess.Popen[str]:
    """A process that gives up the right to read the seals, then analyses the named studies.

    The cores are shared out among the workers.
    """
    sealed = sealed_folder(folder.resolve())
    command = [sys.executable, "-P", "-m", "bluekoi"]
    command += ["challenge", "find-alone", str(folder.resolve())]
    command += [str(sealed), *names]
    own = {"BLUEKOI_THREADS": str(max(1, (os.cpu_count() or 1) // workers))}
    return subprocess.Popen(  # noqa: S603
        command, stdout=subprocess.PIPE, text=True, env={**os.environ, **own}
    )
