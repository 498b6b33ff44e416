"""Trials that begin from rest inside the pool and stay in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .articulated import SimulatedMotion, simulate_motion
from .form import HiddenLaw
from .robots import ParallelTrials, Robot

Array = NDArray[np.float64]
WALL_MARGIN_M = 0.22
"""Least distance of the centre of mass from a wall, m."""
SHORTEST, LONGEST = 4.0, 9.0


class NoRoomError(Exception):
    """A trial leaves the pool too soon."""


@dataclass(frozen=True)
class PlacedMotion:
    """Motion of all trials, with the time, s, at which each ends."""

    lanes: ParallelTrials
    film: SimulatedMotion
    ends: Array


def time_inside_pool(
    film: SimulatedMotion, pool: tuple[float, float, float], wanted: Array
) -> Array:
    """Time, s, at which each trial leaves the inner pool, or the wanted one."""
    x, y = film.states[:, 0], film.states[:, 1]
    inside = (
        (x > WALL_MARGIN_M)
        & (x < pool[0] - WALL_MARGIN_M)
        & (y > WALL_MARGIN_M)
        & (y < pool[1] - WALL_MARGIN_M)
    )
    stays = np.logical_and.accumulate(inside, 0).sum(0)
    return np.minimum(wanted, film.times[np.maximum(stays - 1, 0)])


def draw_start_poses(
    rng: np.random.Generator,
    lanes: ParallelTrials,
    film: SimulatedMotion,
    pool: tuple[float, float, float],
    *,
    wanted: Array,
    which: Array,
) -> ParallelTrials:
    """The lanes with courses and starting places at which the paths seen so far fit the pool."""
    start = lanes.start.copy()
    room = np.array(pool[:2]) - 2 * WALL_MARGIN_M - 0.06
    for k in np.flatnonzero(which):
        path = film.states[:, 0, k] + 1j * film.states[:, 1, k]
        path = (path - path[0]) * np.exp(-1j * start[2, k])
        courses = rng.uniform(-np.pi, np.pi, 40)
        turned = path * np.exp(1j * courses[:, None])
        flat = np.stack([turned.real, turned.imag], -1)
        low, high = np.minimum.accumulate(flat, 1), np.maximum.accumulate(flat, 1)
        fits = np.all(high - low < room, -1).sum(1) - 1
        goal = int(np.searchsorted(film.times, wanted[k]))
        best = int(np.argmax(np.minimum(fits, goal)))
        last = min(fits[best], goal)
        slack = room - (high - low)[best, last]
        corner = WALL_MARGIN_M + 0.03 - low[best, last] + slack * rng.random(2)
        start[:3, k] = *corner, courses[best]
    return replace(lanes, start=start)


def simulate_placed(
    rng: np.random.Generator,
    lanes: ParallelTrials,
    robot: Robot,
    laws: Sequence[HiddenLaw],
    *,
    pool: tuple[float, float, float],
    wanted: Array,
) -> PlacedMotion:
    """Motion of trials placed so that each lasts for 4 s at least.

    Raises: NoRoomError where a trial does not.
    """
    start = lanes.start.copy()
    start[0], start[1] = pool[0] / 2, pool[1] / 2
    lanes = replace(lanes, start=start)
    film = simulate_motion(lanes, robot, laws, LONGEST)
    late = np.ones(lanes.count, bool)
    for _ in range(4):
        lanes = draw_start_poses(rng, lanes, film, pool, wanted=wanted, which=late)
        motion = simulate_from_starts(lanes, robot, laws, pool, wanted)
        film, late = motion.film, motion.ends < SHORTEST
        if not late.any():
            return motion
    raise NoRoomError


def simulate_from_starts(
    lanes: ParallelTrials,
    robot: Robot,
    laws: Sequence[HiddenLaw],
    pool: tuple[float, float, float],
    wanted: Array,
) -> PlacedMotion:
    """Motion from the starts that the lanes have."""
    film = simulate_motion(lanes, robot, laws, LONGEST + 1)
    return PlacedMotion(lanes, film, time_inside_pool(film, pool, wanted))
