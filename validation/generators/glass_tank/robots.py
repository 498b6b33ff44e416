"""Robots, pools and plans of trials, all sizes scaled from one another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .form import Array, Trials

DEG = np.pi / 180
FRAME_RATES = (24.0, 25.0, 30000 / 1001, 30.0, 50.0, 60000 / 1001, 60.0, 100.0, 120.0)
POWERS = [
    np.array([50, 75, 100]),
    np.array([60, 80, 100]),
    np.array([40, 60, 80, 100]),
    np.array([55, 100]),
]
"""Powers of a plan, percent."""


@dataclass
class Robot:
    """A robot in its pool, in SI units.

    tail_arm: from the centre of mass to the base of the tail. top_flap: Hz, at full power;
    top_speed and top_thrust go with it. reference_yaw_rate: rad/s. turning_alpha: typical angle of
    attack in its turns, rad.
    """

    trials: int
    mass: float
    inertia: float
    body_length: float
    head_length: float
    span: float
    hinge_to_com: float
    tail_length: float
    density: float
    pool: tuple[float, float]
    pool_depth: float
    keypoint_depth: float
    top_flap: float
    top_speed: float
    top_thrust: float
    turning_alpha: float = 0.2

    @property
    def tail_arm(self) -> float:
        """From the centre of mass back to the base of the tail, m."""
        return self.body_length - self.head_length - self.hinge_to_com

    @property
    def reference_yaw_rate(self) -> float:
        """Yaw rate of a turn of radius 1.5 body lengths at top speed, rad/s."""
        return self.top_speed / (1.5 * self.body_length)


@dataclass
class Plan:
    """The trials as planned. power: percent. angle: deg. wanted: duration, s."""

    trials: Trials
    power: Array
    angle: Array
    wanted: Array


def draw_robot(
    rng: np.random.Generator, trials: int, *, deep: bool = False
) -> tuple[Robot, list[float]]:
    """A robot in its pool and its six coefficients in the paper's order.

    The paper's robot (0.68 kg, 0.331 m) is scaled geometrically: lengths as mass^(1/3), C_T as an
    area, C_Ma as a length, C_Md as the fifth power of the length. Top speed is 1.0 to 1.8 body
    lengths/s. deep: in twice the depth of water.
    """
    mass = round(float(np.exp(rng.uniform(np.log(0.3), np.log(3.0)))), 3)
    body_length = round(0.331 * (mass / 0.68) ** (1 / 3) * rng.uniform(0.93, 1.08), 3)
    k = body_length / 0.331
    head_length = round(0.12 * k * rng.uniform(0.88, 1.1), 3)
    span = round(0.069 * k * rng.uniform(0.85, 1.15), 3)
    hinge_to_com = round(0.04 * k * rng.uniform(0.8, 1.3), 3)
    tail_length = round(0.066 * k * rng.uniform(0.8, 1.25), 3)
    inertia = float(f"{0.0095 * (mass / 0.68) * k**2 * rng.uniform(0.85, 1.2):.4g}")
    density = float(rng.choice([998.0, 1000.0]))
    length, width = body_length * rng.uniform(9, 14), body_length * rng.uniform(6.3, 9)
    depth = max(0.25, rng.uniform(0.8, 1.8) * body_length) * (2.0 if deep else 1.0)
    pool_depth = round(depth, 2)
    keypoint_depth = round(float(rng.uniform(0.05, 0.25) * pool_depth), 3)
    top_flap = round(float(rng.uniform(2.2, 5.8)), 3)
    C_D0 = rng.uniform(0.38, 0.6)
    top_speed = float(body_length * rng.uniform(1.0, 1.8))
    C_T = C_D0 * (top_speed / top_flap) ** 2
    top_thrust = float(0.5 * density * head_length * span * C_T * top_flap**2)
    others = [rng.uniform(0.8, 4.0), rng.uniform(2.0, 3.4)]
    others += [rng.uniform(0.06, 0.11) * k, rng.uniform(0.09, 0.15) * k**5]
    robot = Robot(
        trials, mass, inertia, body_length, head_length, span, hinge_to_com, tail_length, density,
        (round(length, 2), round(width, 2)), pool_depth, keypoint_depth,
        top_flap, top_speed, top_thrust,
    )  # fmt: skip
    return robot, [float(f"{v:.4g}") for v in (C_T, C_D0, *others)]


def _draw_cells(rng: np.random.Generator, n: int) -> list[tuple[float, float]]:
    """Head angle (deg) and power (percent) of n trials; the six most telling come first."""
    powers = POWERS[rng.integers(4) if n > 9 else rng.integers(2)]
    low, high = sorted(rng.choice([15, 20, 25, 30, 35, 40, 45, 50], 2, replace=False))
    angles = [0, low, -low, high, -high]
    if n > 12:
        angles += [0, round(0.5 * (low + high)), -round(0.5 * (low + high))]
    cells = [(angle, power) for angle in angles for power in powers]
    rng.shuffle(cells)
    full, least = powers[-1], powers[0]
    must = [(0, full), (0, least), (high, full), (-high, full), (low, least), (-low, least)]
    rows = (must + [cell for cell in cells if tuple(cell) not in must])[:n]
    while len(rows) < n:
        rows.append(rows[rng.integers(len(rows))])
    return rows


def _draw_heads(rng: np.random.Generator, robot: Robot, *, vary: bool) -> Array:
    """Head length of each trial, m."""
    n = robot.trials
    long_head = round(robot.head_length * rng.choice([1.25, 1.5]), 3)
    short_head = round(robot.head_length * 0.75, 3)
    heads = np.full(n, robot.head_length)
    if vary:
        order = rng.permutation(n)
        heads[order[: int(np.ceil(n * 0.35))]] = long_head
        if n >= 15 and rng.random() < 0.5:
            heads[order[-int(n * 0.15) :]] = short_head
    return heads


def draw_plan(rng: np.random.Generator, robot: Robot, *, heads_vary: bool) -> Plan:
    """The trials in random order."""
    n = robot.trials
    rows = _draw_cells(rng, n)
    heads = _draw_heads(rng, robot, vary=heads_vary)
    order = rng.permutation(n)
    angle = np.array([rows[i][0] for i in order], float)
    power = np.array([rows[i][1] for i in order], float)
    flap = np.round(robot.top_flap * (power / 100) ** rng.uniform(0.85, 1.1), 3)
    session = np.arange(n) / max(n - 1, 1)
    wanted = np.where(angle == 0, rng.uniform(8, 16, n), rng.uniform(11, 24, n))
    trials = Trials(flap, angle * DEG, heads[order], np.zeros(n), session)
    return Plan(trials, power, angle, np.round(wanted, 1))
