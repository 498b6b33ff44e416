"""Stability of straight swimming, and fins that give it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import fin_laws
from .form import Lanes
from .motion import rates
from .robots import Fin, Robot


def growth_rate(robot: Robot, flap: float = 4.0) -> float:
    """Largest real part of the eigenvalues of straight swimming in (v, r), 1/s."""
    c = robot.coefficients
    speed = flap * np.sqrt(c.C_T / c.C_D0)
    one = np.ones(1)
    lane = Lanes(0 * one, flap * one, robot.head_length * one, 0 * one, one, (9.0, 9.0))
    size = 1e-5
    matrix = np.zeros((2, 2))
    for column, row in enumerate((4, 5)):
        ends = []
        for step in (-size, size):
            state = np.zeros((8, 1))
            state[3] = speed
            state[row] += step
            ends.append(rates(state, 0 * one, lane, robot, ()))
        matrix[:, column] = (ends[1] - ends[0])[[4, 5], 0] / (2 * size)
    matrix[0, 1] -= speed  # v_dot = y_acceleration - U r in core axes
    return float(np.linalg.eigvals(matrix).real.max())


def with_fin(rng: np.random.Generator, robot: Robot) -> Robot:
    """The robot with a fin of 1.1 to 3 times the least area for stable straight swimming."""
    law = str(rng.choice(list(fin_laws.LAWS)))
    arm = round(robot.body_length * float(rng.uniform(0.35, 0.5)), 4)
    onset = round(float(rng.uniform(0.35, 0.7)), 3)

    def made(area: float) -> Robot:
        return replace(robot, fin=Fin(law, area, arm, onset))

    low, high = 1e-4, 0.2
    for _ in range(24):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if growth_rate(made(middle)) > 1e-3 else (low, middle)
    return made(float(f"{high * np.exp(rng.uniform(np.log(1.1), np.log(3.0))):.4g}"))
