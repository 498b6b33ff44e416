"""Drops as the engine takes them: a sheet a ball, columns drop, time s, height m."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from bluekoi.errors import input_error
from bluekoi.explain import Trial

from ..spreadsheet import columns, sheets

GRAVITY = 9.81
LEFT_M = 0.5
"""Fall after which the ball has surely left the hand; before, the release shows, not the air."""
OUNCE_KG = 0.028349523
BALLS = {
    "Baseball": "baseball",
    "Blue Basketball": "bluebasketball",
    "Green Basketball": "greenbasketball",
    "Volleyball": "volleyball",
    "Bowling Ball": "bowlingball",
    "Golf Ball": "golfball",
    "Tennis Ball": "tennisball",
    "Whiffle Ball 1": "wiffleball1",
    "Whiffle Ball 2": "wiffleball2",
    "Yellow Whiffle Ball": "yellowWiffle",
    "Orange Whiffle Ball": "orangeWiffle",
}
"""Sheet of the workbook -> row of balls.txt."""
VOLLEYBALL = (9.5, 66.0)
"""ASSUME ounces and cm of a volleyball by the rules of the game (260 to 280 g, 65 to 67 cm):
balls.txt has question marks there."""


def read_folder(folder: Path) -> list[Trial]:
    """Two drops of each ball.

    Raises: InputError where the workbook or the table of balls is missing or lacks a ball.
    """
    book, table = folder / "Ball_drops_data.xls", folder / "balls.txt"
    for path in (book, table):
        if not path.is_file():
            raise input_error(path, "", "no such file", "the workbook and balls.txt in one folder")
    sizes, found = read_balls(table), sheets(book)
    missing = [name for name in BALLS if name not in found]
    if missing:
        raise input_error(book, "sheets", ", ".join(found), f"sheets {', '.join(missing)}")
    return [drop for ball, row in BALLS.items()
            for drop in _drops(ball, columns(found[ball], "ABC"), sizes[row])]  # fmt: skip


def read_balls(path: Path) -> dict[str, tuple[float, float]]:
    """Row -> mass (kg) and area (m2) of each ball."""
    out = {}
    for line in path.read_text(encoding="utf-8").splitlines()[1:]:
        parts = line.split()
        if len(parts) == 3:
            ounces, cm = VOLLEYBALL if "??" in parts else (float(parts[1]), float(parts[2]))
            out[parts[0]] = (ounces * OUNCE_KG, (cm / 100.0) ** 2 / (4.0 * math.pi))
    return out


def _drops(ball: str, table: np.ndarray, size: tuple[float, float]) -> list[Trial]:
    numbers = sorted({int(n) for n in table[:, 0]})
    return [_drop(ball, n, table[table[:, 0] == n], size) for n in numbers]


def _drop(ball: str, number: int, rows: np.ndarray, size: tuple[float, float]) -> Trial:
    """A drop from the frame where the ball has clearly left the hand; times stay those given."""
    times, height = rows[:, 1] - rows[0, 1], rows[:, 2]
    left = int(np.argmax(height < height[0] - LEFT_M))
    return Trial(
        f"{ball} {number}", times[left:], {"height": height[left:]}, condition=ball,
        constants={"m": size[0], "A": size[1], "h0": float(rows[0, 2])},
        start={"w": -fallen_speed(float(rows[0, 2] - height[left]))},
    )  # fmt: skip


def fallen_speed(fall_m: float) -> float:
    """Speed (m/s) of what has fallen from rest by `fall_m` with hardly any drag.

    The moment of release is not known: the first frame is not the release.
    """
    return math.sqrt(2.0 * GRAVITY * max(fall_m, 0.0))
