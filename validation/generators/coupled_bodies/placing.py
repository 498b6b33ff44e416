"""Trials that begin from rest inside the pool and stay in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .articulated import Film, swim
from .form import Hidden
from .robots import Lanes, Robot

Array = NDArray[np.float64]
MARGIN = 0.22
"""Least distance of the centre of mass from a wall, m."""
SHORTEST, LONGEST = 4.0, 9.0


class NoRoomError(Exception):
    """A trial leaves the pool too soon."""


@dataclass(frozen=True)
class Motion:
    """Motion of all trials, with the time, s, at which each ends."""

    lanes: Lanes
    film: Film
    ends: Array


def ends(film: Film, pool: tuple[float, float, float], wanted: Array) -> Array:
    """Time, s, at which each trial leaves the inner pool, or the wanted one."""
    x, y = film.states[:, 0], film.states[:, 1]
    inside = (x > MARGIN) & (x < pool[0] - MARGIN) & (y > MARGIN) & (y < pool[1] - MARGIN)
    stays = np.logical_and.accumulate(inside, 0).sum(0)
    return np.minimum(wanted, film.times[np.maximum(stays - 1, 0)])


def place(rng: np.random.Generator, lanes: Lanes, film: Film, pool: tuple[float, float, float],
          *, wanted: Array, which: Array) -> Lanes:  # fmt: skip
    """The lanes with courses and starting places at which the paths seen so far fit the pool."""
    start = lanes.start.copy()
    room = np.array(pool[:2]) - 2 * MARGIN - 0.06
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
        corner = MARGIN + 0.03 - low[best, last] + slack * rng.random(2)
        start[:3, k] = *corner, courses[best]
    return replace(lanes, start=start)


def placed(rng: np.random.Generator, lanes: Lanes, robot: Robot, laws: Sequence[Hidden],
           *, pool: tuple[float, float, float], wanted: Array) -> Motion:  # fmt: skip
    """Motion of trials placed so that each lasts for 4 s at least.

    Raises: NoRoomError where a trial does not.
    """
    start = lanes.start.copy()
    start[0], start[1] = pool[0] / 2, pool[1] / 2
    lanes = replace(lanes, start=start)
    film = swim(lanes, robot, laws, LONGEST)
    late = np.ones(lanes.count, bool)
    for _ in range(4):
        lanes = place(rng, lanes, film, pool, wanted=wanted, which=late)
        motion = run(lanes, robot, laws, pool, wanted)
        film, late = motion.film, motion.ends < SHORTEST
        if not late.any():
            return motion
    raise NoRoomError


def run(lanes: Lanes, robot: Robot, laws: Sequence[Hidden], pool: tuple[float, float, float],
        wanted: Array) -> Motion:  # fmt: skip
    """Motion from the starts that the lanes have."""
    film = swim(lanes, robot, laws, LONGEST + 1)
    return Motion(lanes, film, ends(film, pool, wanted))
