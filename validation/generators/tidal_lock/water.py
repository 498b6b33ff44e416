"""Water that is not perfectly still: drifting, seiching, or swirling from the last trial."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .dynamics import TIME_STEP
from .robot import GRAVITY, Robot


@dataclass(frozen=True)
class Ambient:
    """Kind, rms speed (m/s), correlation time (s) and velocity(t, x, y, trial)."""

    kind: str
    speed: float
    correlation: float
    velocity: Callable[..., np.ndarray]


def first_order_autoregression(increments: np.ndarray, keep: float) -> np.ndarray:
    """Stationary series (steps, ...) with the variance of the independent `increments`, of which
    the share `keep` stays from one step to the next.
    """
    series = increments.copy()
    for k in range(1, len(series)):
        series[k] = keep * series[k - 1] + np.sqrt(1 - keep**2) * increments[k]
    return series


def _drifting(rng, _robot: Robot, trials: int, speed: float) -> tuple[float, Callable]:
    """Ornstein-Uhlenbeck velocity, the same everywhere in the pool."""
    tau = rng.uniform(2, 6)
    keep = np.exp(-TIME_STEP / tau)
    steps = 1100
    increments = rng.standard_normal((steps, trials, 2)) @ np.array([1, 1j]) * speed / np.sqrt(2)
    table = first_order_autoregression(increments, keep)

    def velocity(t, _x, _y, trial):
        k = np.clip(np.asarray(t) / TIME_STEP, 0, steps - 2)
        low = k.astype(int)
        return table[low, trial] * (1 - (k - low)) + table[low + 1, trial] * (k - low)

    return tau, velocity


def _seiche(rng, robot: Robot, trials: int, speed: float) -> tuple[float, Callable]:
    """First standing wave along the pool, Merian's period, random phase and height per trial."""
    length, _, depth = robot.pool
    omega = np.pi * np.sqrt(GRAVITY * depth) / length
    phase = rng.uniform(0, 2 * np.pi, trials)
    height = speed * np.abs(rng.normal(1.2, 0.4, trials))

    def velocity(t, x, _y, trial):
        along = np.sin(np.pi * np.clip(x / length, 0, 1))
        return height[trial] * along * np.cos(omega * t + phase[trial]) + 0j

    return 1.5 / omega, velocity


def _last_swirl(rng, robot: Robot, trials: int, speed: float) -> tuple[float, Callable]:
    """Gaussian vortex left by the trial before, decaying slowly; none before the first trial."""
    length, width, _ = robot.pool
    centre = length * rng.uniform(0.3, 0.7, trials) + 1j * width * rng.uniform(0.3, 0.7, trials)
    strength = speed * rng.normal(0, 1.8, trials)
    strength[0] = 0.0
    radius, decay = width * rng.uniform(0.15, 0.3), rng.uniform(8, 25)

    def velocity(t, x, y, trial):
        offset = (x + 1j * y - centre[trial]) / radius
        return 1j * strength[trial] * offset * np.exp(0.5 - 0.5 * np.abs(offset) ** 2 - t / decay)

    return 3.0, velocity


_KINDS = {"ornstein_uhlenbeck": _drifting, "seiche": _seiche, "last_swirl": _last_swirl}


def draw_ambient(rng: np.random.Generator, robot: Robot, trials: int) -> Ambient:
    """Water of a random kind, 0.3 to 1.2 % of the robot's speed."""
    kind = str(rng.choice(list(_KINDS)))
    speed = robot.speed_ref * rng.uniform(0.003, 0.012)
    correlation, velocity = _KINDS[kind](rng, robot, trials, speed)
    return Ambient(kind, speed, correlation, velocity)
