"""Weak eddies left in the pool: random plane waves of the stream function that drift slowly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .robots import Array

MODES = 7


@dataclass(frozen=True)
class Eddies:
    """Modes (modes, columns): wave numbers (1/m), phase (rad), rate (rad/s), speed (m/s)."""

    number_x: Array
    number_y: Array
    phase: Array
    rate: Array
    speed: Array

    def __call__(self, time: Array, x: Array, y: Array) -> tuple[Array, Array]:
        """Velocity of the water (m/s); free of divergence, as each mode moves along its crests."""
        swing = self.speed * np.sin(
            self.number_x * x + self.number_y * y + self.phase - self.rate * time
        )
        number = np.hypot(self.number_x, self.number_y)
        along_x = -(swing * self.number_y / number).sum(axis=0)
        return along_x, (swing * self.number_x / number).sum(axis=0)


def draw_eddies(rng: np.random.Generator, columns: int, length: float, level: float) -> Eddies:
    """Eddies of 1 to 5 body lengths `length` (m) with a root mean square speed `level` (m/s)."""
    shape = (MODES, columns)
    wave = length * np.exp(rng.uniform(np.log(1.0), np.log(5.0), shape))
    angle = rng.uniform(0, 2 * np.pi, shape)
    share = rng.exponential(1.0, shape)
    speed = level * np.sqrt(2 * share / share.sum(axis=0))
    rate = rng.normal(0, 1, shape) * 2 * np.pi * level * 2 / wave
    number = 2 * np.pi / wave
    return Eddies(number * np.cos(angle), number * np.sin(angle),
                  rng.uniform(0, 2 * np.pi, shape), rate, speed)  # fmt: skip
