"""Plans of trials: powers, head angles and head lengths, and places where the paths fit."""

from dataclasses import dataclass, replace

import numpy as np

from .dynamics import TIME_STEP, Case, simulate
from .form import Active
from .robot import Robot
from .water import Ambient

LONGEST = 14.0  # s
POWER_SETS = ((50, 75, 100), (60, 80, 100), (40, 70, 100), (50, 100), (40, 60, 80, 100))


@dataclass(frozen=True)
class Campaign:
    """Conditions of each trial as arrays; `phi` is the actual head angle, `frequency` the actual
    flapping frequency, `start` (3, trials), `duration` in s.
    """

    power_pct: np.ndarray
    commanded: np.ndarray
    head: np.ndarray
    phi: np.ndarray
    logged: np.ndarray
    frequency: np.ndarray
    start: np.ndarray
    duration: np.ndarray

    @property
    def trials(self) -> int:
        """Number of trials."""
        return len(self.duration)


def draw_campaign(rng: np.random.Generator, robot: Robot, two_heads: bool) -> Campaign:
    """10 to 24 trials: every power straight and turned to both sides, then random conditions.

    `two_heads` demands two head lengths.
    """
    powers = POWER_SETS[rng.integers(len(POWER_SETS))]
    angles = np.sort(rng.choice([12, 15, 20, 25, 30, 35, 40, 45], rng.integers(2, 4), False))
    conditions = [(p, 0.0) for p in powers]
    for p in powers:
        a, b = rng.choice(angles, 2)
        conditions += [(p, float(a)), (p, -float(b))]
    trials = int(max(rng.integers(10, 25), len(conditions)))
    while len(conditions) < trials:
        sign = rng.choice([-1, 1, -1, 1, 0])
        conditions.append((rng.choice(powers), float(sign * rng.choice(angles))))
    conditions = np.array(conditions)[rng.permutation(trials)]
    two_heads = two_heads or rng.random() < 0.4
    long_heads = (rng.random(trials) < 0.4) & two_heads
    head = robot.head * np.where(long_heads, round(rng.uniform(1.25, 1.6), 2), 1.0)
    power, commanded = conditions[:, 0], np.radians(conditions[:, 1])
    logged = (
        robot.flap * (power / 100) ** rng.uniform(0.8, 1.1) * (1 + rng.normal(0, 0.005, trials))
    )
    return Campaign(
        power_pct=power,
        commanded=commanded,
        head=np.round(head, 4),
        phi=commanded + rng.normal(0, np.radians(0.3), trials),
        logged=logged,
        frequency=logged * (1 + rng.normal(0, 0.003, trials)),
        start=np.zeros((3, trials)),
        duration=rng.uniform(7, LONGEST, trials),
    )


def case_of(
    robot: Robot,
    campaign: Campaign,
    active: tuple[Active, ...],
    ambient: Ambient | None,
    variants: int = 1,
) -> Case:
    """Equations for all trials, repeated for `variants` magnitudes (variant-major rows)."""
    trials = campaign.trials
    keywords = {} if ambient is None else {"ambient": ambient.velocity}
    return Case(
        robot=robot,
        phi=np.tile(campaign.phi, variants),
        frequency=np.tile(campaign.frequency, variants),
        head=np.tile(campaign.head, variants),
        trial=np.tile(np.arange(trials), variants),
        trials=trials,
        theta_start=np.tile(campaign.start[2], variants),
        active=active,
        **keywords,
    )


def _fitting_start(rng, path: np.ndarray, room: np.ndarray, origin: float) -> np.ndarray | None:
    """Random place and heading for which the complex `path` stays within `room` (2, 2)."""
    for turn in rng.permutation(np.arange(48) * np.pi / 24):
        turned = path * np.exp(1j * turn)
        low = np.array([turned.real.min(), turned.imag.min()])
        high = np.array([turned.real.max(), turned.imag.max()])
        slack = (room[1] - room[0]) - (high - low)
        if np.all(slack > 0):
            return np.array([*(room[0] - low + slack * rng.random(2)), origin + turn])
    return None


def placed(
    rng: np.random.Generator, robot: Robot, campaign: Campaign, active: tuple[Active, ...]
) -> Campaign:
    """The campaign with starts at which undisturbed paths fit the pool, shortened where needed."""
    middle = np.array([[robot.pool[0] / 2], [robot.pool[1] / 2], [0.0]])
    here = np.tile(middle, (1, campaign.trials))
    times, states = simulate(case_of(robot, campaign, active, None), here, LONGEST)
    margin = 0.7 * robot.length
    room = np.array([[margin, margin], [robot.pool[0] - margin, robot.pool[1] - margin]])
    start, duration = here.copy(), campaign.duration.copy()
    for i in range(campaign.trials):
        path = (states[:, 0, i] - middle[0, 0]) + 1j * (states[:, 1, i] - middle[1, 0])
        found = None
        while found is None:
            found = _fitting_start(rng, path[times <= duration[i]], room, 0.0)
            duration[i] *= 1.0 if found is not None else 0.93
        start[:, i] = found
    return replace(campaign, start=start, duration=duration)


def inside(times: np.ndarray, states: np.ndarray, robot: Robot, duration: np.ndarray) -> np.ndarray:
    """Samples (steps, rows) before the end of the trial and before the robot meets a wall."""
    gap = 0.35 * robot.length
    x, y = states[:, 0], states[:, 1]
    free = (x > gap) & (x < robot.pool[0] - gap) & (y > gap) & (y < robot.pool[1] - gap)
    return np.logical_and.accumulate(free, axis=0) & (times[:, None] <= duration)


def ends(times: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Last valid time of each row, s."""
    return np.maximum(valid.sum(axis=0) - 1, 1) * (times[1] - times[0] or TIME_STEP)
