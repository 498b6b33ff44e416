"""Robots and the trials they swim, drawn at random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray
BLADE_COUNT = 14
"""Blade elements from the hinge to the tip of the tail."""
WATER_MODES = 7
"""Slow motions of the water that differ from trial to trial."""


@dataclass(frozen=True)
class Robot:
    """Body, water and coefficients of one robot, SI units. Symbols as in the published model."""

    mass: float
    inertia: float
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
    density: float = 1000.0

    @property
    def stations(self) -> tuple[Array, Array, Array]:
        """Place ahead of the centre of mass, height and length of each blade, (stations, 1), m."""
        aft = self.body_length - self.head_length - self.hinge_to_com + self.tail_length
        edges = np.linspace(self.hinge_to_com, -aft, BLADE_COUNT + 1)
        x = 0.5 * (edges[1:] + edges[:-1])
        along = (self.hinge_to_com - x) / (self.hinge_to_com + aft)
        body = np.sqrt(np.clip(1 - (along / 0.8) ** 2, 0.04, 1))  # tapers to the peduncle
        fin = 1.25 * np.clip((along - 0.82) / 0.18, 0, 1)
        height = self.span * np.maximum(body, fin)
        return x[:, None], height[:, None], np.full((BLADE_COUNT, 1), edges[0] - edges[1])

    def area(self, head: Array | float) -> Array:
        """Area of a head plate, m^2."""
        return np.asarray(head) * self.span

    def arm(self, head: Array | float) -> Array:
        """Distance from the centre of mass to the aerodynamic centre, m."""
        whole = self.body_length + np.asarray(head) - self.head_length
        return np.asarray(head) + self.hinge_to_com - whole / 4


@dataclass(frozen=True)
class ParallelTrials:
    """Trials side by side: what differs between them, each of shape (lanes,) or (modes, lanes)."""

    power: Array
    head_angle: Array
    servo_error: Array
    flap: Array
    head: Array
    order: Array
    start: Array
    heading: Array
    flow: Array
    rates: Array
    phases: Array
    jitter: Array
    flow_bias: Array

    def take(self, index: Array) -> ParallelTrials:
        """Lanes of these numbers, repeated where a number is."""
        return ParallelTrials(**{k: v[..., index] for k, v in vars(self).items()})

    def water(self, t: Any) -> Array:
        """Velocity of the restless water as a complex number, m/s."""
        return self.flow_bias + (self.flow * np.cos(self.rates * t + self.phases)).sum(0)

    def wobble(self, t: Any) -> Array:
        """Relative deviation of the flapping frequency at a time."""
        return (self.jitter * np.cos(1.7 * self.rates * t - self.phases)).sum(0)


def draw_robot(rng: np.random.Generator, fin: bool) -> Robot:
    """A robot of about the published size; with a fin, a less damped yaw."""
    length = rng.uniform(0.29, 0.37)
    mass = 0.68 * (length / 0.331) ** 3 * rng.uniform(0.85, 1.2)
    return Robot(
        mass=mass, inertia=mass * length**2 * 0.1275 * rng.uniform(0.85, 1.2),
        body_length=length, head_length=length * rng.uniform(0.33, 0.39),
        span=length * rng.uniform(0.19, 0.225), hinge_to_com=length * rng.uniform(0.1, 0.14),
        tail_length=length * rng.uniform(0.18, 0.22), depth=rng.uniform(0.025, 0.06),
        C_T=rng.uniform(3.2e-3, 5.4e-3), C_D0=rng.uniform(0.4, 0.65), C_Da=rng.uniform(0.6, 3.5),
        C_La=rng.uniform(2.3, 3.4), C_Ma=rng.uniform(0.05, 0.13),
        C_Md=rng.uniform(0.09, 0.15) * (0.7 if fin else 1.0),
    )  # fmt: skip


def draw_trials(rng: np.random.Generator, robot: Robot, few: bool) -> ParallelTrials:
    """24 trials, or nine: powers, head angles to both sides, two lengths of the head."""
    count = 9 if few else 24
    powers = np.array([50, 75, 100] if few or rng.random() < 0.6 else [45, 60, 80, 100])
    hertz = rng.uniform(5.0, 6.0) * (powers / 100) ** rng.uniform(1.0, 1.3)
    angles = np.sort(rng.choice([10, 15, 20, 25, 30, 35, 40, 45], 2 if few else 3, replace=False))
    longer = robot.head_length * rng.choice([1.35, 1.45, 1.5])
    cells = [(p, s * a) for p in range(len(powers)) for a in angles for s in (-1, 1)]
    cells = [cells[i] for i in rng.permutation(len(cells))]
    straight = [(p % len(powers), 0) for p in range(2 if few else 4)]
    cells = (straight + cells + cells)[:count]
    cells = [cells[i] for i in rng.permutation(count)]
    level = np.array([c[0] for c in cells])
    head = np.where(rng.random(count) < 0.35, longer, robot.head_length)
    head[:2] = robot.head_length, longer
    shape = (WATER_MODES, count)
    speed = rng.uniform(4e-4, 1.4e-3) / np.sqrt(WATER_MODES / 2)
    flow = speed * (rng.normal(size=shape) + 1j * rng.normal(size=shape)) / np.sqrt(2)
    return ParallelTrials(
        power=powers[level].astype(float), head_angle=np.deg2rad([float(c[1]) for c in cells]),
        servo_error=np.deg2rad(rng.uniform(0.1, 0.35)) * rng.normal(size=count),
        flap=hertz[level] * (1 + 1e-3 * rng.normal(size=count)),
        head=head, order=np.arange(count) / count, start=np.zeros(count, complex),
        heading=np.zeros(count), flow=flow, rates=2 * np.pi * rng.uniform(0.03, 0.4, shape),
        phases=rng.uniform(0, 2 * np.pi, shape), jitter=7e-4 * rng.normal(size=shape),
        flow_bias=np.zeros(count, complex),
    )  # fmt: skip
