"""Trials of a study: conditions, durations, and places of release inside the basin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .form import Array, HiddenCause, ParallelTrials
from .motion import STEP_S, simulate_motion
from .robots import Robot
from .water import RandomAccelerations, draw_accelerations, draw_release

SERVO_STD_RAD = np.radians(0.3)
"""Standard deviation of the servo's constant error in a trial, rad."""
MAX_TRIAL_S = 12.0
TRIAL_COUNTS = (9, 12, 15, 15, 18, 18, 20, 20, 24, 24, 30)
"""Numbers of trials of a study, each as likely as it is often here."""
SHARE_TWO_HEADS = 0.5
START_CANDIDATES = 240
REPEATABILITY_S = 3.0
REPEATABILITY_RANGE_M = (1.5e-3, 5e-3)
"""Time after the release and range of the distance by which repeated turns differ then."""
LONG_HEAD = 1.45
"""Length of the longer head over the shorter one."""


@dataclass(frozen=True)
class TrialDesign:
    """Conditions of the trials, arrays (trials,). power: %. commanded: rad. wanted: s."""

    power: Array
    commanded: Array
    lanes: ParallelTrials
    wanted: Array
    first: Array
    pushes: Array
    margin: float


def straight_trial(robot: Robot, hertz: float) -> ParallelTrials:
    """One trial with a straight head from the origin along x."""
    return ParallelTrials(
        np.zeros(1), np.full(1, hertz), np.full(1, robot.head_length), np.zeros(1, complex),
        np.zeros(1), (6.0, 3.0),
    )  # fmt: skip


def calibrate_unrest(rng: np.random.Generator, robot: Robot) -> RandomAccelerations:
    """Water in which turns of this robot are repeated to 1.5 to 5 mm (rms) after three seconds."""
    path = float(np.exp(rng.uniform(*np.log(REPEATABILITY_RANGE_M))))
    memory = float(rng.uniform(0.2, 0.7))
    # random forces act at random points about 0.1 m off the centre of mass: m a x / I
    lever = robot.mass * float(rng.uniform(0.05, 0.15)) / robot.inertia
    unit = RandomAccelerations(1e-3, 1e-3 * lever, memory, (0.0, 0.0))
    count, steps = 24, round(REPEATABILITY_S / STEP_S)
    one = straight_trial(robot, 4.0)
    lanes = replace(
        one, angle=np.full(count, 0.6), hertz=np.full(count, 4.0), heading=np.zeros(count),
        head=np.full(count, robot.head_length), start=np.zeros(count, complex),
    )  # fmt: skip
    pushes = draw_accelerations(rng, unit, steps, count)
    pushes[..., 0] = 0
    end = simulate_motion(lanes, robot, (), first=np.zeros((3, count)), pushes=pushes)[-1]
    off = np.hypot(end[0] - end[0, 0], end[1] - end[1, 0])[1:]
    scale = path / float(np.sqrt(np.mean(off**2)))
    return RandomAccelerations(unit.linear * scale, unit.turning * scale, memory)


def _conditions(rng: np.random.Generator, count: int, heads: Sequence[float]) -> Array:
    """Power (%), head angle (deg), head length (m) of each trial, all powers and both sides."""
    powers = [(50, 75, 100), (40, 70, 100), (60, 100), (50, 65, 80, 100)][rng.integers(4)]
    if count < 12:
        powers, turns = (50, 75, 100), [int(rng.choice([25, 30, 40]))]
    else:
        turns = [(15, 30, 45), (20, 40), (30, 45), (10, 25, 40)][rng.integers(4)]  # type: ignore[assignment]
    angles = [0, *turns, *(-a for a in turns)]
    grid = [(p, a, h) for h in heads for p in powers for a in angles]
    chosen: list[tuple[float, float, float]] = []
    while len(chosen) < count:
        chosen += [grid[i] for i in rng.permutation(len(grid))]
    rows = np.array(chosen[:count])
    return rows[np.lexsort((np.abs(rows[:, 1]), rows[:, 0]))]


