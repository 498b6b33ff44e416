"""Zigzags as the engine takes them: place, heading and rudder.

The files name columns 5 and 6 u and v; they are the velocities in the tank's axes (they are the
derivatives of x0 and y0, not of the ship's frame), so neither is used here.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bluekoi.errors import input_error
from bluekoi.fitting import Noise, Series, thinned

from .model import LENGTH_M, SYSTEM

COLUMNS = 12
HEADER_LINES = 4
PLACE_STD_M = 0.003
HEADING_STD_RAD = 0.001
FIRST_NOISE = Noise(
    np.array([1e-3, 1e-3, 1e-3, 3e-3, 3e-3, 1e-3]), np.array([2.0] * 3 + [1.0] * 3), np.ones(3)
)
"""Random forces are forgotten within 5 s at most: a towing tank is still, and forces that last for
a minute would stand for all that the model lacks."""
RATE_HZ = 1.0
START_STD = np.array([0.05, 0.05, 0.02, 0.05, 0.05, 0.01])


def read_folder(folder: Path) -> tuple[Series, ...]:
    """One `Series` a manoeuvre, at about one observation a second.

    Raises: InputError where there is none, or where a file lacks columns.
    """
    paths = sorted(Path(folder).glob("*.dat"))
    if not paths:
        raise input_error(folder, "", "no .dat", "one file a manoeuvre")
    return tuple(thinned(read(path), RATE_HZ) for path in paths)


def read(path: Path) -> Series:
    """One manoeuvre at the recording's rate; angles in degrees in the file, radians here."""
    lines = path.read_text(encoding="cp1252").splitlines()[HEADER_LINES:]
    table = np.array([row for row in map(_numbers, lines) if len(row) == COLUMNS])
    if len(table) < 100:
        raise input_error(path, "", f"{len(table)} rows of {COLUMNS}", "100 or more")
    times, rudder = table[:, 0], np.radians(table[:, 8])
    seen = np.column_stack([table[:, 1], table[:, 2], np.radians(table[:, 3])])
    n, states = len(times), len(SYSTEM.all_states)
    name = path.stem.split("KVLCC2_")[-1]
    return Series(
        name=name, group="all", condition=name.split("_P")[0].split("_S")[0], times=times,
        inputs=rudder.reshape(-1, 1), constants=np.array([LENGTH_M]), seen=seen,
        noise=np.tile(np.diag([PLACE_STD_M, PLACE_STD_M, HEADING_STD_RAD]) ** 2, (n, 1, 1)),
        mean=_start(times, seen, states), cov=_start_cov(states),
    )  # fmt: skip


def _numbers(line: str) -> list[float]:
    try:
        return [float(word) for word in line.split()]
    except ValueError:
        return []


def _start(times: np.ndarray, seen: np.ndarray, states: int) -> np.ndarray:
    """State at the first frame from the first second."""
    first = times < times[0] + 1.0
    (x, y, psi), (vx, vy, r) = np.polynomial.polynomial.polyfit(
        times[first] - times[0], seen[first], 1
    )
    c, s = np.cos(psi), np.sin(psi)
    own = [x, y, psi, vx * c + vy * s, vy * c - vx * s, r]
    return np.concatenate([own, np.zeros(states - len(own))])


def _start_cov(states: int) -> np.ndarray:
    return np.diag(np.concatenate([START_STD, np.full(states - 6, 1e-6)]) ** 2)
