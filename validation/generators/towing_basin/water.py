"""Random accelerations of a robot in calm water: Ornstein-Uhlenbeck processes in core axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .form import Array
from .motion import STEP_S


@dataclass(frozen=True)
class RandomAccelerations:
    """linear: m/s^2 along and across. turning: rad/s^2. memory: s. release: m/s and rad/s of the
    motion at release.
    """

    linear: float
    turning: float
    memory: float
    release: tuple[float, float] = (5e-4, 2e-3)

    @property
    def deviations(self) -> Array:
        """Standard deviations of surge, sway and yaw acceleration."""
        return np.array([self.linear, self.linear, self.turning])


def draw_accelerations(
    rng: np.random.Generator, unrest: RandomAccelerations, steps: int, trials: int
) -> Array:
    """Accelerations (steps, 3, trials) for each step of the integration."""
    fade = np.exp(-STEP_S / unrest.memory)
    scale = unrest.deviations[:, None]
    now = scale * rng.normal(size=(3, trials))
    pushes = np.empty((steps, 3, trials))
    for j in range(steps):
        pushes[j] = now
        now = fade * now + scale * np.sqrt(1 - fade**2) * rng.normal(size=(3, trials))
    return pushes


def draw_release(rng: np.random.Generator, unrest: RandomAccelerations, trials: int) -> Array:
    """Velocities and yaw rate at release (3, trials)."""
    speed, turning = unrest.release
    return rng.normal(size=(3, trials)) * np.array([[speed], [speed], [turning]])