def draw_design(
    rng: np.random.Generator,
    robot: Robot,
    unrest: RandomAccelerations,
    *,
    pool: tuple[float, float],
    two_heads: bool,
    margin: float,
) -> TrialDesign:
    """Conditions of 9 to 30 trials, not yet placed."""
    count = int(rng.choice(TRIAL_COUNTS))
    heads = [robot.head_length]
    if two_heads or rng.random() < SHARE_TWO_HEADS:
        heads.append(round(LONG_HEAD * robot.head_length, 3))
        count = max(count, 12)
    rows = _conditions(rng, count, heads)
    exponent, full = rng.uniform(1.0, 1.35), rng.uniform(5.2, 6.2)
    hertz = full * (rows[:, 0] / 100) ** exponent * (1 + 0.003 * rng.normal(size=count))
    commanded = np.radians(rows[:, 1])
    lanes = ParallelTrials(commanded + rng.normal(0, SERVO_STD_RAD, count), hertz, rows[:, 2],
                  np.zeros(count, complex), np.zeros(count), pool)  # fmt: skip
    wanted = rng.uniform(6.0, MAX_TRIAL_S, count)
    steps = round(MAX_TRIAL_S / STEP_S)
    return TrialDesign(
        rows[:, 0],
        commanded,
        lanes,
        wanted,
        draw_release(rng, unrest, count),
        draw_accelerations(rng, unrest, steps, count),
        margin,
    )


def _is_inside(path: Array, pool: tuple[float, float], margin: float) -> Array:
    length, width = pool
    return ((path.real > margin) & (path.real < length - margin)
            & (path.imag > margin) & (path.imag < width - margin))  # fmt: skip


def trial_ends(states: Array, design: TrialDesign) -> Array:
    """End of each trial, s: as wanted, or before the robot comes too near a wall."""
    path = states[:, 0] + 1j * states[:, 1]
    out = ~_is_inside(path, design.lanes.pool, design.margin)
    first = np.where(out.any(axis=0), out.argmax(axis=0), len(states) - 1) * STEP_S
    return np.floor(np.minimum(first, design.wanted) * 10) / 10


def with_start_poses(
    rng: np.random.Generator, design: TrialDesign, robot: Robot, hidden: Sequence[HiddenCause]
) -> TrialDesign:
    """The design with releases from which the robot stays inside for long.

    Motion without hidden causes of the place is the same from any release, in axes of the release.
    """
    moving = [h for h in hidden if h.form.stage != "water" and h.form.cause != "wall_effect"]
    centre = complex(*design.lanes.pool) / 2
    count = design.lanes.angle.size
    free = replace(design.lanes, start=np.full(count, centre), heading=np.zeros(count))
    states = simulate_motion(free, robot, moving, first=design.first, pushes=design.pushes)
    path = (states[::12, 0] + 1j * states[::12, 1]) - centre
    starts, headings = np.empty(count, complex), np.empty(count)
    length, width = design.lanes.pool
    for k in range(count):
        room = design.margin + 0.1
        x = rng.uniform(room, length - room, START_CANDIDATES)
        y = rng.uniform(room, width - room, START_CANDIDATES)
        turn = rng.uniform(-np.pi, np.pi, START_CANDIDATES)
        wanted = path[: 1 + int(design.wanted[k] / (12 * STEP_S)), k, None]
        inside = _is_inside(x + 1j * y + wanted * np.exp(1j * turn), design.lanes.pool, room)
        stay = np.where(inside.all(axis=0), len(wanted), inside.argmin(axis=0))
        best = int(stay.argmax())
        starts[k], headings[k] = complex(x[best], y[best]), turn[best]
    return replace(design, lanes=replace(design.lanes, start=starts, heading=headings))
