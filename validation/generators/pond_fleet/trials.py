"""The session: conditions, places where trials start, and errors of each trial."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .dynamics import RATE, ROWS, SURGE, SWAY, THETA, Plant, X, Y, integrate
from .flow import Setting
from .robots import Array, Robot

SERVO_ERROR = np.radians(0.3)
"""Standard deviation of the head angle about the commanded one (rad)."""
CLEARANCE = 0.85
"""Least distance of the centre of mass from a wall in planning, in body lengths."""


@dataclass(frozen=True)
class Session:
    """Arrays (trials,). power (%), phi: commanded angle (rad), head (m), flap: true frequency (Hz).

    logged: stated over true frequency where there is no log. start: states (rows, trials).
    duration (s). quality: factor on the thrust.
    """

    power: Array
    phi: Array
    head: Array
    flap: Array
    servo_error: Array
    logged: Array
    quality: Array
    duration: Array
    start: Array

    @property
    def count(self) -> int:
        """Number of trials."""
        return len(self.phi)

    @property
    def order(self) -> Array:
        """Place in the session, 0 to 1."""
        return np.arange(self.count) / (self.count - 1)


def draw_pool(rng: np.random.Generator, robot: Robot) -> tuple[float, float]:
    """Length and width (m): a tank, a pool or a square basin in proportion to the robot."""
    length = rng.uniform(8, 13) * robot.body_length
    width = length * rng.uniform(0.55, 1.0)
    return round(max(length, width), 2), round(min(length, width), 2)


def draw_session(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], *, two_heads: bool
) -> Session:
    """Nine to 24 trials; turns to both sides in 19 of 20 sessions."""
    count = int(rng.choice([9, 12, 15, 18, 21, 24]))
    power, phi = _draw_conditions(rng, count)
    head = np.full(count, robot.head_length)
    if two_heads:
        longer = rng.permutation(count) < max(3, count // 3)
        head[longer] = round(robot.head_length * rng.choice([1.25, 1.4, 1.5, 1.6]), 4)
    idle = rng.uniform(8, 22)
    flap = robot.flap * (power - idle) / (100 - idle) * (1 + 0.004 * rng.normal(size=count))
    session = Session(
        power, phi, head, flap, SERVO_ERROR * rng.normal(size=count),
        1 + 0.003 * rng.normal(size=count), 1 + 0.006 * rng.normal(size=count),
        np.zeros(count), _starts(rng, robot, count),
    )  # fmt: skip
    return _placed(rng, robot, pool, session)


def _draw_conditions(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Power (%) and commanded head angle (rad) of each trial, in random order."""
    powers = np.array([(55, 75, 100), (60, 80, 100), (50, 100, 75), (70, 85, 100), (65, 100, 82)])
    powers = powers[rng.integers(len(powers))]
    sizes = np.sort(rng.choice([12, 18, 22, 28, 34, 40, 45], 2 if count < 15 else 3, replace=False))
    one_sided = rng.random() < 0.05
    angles = [0.0, *sizes, *(sizes if one_sided else -sizes)]
    design = np.array([(p, a) for a in angles for p in powers])
    while True:
        rows = np.concatenate([rng.permutation(design) for _ in range(3)])[:count]
        straight = int((rows[:, 1] == 0).sum())
        sides = {np.sign(a) for a in rows[:, 1]} - {0.0}
        enough = (rows[:, 1] > 0).sum() >= 2 and (one_sided or (rows[:, 1] < 0).sum() >= 2)
        if straight >= 2 and enough and len(sides) == (1 if one_sided else 2):
            return rows[:, 0], np.radians(rows[:, 1])


def _starts(rng: np.random.Generator, robot: Robot, count: int) -> Array:
    """Nearly at rest: drift of 0.4 % of the speed after the robot is let go."""
    start = np.zeros((ROWS, count))
    drift = 0.004 * robot.speed
    start[SURGE], start[SWAY] = drift * rng.normal(size=(2, count))
    start[RATE] = 0.006 / robot.body_time * rng.normal(size=count)
    return start


def plain_plant(robot: Robot, pool: tuple[float, float], session: Session) -> Plant:
    """The model of the session without hidden laws, disturbances and errors of a trial."""
    ones, fin = np.ones(session.count), robot.fin
    setting = Setting(session.flap, session.phi, session.head, session.order, session.duration)
    return Plant(
        robot, pool, setting, np.outer(robot.coefficients, ones),
        (fin.area * fin.slope if fin else 0.0) * ones, (fin.arm if fin else 0.0) * ones, ones,
    )  # fmt: skip


def _placed(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], session: Session
) -> Session:
    """Starts from which the expected path stays in the pool longest, and how long."""
    travel = rng.uniform(9, 15, session.count) * robot.body_length
    longest = travel / (robot.speed * np.maximum(session.flap / robot.flap, 0.25))
    planned = replace(session, duration=longest)
    motion = integrate(plain_plant(robot, pool, planned), session.start, 400, keep_every=5)
    path = motion.states[:, X] + 1j * motion.states[:, Y]
    start, duration = session.start.copy(), longest.copy()
    for k in range(session.count):
        place, heading, share = _best_place(rng, robot, pool, path[:, k])
        start[X, k], start[Y, k], start[THETA, k] = place.real, place.imag, heading
        duration[k] *= share
    return replace(planned, start=start, duration=duration)


def _best_place(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], path: Array
) -> tuple[complex, float, float]:
    """Start (m), heading (rad) and the share of a path that stays clear of the walls."""
    edge = CLEARANCE * robot.body_length
    tries = 400
    heading = rng.uniform(-np.pi, np.pi, tries)
    start = rng.uniform(edge, pool[0] - edge, tries) + 1j * rng.uniform(edge, pool[1] - edge, tries)
    place = start[:, None] + np.exp(1j * heading)[:, None] * (path - path[0])
    inside = (np.abs(place.real - pool[0] / 2) < pool[0] / 2 - edge) & (
        np.abs(place.imag - pool[1] / 2) < pool[1] / 2 - edge
    )
    share = np.where(inside.all(axis=1), 1.0, np.argmin(inside, axis=1) / len(path))
    good = np.flatnonzero(share >= 0.93 * share.max())
    best = int(rng.choice(good))
    return complex(start[best]), float(heading[best]), float(max(share[best], 0.05))
