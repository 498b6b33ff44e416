"""Drops as the engine takes them: a sheet a ball, columns drop, time s, height m."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from pipeline.faults import fault
from pipeline.fitting import Noise, Series

from ..spreadsheet import columns, sheets
from .model import AIR_KG_M3, GRAVITY

HEIGHT_STD_M = 0.03
FIRST_NOISE = Noise(np.array([0.3, 0.02]), np.array([1.0, 0.2]), np.ones(1))
LEFT_M = 0.5
"""Fall after which the ball has surely left the hand; before, the release shows, not the air."""
START_STD_M_S = 3.0
"""The moment of release is not the first frame's: what the speed is when the ball has left."""
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


def read_folder(folder: Path) -> dict[str, tuple[Series, ...]]:
    """Ball -> its drops.

    Raises: Fault where the workbook or the table of balls is missing or lacks a ball.
    """
    book, table = folder / "Ball_drops_data.xls", folder / "balls.txt"
    for path in (book, table):
        if not path.is_file():
            raise fault(path, "", "no such file", "the workbook and balls.txt in one folder")
    sizes, found = read_balls(table), sheets(book)
    missing = [name for name in BALLS if name not in found]
    if missing:
        raise fault(book, "sheets", ", ".join(found), f"sheets {', '.join(missing)}")
    return {ball: _drops(ball, columns(found[ball], "ABC"), *sizes[row])
            for ball, row in BALLS.items()}  # fmt: skip


def read_balls(path: Path) -> dict[str, tuple[float, float]]:
    """Row -> mass (kg) and area (m2) of each ball."""
    out = {}
    for line in path.read_text(encoding="utf-8").splitlines()[1:]:
        parts = line.split()
        if len(parts) == 3:
            ounces, cm = VOLLEYBALL if "??" in parts else (float(parts[1]), float(parts[2]))
            out[parts[0]] = (ounces * OUNCE_KG, (cm / 100.0) ** 2 / (4.0 * math.pi))
    return out


def _drops(ball: str, table: np.ndarray, mass_kg: float, area_m2: float) -> tuple[Series, ...]:
    numbers = sorted({int(n) for n in table[:, 0]})
    return tuple(_drop(ball, n, table[table[:, 0] == n], (mass_kg, area_m2)) for n in numbers)


def _drop(ball: str, number: int, rows: np.ndarray, size: tuple[float, float]) -> Series:
    """A drop from the frame where the ball has clearly left the hand; times stay those given."""
    times, height = rows[:, 1] - rows[0, 1], rows[:, 2]
    left = int(np.argmax(height < height[0] - LEFT_M))
    times, height = np.ascontiguousarray(times[left:]), np.ascontiguousarray(height[left:])
    return Series(
        name=f"{ball} {number}", group=ball, condition=f"{ball} {number}", times=times,
        inputs=np.zeros((len(times), 0)),
        constants=np.array([*size, AIR_KG_M3, rows[0, 2], float(number != 1)]),
        seen=height.reshape(-1, 1), noise=np.full((len(times), 1, 1), HEIGHT_STD_M**2),
        mean=np.array([height[0], -GRAVITY * times[0], 0.0, 0.0]),
        cov=np.diag([0.3, START_STD_M_S, 1e-6, 1e-6]) ** 2,
    )  # fmt: skip
