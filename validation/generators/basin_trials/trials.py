"""The trials of a study: powers, head angles, heads, durations, and where they start."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .catalogue import WATER
from .form import POOL_LENGTH, POOL_WIDTH, Array, HiddenLaw, Runs
from .motion import STATE_SIZE, integrate
from .robots import Robot

SMALL_SHARE = 0.2
"""Share of studies with three trials at each power."""
MAX_TRIALS = 24
PATH_RATE = 10
"""Samples of a path per second."""
START_CANDIDATES = 300
MARGIN = 0.22
"""Distance (m) from the walls that paths keep, and the one near which a wall acts."""
WALL_MARGIN = 0.14

Row = tuple[float, float, float, float]
"""Power (%), flapping frequency (Hz), head angle (degrees), head length (m)."""


def _rows(
    powers: Sequence[tuple[float, float]], mild: int, sharp: int,
    *, heads: tuple[float, float], small: bool, vary_heads: bool,
) -> list[Row]:  # fmt: skip
    """Every power with straight runs and turns to both sides, with head and cap."""
    h, cap = heads
    cells: list[tuple[float, float]] = [(0, h), (sharp, h), (-mild, cap)]
    if small:
        return [(*power, *cell) for power in powers for cell in cells]
    cells = [(0, h), (0, cap), (mild, h), (-mild, h), (sharp, h), (-sharp, h), (sharp, cap),
             (-mild, cap)]  # fmt: skip
    if MAX_TRIALS // len(powers) == len(cells):
        return [(*power, *cell) for power in powers for cell in cells]
    rows = [(*power, *cells[k]) for power in powers for k in (0, 2, 3, 4, 5, 6)]
    if vary_heads:
        rows = [(p, f, a, heads[(j + j // 6) % 2]) for j, (p, f, a, _) in enumerate(rows)]
    return rows


def draw_trials(
    rng: np.random.Generator, robot: Robot, names: Sequence[str]
) -> tuple[Runs, Array, Array]:
    """Runs without errors, durations (s) and powers (%), at three or four powers, shuffled."""
    small = rng.random() < SMALL_SHARE and "thrust_area" not in names
    levels = 3 if small or rng.random() < 0.7 else 4
    powers = np.round(np.linspace(rng.uniform(40, 55), rng.uniform(92, 100), levels))
    flaps = np.round(rng.uniform(5.2, 6.2) * (powers / 100) ** rng.uniform(1.1, 1.3), 3)
    mild, sharp = int(rng.integers(15, 29)), int(rng.integers(32, 46))
    cap = round(robot.head_length * rng.uniform(1.35, 1.5), 4)
    rows = _rows(
        list(zip(powers, flaps, strict=True)), mild, sharp,
        heads=(robot.head_length, cap), small=small, vary_heads="thrust_area" in names,
    )  # fmt: skip
    rows = [rows[k] for k in rng.permutation(len(rows))]
    power, flap, angle, head = (np.array(v, float) for v in zip(*rows, strict=True))
    count = len(rows)
    low, high = (9, 13) if "wake_reentry" in names else (4.5, 8.5)
    duration = np.round(rng.uniform(low, high, count), 2)
    values = dict(robot.coefficients)
    if robot.fin:
        values |= {"fin_area": robot.fin.area, "fin_arm": robot.fin.arm}
    runs = Runs(
        np.radians(angle), head, flap, np.arange(count), np.zeros(count),
        {name: np.full(count, v) for name, v in values.items()},
    )  # fmt: skip
    return runs, duration, power


def draw_starts(
    rng: np.random.Generator, robot: Robot, runs: Runs, duration: Array,
    *, laws: Sequence[HiddenLaw] = (), margin: float = MARGIN,
) -> Array:  # fmt: skip
    """First states (8, runs) at rest.

    Of 300 places and headings, one of the six whose path in still water stays longest in the pool.
    """
    n = len(duration)
    steps = int(np.ceil(duration.max() * PATH_RATE))
    start = np.zeros((STATE_SIZE, n))
    dry = [law for law in laws if law.family.stage != WATER]
    path = integrate(start, runs, robot, laws=dry, step=1 / 30, count=steps, every=3)
    z, t = path[:, 0] + 1j * path[:, 1], np.arange(steps + 1) / PATH_RATE
    size = START_CANDIDATES
    for k in range(n):
        turn = rng.uniform(-np.pi, np.pi, size)
        x = rng.uniform(margin, POOL_LENGTH - margin, size)
        origin = x + 1j * rng.uniform(margin, POOL_WIDTH - margin, size)
        w = origin[:, None] + np.exp(1j * turn)[:, None] * z[None, t <= duration[k], k]
        stay = np.cumprod(inside_pool(w.real, w.imag, margin), 1).sum(1)
        best = rng.choice(np.argsort(stay)[-6:])
        start[0, k], start[1, k], start[2, k] = origin[best].real, origin[best].imag, turn[best]
    return start


def inside_pool(x: Array, y: Array, margin: float) -> Array:
    """Whether places are farther than `margin` (m) from every wall."""
    along = (x > margin) & (x < POOL_LENGTH - margin)
    return along & (y > margin) & (y < POOL_WIDTH - margin)
