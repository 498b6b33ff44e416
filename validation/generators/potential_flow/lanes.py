"""Trials side by side: every number is an array whose last axis is the lane."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .craft import COEFFICIENTS, Robot
from .eddies import EDDY_COUNT, WaterMotion

SERVO_ERROR = np.deg2rad(0.3)
"""Standard deviation of the head angle's error, trial by trial, rad."""
FLAP_ERROR = 0.003
"""Relative standard deviation of the flapping frequency, trial by trial."""
HEAD_ANGLES_DEG = (15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0)


@dataclass(frozen=True)
class ParallelTrials:
    """Lanes of a simulation; each array ends in the axis of the lanes, `n`."""

    trial: np.ndarray
    """(n,) index of the trial."""
    power: np.ndarray
    """(n,) %."""
    command: np.ndarray
    """(n,) commanded head angle, rad."""
    servo: np.ndarray
    """(n,) error of the head angle, rad."""
    flap: np.ndarray
    """(n,) flapping frequency, Hz."""
    head: np.ndarray
    """(n,) head length, m."""
    start: np.ndarray
    """(6, n) x, y, theta, and their rates, m, rad, s."""
    drift: np.ndarray
    """(2, n) mean velocity of the water, m/s."""
    eddies: np.ndarray
    """(MODES, 2, n) amplitudes of the eddies, m/s."""
    coefficients: np.ndarray
    """(6, n) as COEFFICIENTS."""
    strengths: np.ndarray
    """(laws, n)."""

    def __len__(self) -> int:
        return len(self.trial)


def repeat_trials(lanes: ParallelTrials, copies: int) -> ParallelTrials:
    """The lanes, `copies` times one after the other."""

    def repeat(value):
        return np.tile(value, (1,) * (value.ndim - 1) + (copies,))

    return ParallelTrials(*(repeat(getattr(lanes, f.name)) for f in fields(ParallelTrials)))


def _conditions(rng: np.random.Generator, few: bool) -> list[tuple[int, float, int]]:
    """(power index, head angle in degrees, head index): both signs, both heads, straight runs."""
    small, large = rng.choice(HEAD_ANGLES_DEG[:3]), rng.choice(HEAD_ANGLES_DEG[3:])
    if few:
        near, far = (0, 1) if rng.random() < 0.5 else (1, 0)
        rows = ((0.0, near), (large, far), (-small, near))
        return [(p, a, h) for p in range(3) for a, h in rows]
    angles = ((0.0, small, -large, large), (0.0, -small, -large, large))
    return [(p, a, h) for p in range(3) for h in (0, 1) for a in angles[h]]


def draw_trials(
    rng: np.random.Generator, craft: Robot, water: WaterMotion, few: bool
) -> ParallelTrials:
    """The trials of a study in a random order of recording; start and heading are set later."""
    plan = _conditions(rng, few)
    order = rng.permutation(len(plan))
    which, angle, head = (np.array(c) for c in zip(*(plan[i] for i in order), strict=True))
    n = len(plan)
    power = np.sort(rng.choice([40.0, 50.0, 60.0, 70.0, 75.0, 80.0, 100.0], 3, replace=False))
    hertz = (0.0690 * power - 1.1) * rng.uniform(0.93, 1.06)
    heads = craft.head_length * np.array([1.0, rng.uniform(1.3, 1.5)])
    coefficients = np.array([craft.coefficients[c] for c in COEFFICIENTS])
    return ParallelTrials(
        trial=np.arange(n), power=power[which], command=np.deg2rad(angle),
        servo=SERVO_ERROR * rng.normal(size=n),
        flap=hertz[which], head=np.round(heads, 3)[head],
        start=np.zeros((6, n)), drift=water.drift * rng.normal(size=(2, n)),
        eddies=water.eddy * rng.normal(size=(EDDY_COUNT, 2, n)),
        coefficients=np.repeat(coefficients[:, None], n, axis=1), strengths=np.zeros((0, n)),
    )  # fmt: skip
