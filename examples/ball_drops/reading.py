"""Drops as the engine takes them: a sheet a ball, columns drop, time s, height m."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from bluekoi.errors import input_error
from bluekoi.fitting import Noise, Series

from ..spreadsheet import columns, sheets
from .model import AIR_KG_M3, DRAG_SPREAD, GRAVITY, SYSTEM

HEIGHT_STD_M = 0.02
FIRST_NOISE = Noise(np.array([0.0, 0.05]), np.array([1.0, 0.3]), np.ones(1))
"""No random forces: what air does to a ball is asked here; errors of the height last, as those of
a camera held by hand do."""
SCALE_STD = 0.05
"""Share by which a drop's lengths may be wrong. All balls fell from one bridge to one ground, and
are seen to fall by 34 to 37 m."""
LEFT_M = 0.5
"""Fall after which the ball has surely left the hand; before, the release shows, not the air."""
START_STD_M_S = 0.4
"""The hand lets go of a ball at rest, so that the speed it has gained tells how far it has fallen,
w^2 = 2 g (h0 - h); within what errors of 0.1 m in the fall make of that. When it was let go is not
needed, nor known: the first frame is not the release."""
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
    mean, std = _start(height[0], rows[0, 2] - height[0])
    return Series(
        name=f"{ball} {number}", group=ball, condition=f"{ball} {number}", times=times,
        inputs=np.zeros((len(times), 0)),
        constants=np.array([*size, AIR_KG_M3, rows[0, 2]]), seen=height.reshape(-1, 1),
        noise=np.full((len(times), 1, 1), HEIGHT_STD_M**2), mean=mean, cov=np.diag(std) ** 2,
    )  # fmt: skip


def _start(height_m: float, fallen_m: float) -> tuple[np.ndarray, np.ndarray]:
    """What is known of all states, and their deviations, where a drop begins."""
    known = {
        "h": (height_m, 0.3), "w": (-fallen_speed(fallen_m), START_STD_M_S),
        "s": (0.0, SCALE_STD), "z": (0.0, DRAG_SPREAD), "z_l": (0.0, DRAG_SPREAD),
    }  # fmt: skip
    both = np.array([known.get(name, (0.0, 1e-6)) for name in SYSTEM.all_states])
    return both[:, 0].copy(), both[:, 1].copy()


def fallen_speed(fall_m: float) -> float:
    """Speed (m/s) of what has fallen from rest by `fall_m` with hardly any drag."""
    return math.sqrt(2.0 * GRAVITY * max(fall_m, 0.0))
