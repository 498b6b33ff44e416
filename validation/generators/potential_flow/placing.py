"""Where each trial begins and how long it lasts, so that it stays in the pool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .impulse import STEP, Motion, World, swim
from .lanes import Lanes, tiled

MARGIN = 0.26
"""Least distance of the centre of mass from a wall, m: the head stays inside."""
SHORTEST = 4.0
LONGEST = 9.0
TRIES = 5


def fitted(rng: np.random.Generator, path: np.ndarray, wanted: int, pool) -> tuple[complex, float]:
    """Start and turn of a path (times,) from 0 that keep most of `wanted` steps inside.

    Of 60 random turns, those that fit for longest; then a random place within the room.
    """
    turns = rng.uniform(-np.pi, np.pi, 60)
    best, chosen = 0, (pool[0] / 2 + 0.5j * pool[1], 0.0)
    room = np.array(pool[:2]) - 2 * MARGIN
    for turn in turns:
        at = path[:wanted] * np.exp(1j * turn)
        low = np.minimum.accumulate([at.real, at.imag], axis=1)
        high = np.maximum.accumulate([at.real, at.imag], axis=1)
        length = int(np.count_nonzero(np.all(room > (high - low).T, axis=1)))
        if length > best:
            best = length
            slack = room - (high - low)[:, length - 1]
            x, y = MARGIN - low[:, length - 1] + slack * rng.random(2)
            chosen = (complex(x, y), turn)
        if best == wanted:
            break
    return chosen


def inside(motion: Motion, pool) -> np.ndarray:
    """(n,) time until the centre of mass is too near to a wall, s."""
    x, y = motion.place.real, motion.place.imag
    gap = np.minimum(np.minimum(x, pool[0] - x), np.minimum(y, pool[1] - y))
    near = gap < MARGIN * 0.95
    first = np.where(near.any(axis=0), near.argmax(axis=0), len(motion.times) - 1)
    return motion.times[first]


def placed(rng: np.random.Generator, world: World, lanes: Lanes, wanted: np.ndarray) -> Lanes:
    """The lanes with a start and heading, the best of TRIES simulated ones for each trial."""
    n = len(lanes)
    free = replace(world, laws=tuple(h for h in world.laws if _everywhere(h)))
    rows = [i for i, h in enumerate(world.laws) if _everywhere(h)]
    away = replace(lanes, strengths=lanes.strengths[rows])
    path = swim(free, away, LONGEST, 2 * STEP).place
    starts = np.zeros((6, n * TRIES))
    for k in range(n * TRIES):
        j = k % n
        steps = int(wanted[j] / (2 * STEP)) + 1
        place, turn = fitted(rng, path[:, j] - path[0, j], steps, world.pool)
        starts[:3, k] = place.real, place.imag, turn + lanes.start[2, j]
    many = replace(tiled(lanes, TRIES), start=starts)
    good = np.minimum(
        inside(swim(world, many, LONGEST, 2 * STEP), world.pool), np.tile(wanted, TRIES)
    )
    best = good.reshape(TRIES, n).argmax(axis=0)
    return replace(lanes, start=starts[:, best * n + np.arange(n)])


def _everywhere(law) -> bool:
    """Whether the law is the same all over the pool."""
    return law.form.stage != "water" and law.form.cause != "wall_effect"
