"""Robots, their trials, and the lanes in which trials are integrated side by side."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

COEFFICIENTS = ("C_T", "C_D0", "C_Da", "C_La", "C_Ma", "C_Md")
RHO = 1000.0
SERVO_STD = np.deg2rad(0.3)
FLAP_STD = 0.003
GUST_KNOTS = 10
"""Knots of the gusts by which the ideal detector describes unknown water, one a second."""


@dataclass(frozen=True)
class Robot:
    """Geometry (m, kg, kg m^2), share of the core in the inertia, coefficients of the model."""

    mass: float
    inertia: float
    core_share: float
    body_length: float
    head_length: float
    span: float
    hinge_to_com: float
    tail_length: float
    depth: float
    C_T: float
    C_D0: float
    C_Da: float
    C_La: float
    C_Ma: float
    C_Md: float

    def arm(self, head: Array | float) -> Array:
        """Centre of mass to aerodynamic centre along the head plate, m; head: nose to hinge, m."""
        total = self.body_length + head - self.head_length
        return np.asarray(head + self.hinge_to_com - total / 4)

    @property
    def tail_base(self) -> float:
        """Caudal base behind the centre of mass, m."""
        return self.body_length - self.head_length - self.hinge_to_com


@dataclass(frozen=True)
class ParallelTrials:
    """Trials side by side; the last axis of every array is the lane.

    command, angle: commanded and actual head angle, rad; flap: Hz; head: m; start: state (6, n);
    coef: the six coefficients; wander: amplitude, rad/s and phase of the changes of the flapping
    frequency (3, modes, n); mean: m/s, complex; modes: amplitudes, wave vectors, rad/s and phases
    of the water (6, modes, n); gust: m/s at the knots, complex; size: strength of each law.
    """

    power: Array
    command: Array
    angle: Array
    flap: Array
    head: Array
    start: Array
    coef: Array
    shaft: Array
    wander: Array
    mean: NDArray[np.complex128]
    modes: Array
    gust: NDArray[np.complex128]
    size: Array

    def take(self, index: NDArray[np.intp]) -> ParallelTrials:
        """Copies of the chosen lanes."""
        return ParallelTrials(*(getattr(self, f.name)[..., index].copy() for f in fields(self)))

    @property
    def count(self) -> int:
        """Number of lanes."""
        return len(self.flap)


def draw_robot(rng: np.random.Generator) -> Robot:
    """A robot of about the published size (Table I and Fig. 6 of the paper)."""

    def near(value: float, spread: float) -> float:
        return float(value * np.exp(rng.uniform(-spread, spread)))

    head = round(near(0.12, 0.12), 3)
    return Robot(
        mass=round(near(0.68, 0.2), 3), inertia=round(near(0.0095, 0.2), 5),
        core_share=rng.uniform(0.75, 0.92), body_length=round(head + near(0.211, 0.06), 3),
        head_length=head, span=round(near(0.069, 0.12), 3),
        hinge_to_com=round(rng.uniform(0.034, 0.046), 3),
        tail_length=round(near(0.066, 0.12), 3), depth=round(rng.uniform(0.03, 0.06), 3),
        C_T=near(4.5e-3, 0.2), C_D0=near(0.5, 0.2), C_Da=rng.uniform(1.5, 4.2),
        C_La=near(2.9, 0.15), C_Ma=rng.uniform(0.06, 0.14), C_Md=near(0.12, 0.2),
    )  # fmt: skip


def draw_conditions(
    rng: np.random.Generator, robot: Robot, few: bool
) -> list[tuple[int, float, float]]:
    """Power index, head angle (deg) and head length (m) of 24 trials, or of nine."""
    low, high = round(rng.uniform(18, 28)), round(rng.uniform(33, 45))
    heads = robot.head_length, round(robot.head_length * rng.uniform(1.3, 1.55), 3)
    turn = rng.choice([-1, 1])
    plan = []
    for power in range(3):
        if few:
            plan += [(power, 0, heads[0]), (power, turn * low, heads[power % 2]),
                     (power, -turn * high, heads[1 - power % 2])]  # fmt: skip
        else:
            for k, head in enumerate(heads):
                side = turn * (-1) ** (power + k)
                plan += [(power, a, head) for a in (0, low, -low, side * high)]
    return [plan[k] for k in rng.permutation(len(plan))]


def draw_trials(rng: np.random.Generator, robot: Robot, few: bool) -> ParallelTrials:
    """The trials of a study with the errors of servo and motor, in still water at the origin."""
    plan = draw_conditions(rng, robot, few)
    n = len(plan)
    levels = np.array(rng.choice([[50, 75, 100], [55, 75, 95], [60, 80, 100]]))
    hertz = np.interp(levels, [50, 75, 100], [2.37, 4.02, 5.82]) * rng.uniform(0.92, 1.08)
    which = np.array([p for p, _, _ in plan])
    command = np.deg2rad([float(a) for _, a, _ in plan])
    wander = np.stack([np.full((4, n), FLAP_STD * np.sqrt(2 / 4)), rng.uniform(0.4, 3.0, (4, n)),
                       rng.uniform(0, 2 * np.pi, (4, n))])  # fmt: skip
    coef = np.array([getattr(robot, c) for c in COEFFICIENTS])
    return ParallelTrials(
        power=levels[which].astype(float), command=command,
        angle=command + SERVO_STD * rng.normal(size=n),
        flap=hertz[which] * (1 + FLAP_STD * rng.normal(size=n)),
        head=np.array([h for _, _, h in plan]), start=np.zeros((6, n)),
        coef=np.repeat(coef[:, None], n, 1), shaft=rng.uniform(0, 1, n), wander=wander,
        mean=np.zeros(n, complex), modes=np.zeros((6, 1, n)),
        gust=np.zeros((GUST_KNOTS, n), complex), size=np.zeros((0, n)),
    )  # fmt: skip


def with_strengths(lanes: ParallelTrials, sizes: list[float]) -> ParallelTrials:
    """The lanes with these strengths of the laws."""
    return replace(lanes, size=np.repeat(np.array(sizes, float).reshape(-1, 1), lanes.count, 1))
