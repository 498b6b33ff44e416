"""Where each trial begins and how long it lasts, so that it stays in the pool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .impulse import STEP_S, Motion, StudyWorld, simulate_motion
from .lanes import ParallelTrials, repeat_trials

WALL_MARGIN_M = 0.26
"""Least distance of the centre of mass from a wall, m: the head stays inside."""
MIN_DURATION_S = 4.0
MAX_DURATION_S = 9.0
START_TRIES = 5


def fit_path_in_pool(
    rng: np.random.Generator, path: np.ndarray, wanted: int, pool
) -> tuple[complex, float]:
    """Start and turn of a path (times,) from 0 that keep most of `wanted` steps inside.

    Of 60 random turns, those that fit for longest; then a random place within the room.
    """
    turns = rng.uniform(-np.pi, np.pi, 60)
    best, chosen = 0, (pool[0] / 2 + 0.5j * pool[1], 0.0)
    room = np.array(pool[:2]) - 2 * WALL_MARGIN_M
    for turn in turns:
        at = path[:wanted] * np.exp(1j * turn)
        low = np.minimum.accumulate([at.real, at.imag], axis=1)
        high = np.maximum.accumulate([at.real, at.imag], axis=1)
        length = int(np.count_nonzero(np.all(room > (high - low).T, axis=1)))
        if length > best:
            best = length
            slack = room - (high - low)[:, length - 1]
            x, y = WALL_MARGIN_M - low[:, length - 1] + slack * rng.random(2)
            chosen = (complex(x, y), turn)
        if best == wanted:
            break
    return chosen


def time_inside_pool(motion: Motion, pool) -> np.ndarray:
    """(n,) time until the centre of mass is too near to a wall, s."""
    x, y = motion.place.real, motion.place.imag
    gap = np.minimum(np.minimum(x, pool[0] - x), np.minimum(y, pool[1] - y))
    near = gap < WALL_MARGIN_M * 0.95
    first = np.where(near.any(axis=0), near.argmax(axis=0), len(motion.times) - 1)
    return motion.times[first]


def with_start_poses(
    rng: np.random.Generator, world: StudyWorld, lanes: ParallelTrials, wanted: np.ndarray
) -> ParallelTrials:
    """The lanes with a start and heading, the best of TRIES simulated ones for each trial."""
    n = len(lanes)
    free = replace(world, laws=tuple(h for h in world.laws if _is_uniform_in_pool(h)))
    rows = [i for i, h in enumerate(world.laws) if _is_uniform_in_pool(h)]
    away = replace(lanes, strengths=lanes.strengths[rows])
    path = simulate_motion(free, away, MAX_DURATION_S, 2 * STEP_S).place
    starts = np.zeros((6, n * START_TRIES))
    for k in range(n * START_TRIES):
        j = k % n
        steps = int(wanted[j] / (2 * STEP_S)) + 1
        place, turn = fit_path_in_pool(rng, path[:, j] - path[0, j], steps, world.pool)
        starts[:3, k] = place.real, place.imag, turn + lanes.start[2, j]
    many = replace(repeat_trials(lanes, START_TRIES), start=starts)
    good = np.minimum(
        time_inside_pool(simulate_motion(world, many, MAX_DURATION_S, 2 * STEP_S), world.pool),
        np.tile(wanted, START_TRIES),
    )
    best = good.reshape(START_TRIES, n).argmax(axis=0)
    return replace(lanes, start=starts[:, best * n + np.arange(n)])


def _is_uniform_in_pool(law) -> bool:
    """Whether the law is the same all over the pool."""
    return law.form.stage != "water" and law.form.cause != "wall_effect"
