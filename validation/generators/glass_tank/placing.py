"""Starting places from which the paths of the trials stay in the pool."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .form import DT, Array
from .robots import Plan, Robot

MARGIN, ROOM = 0.06, 0.3
"""Distances kept from the walls when a trial ends and when it is placed, body lengths."""


def ends(robot: Robot, plan: Plan, out: Array) -> tuple[Array, Array]:
    """Positions of nose and tail tip (complex, m) along simulated paths (steps, states, trials)."""
    centre, axis = out[:, 0] + 1j * out[:, 1], np.exp(1j * out[:, 2])
    trials = plan.trials
    nose = centre + axis * (robot.hinge_to_com + trials.head * np.exp(-1j * trials.phi))
    return nose, centre - axis * (robot.tail_arm + robot.tail_length)


def time_inside(robot: Robot, plan: Plan, out: Array) -> Array:
    """Time (s) until nose or tail come too near to a wall, (trials,)."""
    length, width = robot.pool
    margin = MARGIN * robot.body_length
    inside = np.ones(out.shape[::2], bool)
    for end in ends(robot, plan, out):
        inside &= (end.real > margin) & (end.real < length - margin)
        inside &= (end.imag > margin) & (end.imag < width - margin)
    return np.where(inside.all(0), len(out), np.argmin(inside, axis=0)) * DT - DT


def _longest_fit(
    rng: np.random.Generator, paths: Array, room: tuple[float, float]
) -> tuple[float, tuple[float, float], tuple[float, float]]:
    """Turn (rad) after which the paths (steps, 2) fit longest into the room (m).

    Also the lowest and highest x, and y, of the part that fits.
    """
    n = len(paths)
    best = (-1, 0.0, (0.0, 0.0), (0.0, 0.0))
    for turn in rng.uniform(-np.pi, np.pi, 48):
        turned = paths * np.exp(1j * turn)
        low = [np.minimum.accumulate(part.min(1)) for part in (turned.real, turned.imag)]
        high = [np.maximum.accumulate(part.max(1)) for part in (turned.real, turned.imag)]
        fits = (high[0] - low[0] < room[0]) & (high[1] - low[1] < room[1])
        steps = n if fits.all() else int(np.argmin(fits))
        if steps > best[0]:
            last = max(steps - 1, 0)
            x, y = ((low[k][last], high[k][last]) for k in range(2))
            best = (steps, turn, x, y)
    return best[1:]


def place(
    rng: np.random.Generator,
    robot: Robot,
    plan: Plan,
    out: Array,
    *,
    which: Iterable[int],
    first: Array,
    to_walls: bool = False,
) -> None:
    """Change the first states of the trials `which` so that their paths fit long into the pool.

    Takes the paths of `out` as rigid curves, tries headings, keeps the one that fits longest, and
    puts it anywhere where there is room (along the walls if to_walls).
    """
    nose, tail = ends(robot, plan, out)
    trials, margin = plan.trials, ROOM * robot.body_length
    room = (robot.pool[0] - 2 * margin, robot.pool[1] - 2 * margin)
    for i in which:
        start = out[0, 0, i] + 1j * out[0, 1, i]
        n = int(min(plan.wanted[i] / DT, len(out) - 1))
        paths = np.stack([nose[:n, i], tail[:n, i]], 1) - start
        turn, *boxes = _longest_fit(rng, paths, room)
        shares = rng.beta(0.35, 0.35, 2) if to_walls else rng.uniform(0, 1, 2)
        for k, (low, high) in enumerate(boxes):
            first[k, i] = margin - low + shares[k] * max(room[k] - (high - low), 0)
        velocity = (first[3, i] + 1j * first[4, i]) * np.exp(1j * turn)
        first[3, i], first[4, i] = velocity.real, velocity.imag
        trials.heading[i] = np.angle(np.exp(1j * (trials.heading[i] + turn)))
        first[2, i] = trials.heading[i]
