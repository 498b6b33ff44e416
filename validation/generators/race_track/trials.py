"""Schedule of trials: 9 to 24, powers, head angles, head lengths, repeats, starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .form import Law
from .loads import Bench
from .motion import Z, at_rest, integrate
from .robots import Array, Robot
from .water import Unrest

ANGLES = ((30, 45), (15, 30, 45), (20, 40), (10, 25, 40))
POWERS = ((50, 75, 100), (40, 70, 100), (60, 80, 100), (50, 100))
MARGIN = 0.45
"""Body lengths between centre of mass and wall at which a recording ends."""


@dataclass(frozen=True)
class Schedule:
    """Commanded conditions of the trials, their hidden errors and starts.

    phi: rad. servo: error of the head angle (rad). flap: Hz. logged: error of a stated flap_hz.
    quality: factor on the thrust. z, psi: start. duration: s. All (trials,).
    """

    power: Array
    phi: Array
    head: Array
    flap: Array
    servo: Array
    logged: Array
    quality: Array
    z: Array
    psi: Array
    duration: Array

    @property
    def count(self) -> int:
        """How many trials."""
        return len(self.power)


def draw_pool(rng: np.random.Generator, robot: Robot) -> tuple[float, float]:
    """Length and width of a pool (m)."""
    length = 2.6 * (robot.body_length / 0.331) ** 0.85 * rng.uniform(1.0, 1.5)
    return round(float(length), 2), round(float(length * rng.uniform(0.55, 0.72)), 2)


def _conditions(rng: np.random.Generator, two_heads: bool) -> Array:
    """Rows (power %, head angle in degrees, head factor)."""
    angles, powers = ANGLES[rng.integers(len(ANGLES))], POWERS[rng.integers(len(POWERS))]
    sides = (1, -1) if rng.random() < 0.85 else (1,)
    rows = [(p, s * a, 1.0) for p in powers for a in angles for s in sides]
    straight = [(p, 0, 1.0) for p in powers]
    count = int(rng.choice([9, 12, 15, 18, 21, 24]))
    rng.shuffle(rows)
    picked = (straight + rows)[:count]
    if two_heads:
        picked = [(p, a, 1.5 if k % 3 == 2 else f) for k, (p, a, f) in enumerate(picked)]
    while len(picked) < count:
        picked.append(picked[int(rng.integers(len(picked)))])
    return np.array(picked, float)


def draw_schedule(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], *, two_heads: bool
) -> Schedule:
    """Trials with starts that leave room to swim."""
    rows = _conditions(rng, two_heads)
    count, (power, angle, factor) = len(rows), rows.T
    flap = robot.flap * (power / 100) ** 0.9
    beats = float(rng.uniform(8, 14)) * robot.body_length / robot.speed
    plain = Schedule(
        power=power, phi=np.radians(angle), head=np.round(robot.head_length * factor, 4),
        flap=flap, servo=np.radians(rng.normal(0, 0.2, count)), logged=rng.normal(0, 0.006, count),
        quality=1 + rng.normal(0, 0.006, count), z=np.zeros(count, complex), psi=np.zeros(count),
        duration=np.full(count, beats),
    )  # fmt: skip
    return _with_starts(rng, robot, pool, plain)


def _with_starts(
    rng: np.random.Generator, robot: Robot, pool: tuple[float, float], schedule: Schedule
) -> Schedule:
    """Of 40 random starts the one with the longest swim, for every trial."""
    bench = bench_of(robot, pool, schedule)
    y = at_rest(bench, schedule.z, schedule.psi)
    path = integrate(bench, y, float(schedule.duration[0]), 1 / 20)
    margin = 0.7 * robot.body_length
    z0 = rng.uniform(margin, pool[0] - margin, (40, schedule.count)) + 1j * rng.uniform(
        margin, pool[1] - margin, (40, schedule.count)
    )
    psi0 = rng.uniform(-np.pi, np.pi, (40, schedule.count))
    tracks = z0[:, None] + np.exp(1j * psi0)[:, None] * path.y[None, :, Z]
    stays = np.logical_and.accumulate(inside(tracks, pool, margin), axis=1).sum(1)
    best = (stays, np.argmax(stays, axis=0), np.arange(schedule.count))
    z, psi = z0[best[1], best[2]], psi0[best[1], best[2]]
    duration = np.minimum(path.times[best[0][best[1], best[2]] - 1], schedule.duration)
    values = schedule.__dict__ | {"z": z, "psi": psi, "duration": duration}
    return Schedule(**values)


def inside(z: Array, pool: tuple[float, float], margin: float) -> Array:
    """Whether points keep a margin to all walls."""
    x_in = (z.real > margin) & (z.real < pool[0] - margin)
    return np.asarray(x_in & (z.imag > margin) & (z.imag < pool[1] - margin))


def bench_of(
    robot: Robot, pool: tuple[float, float], schedule: Schedule,
    *, laws: Sequence[Law] = (), unrest: Unrest | None = None, ripple: float = 0.0,
) -> Bench:  # fmt: skip
    """The trials as columns; with unrest the servo and the thrust have their errors too."""
    exact = unrest is None
    return Bench(
        robot=robot, pool=pool, flap=schedule.flap, head=schedule.head, laws=laws, unrest=unrest,
        coefficients=np.array(robot.coefficients)[:, None] + np.zeros((6, schedule.count)),
        phi=schedule.phi + (0 if exact else schedule.servo),
        quality=1.0 if exact else schedule.quality, ripple=ripple,
    )  # fmt: skip
