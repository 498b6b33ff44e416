"""Zigzags as the engine takes them: place, heading and rudder.

The files name columns 5 and 6 u and v; they are the velocities in the tank's axes (they are the
derivatives of x0 and y0, not of the ship's frame), so neither is used here.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bluekoi.errors import input_error
from bluekoi.explain import Trial

COLUMNS = 12
HEADER_LINES = 4
MIN_ROWS = 100


def read_folder(folder: Path) -> list[Trial]:
    """One `Trial` a manoeuvre, at the recording's rate.

    Raises: InputError where there is none, or where a file lacks columns.
    """
    paths = sorted(Path(folder).glob("*.dat"))
    if not paths:
        raise input_error(folder, "", "no .dat", "one file a manoeuvre")
    return [read(path) for path in paths]


def read(path: Path) -> Trial:
    """One manoeuvre; angles in degrees in the file, radians here."""
    lines = path.read_text(encoding="cp1252").splitlines()[HEADER_LINES:]
    table = np.array([row for row in map(_numbers, lines) if len(row) == COLUMNS])
    if len(table) < MIN_ROWS:
        raise input_error(path, "", f"{len(table)} rows of {COLUMNS}", f"{MIN_ROWS} or more")
    name = path.stem.split("KVLCC2_")[-1]
    seen = {"x_seen": table[:, 1], "y_seen": table[:, 2], "heading": np.radians(table[:, 3])}
    return Trial(name, table[:, 0], seen, {"rudder": np.radians(table[:, 8])},
                 condition=name.split("_P")[0].split("_S")[0], source=str(path))  # fmt: skip


def _numbers(line: str) -> list[float]:
    try:
        return [float(word) for word in line.split()]
    except ValueError:
        return []
