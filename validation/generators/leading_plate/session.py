"""Trials of a study: powers, head angles, heads, releases that keep the robot off the walls."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .here import Setting
from .motion import ROWS, Plant, at_rest, simulate
from .robots import Array, Robot
from .water import Unrest, draw_jolts, draw_swirl

SHORTEST, LONGEST = 5.0, 12.0
STEP = 0.02
"""Of the stored motion (s)."""
SERVO_ERROR = np.radians(0.25)
THRUST_ERROR = 0.004
ANGLES = 60
RELEASES = 7
"""Runs in which trials that end at a wall are released elsewhere."""


@dataclass(frozen=True)
class Session:
    """Commands of trials (angle in degrees) and their releases; state: of release."""

    power: Array
    angle: Array
    head: Array
    state: Array
    setting: Setting

    @property
    def count(self) -> int:
        """Number of trials."""
        return len(self.power)


def draw_pool(rng: np.random.Generator, robot: Robot) -> tuple[float, float]:
    """Length and width, some body lengths."""
    length = robot.body_length * rng.uniform(9.5, 12.5)
    return round(float(length), 2), round(float(length * rng.uniform(0.62, 0.75)), 2)


def margin(robot: Robot) -> float:
    """Distance that the centre of mass keeps from the walls (m)."""
    return 0.75 * robot.body_length + 0.03


def _commands(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    powers = ((50.0, 75.0, 100.0), (40.0, 70.0, 100.0), (60.0, 80.0, 100.0))[rng.integers(3)]
    small, large = rng.integers(14, 26), rng.integers(30, 44)
    if count == 9:
        pairs = [(p, a) for p in powers for a in (0.0, float(large), -float(large))]
    else:
        sides = (0.0, 0.0, small, -small, large, -large, large, -large)
        pairs = [(p, float(a)) for p in powers for a in sides]
    power, angle = np.array([pairs[k] for k in rng.permutation(count)]).T
    return power, angle


def draw_session(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], unrest: Unrest,
    *, count: int, two_heads: bool, rounds: bool = False,
) -> Session | None:  # fmt: skip
    """A session; None where the trials do not fit into the pool. rounds: long turns are wanted."""
    power, angle = _commands(rng, count)
    head = np.full(count, robot.head_length)
    if two_heads:
        head[rng.permutation(count)[: count // 2]] = round(robot.head_length * 1.45, 4)
    exponent = rng.uniform(0.9, 1.25)
    flap = robot.flap * (power / 100) ** exponent * (1 + rng.normal(0, 0.004, count))
    span = np.clip(rng.uniform(6.0, 14.0, count), 6.0, LONGEST)
    if rounds:
        span[angle != 0] = LONGEST
    setting = Setting(
        phi=np.radians(angle) + rng.normal(0, SERVO_ERROR, count), flap=flap,
        full=np.full(count, robot.flap), head=head,
        thrust=1 + rng.normal(0, THRUST_ERROR, count), delay=np.zeros(count),
        since=np.zeros(count), order=np.linspace(0, 1, count), span=span,
        coefficients=np.outer(robot.coefficients, np.ones(count)),
        fin=np.outer([robot.fin.strength, robot.fin.arm] if robot.fin else [0, 0], np.ones(count)),
        push=np.zeros((3, count)), swirl=draw_swirl(rng, unrest, robot, count),
        jolts=draw_jolts(rng, unrest, count),
    )  # fmt: skip
    placed = _place(rng, Plant(robot, pool), setting)
    if placed is None:
        return None
    places, directions, span = placed
    state = at_rest(places, directions)
    state[3:5] = rng.normal(0, 0.0015, (2, count))
    state[5] = rng.normal(0, 0.006, count)
    return Session(power, angle, head, state, setting.but(span=span))


def _place(
    rng: np.random.Generator, plant: Plant, setting: Setting
) -> tuple[Array, Array, Array] | None:
    """Places and directions (rad) of release and durations, from runs in still water."""
    still = setting.but(swirl=0 * setting.swirl, jolts=0 * setting.jolts)
    count = len(setting.phi)
    times = np.arange(0, LONGEST + 0.05, 0.1)
    runs = simulate(plant, still, np.zeros((ROWS, count)), times)
    path = runs[0] + 1j * runs[1]
    places, directions = np.zeros(count, dtype=complex), np.zeros(count)
    span = setting.span.copy()
    for k in range(count):
        while True:
            found = _release(rng, plant, path[k, : int(10 * span[k]) + 1])
            if found or span[k] <= SHORTEST:
                break
            span[k] = max(SHORTEST, 0.92 * span[k])
        if found is None:
            return None
        places[k], directions[k] = found
    return places, directions + rng.normal(0, 0.03, count), np.round(span, 2)


def _release(rng: np.random.Generator, plant: Plant, path: Array) -> tuple[complex, float] | None:
    """Place of release and turn of a path (complex) that keep it off the walls."""
    free = 2 * margin(plant.robot)
    path = path - path[0]
    turns = np.linspace(0, 2 * np.pi, ANGLES, endpoint=False)
    turned = path * np.exp(1j * turns)[:, None]
    wide = [np.ptp(part, axis=1) for part in (turned.real, turned.imag)]
    fits = (wide[0] < plant.pool[0] - free) & (wide[1] < plant.pool[1] - free)
    if not fits.any():
        return None
    pick = rng.choice(np.flatnonzero(fits))
    corner = complex(turned[pick].real.min(), turned[pick].imag.min())
    slack = [size - free - w[pick] for size, w in zip(plant.pool, wide, strict=True)]
    shift = complex(*(rng.uniform(0, s) for s in slack)) + complex(1, 1) * free / 2
    return shift - corner, float(turns[pick])


@dataclass(frozen=True)
class Run:
    """Motion of all trials: times (instants), states (ROWS, trials, instants), true spans."""

    times: Array
    states: Array
    setting: Setting


def run_session(
    rng: np.random.Generator, plant: Plant, session: Session, setting: Setting
) -> tuple[Run, Session] | None:
    """Motion, cut short where a robot comes to a wall.

    Trials of which little would remain are released anew elsewhere; None where that does not help.
    """
    times = np.arange(0, session.setting.span.max() + 0.5, STEP)
    near = 0.62 * plant.robot.body_length
    for _ in range(RELEASES):
        states = simulate(plant, setting, session.state, times)
        if not np.isfinite(states).all():
            return None
        x, y = states[0], states[1]
        gap = np.minimum(np.minimum(x, plant.pool[0] - x), np.minimum(y, plant.pool[1] - y))
        span = session.setting.span.copy()
        for k in np.flatnonzero((gap < near).any(axis=1)):
            span[k] = min(span[k], times[int((gap[k] < near).argmax())] - 0.05)
        short = np.flatnonzero(span < SHORTEST)
        if not len(short):
            return Run(times, states, setting.but(span=span)), session
        start = session.state.copy()
        for k in short:
            path = (x + 1j * y)[k, : int((SHORTEST + 0.1) / STEP)]
            found = _release(rng, plant, path)
            if found is None:
                return None
            start[0, k], start[1, k] = found[0].real, found[0].imag
            start[2, k] += found[1]
        session = replace(session, state=start)
    return None
