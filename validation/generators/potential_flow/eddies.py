"""Slow motion of the water: a drift and small eddies that differ from trial to trial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

EDDY_COUNT = 3
"""Eddies of a trial."""


@dataclass(frozen=True)
class WaterMotion:
    """Size (m/s) and shape of the water's own motion."""

    drift: float
    """Standard deviation of a trial's mean velocity on each axis, m/s."""
    eddy: float
    """Standard deviation of an eddy's two amplitudes, m/s."""
    waves: np.ndarray
    """(trials, MODES) complex wave vectors, rad/m."""
    rates: np.ndarray
    """(trials, MODES) rad/s."""


def draw_water_motion(rng: np.random.Generator, trials: int = 24) -> WaterMotion:
    """Drift of 0.5 to 1.5 mm/s; eddies of 0.3 to 1.2 m that pass within 10 s or more."""
    shape = (trials, EDDY_COUNT)
    length = rng.uniform(0.3, 1.2, shape)
    waves = 2 * np.pi / length * np.exp(1j * rng.uniform(0, 2 * np.pi, shape))
    rates = rng.uniform(-0.6, 0.6, shape)
    return WaterMotion(rng.uniform(0.5e-3, 1.5e-3), rng.uniform(0.3e-3, 1e-3), waves, rates)


def water_velocity(water: WaterMotion, lanes, place: np.ndarray, time: float) -> np.ndarray:
    """(n,) complex velocity of the water in pool axes, m/s.

    Sum of i k/|k| (a cos s + b sin s), s = k . x + omega t: no divergence.
    """
    total = lanes.drift[0] + 1j * lanes.drift[1]
    for m in range(EDDY_COUNT):
        wave, rate = water.waves[lanes.trial, m], water.rates[lanes.trial, m]
        s = (np.conj(wave) * place).real + rate * time
        size = lanes.eddies[m, 0] * np.cos(s) + lanes.eddies[m, 1] * np.sin(s)
        total = total + 1j * wave / np.abs(wave) * size
    return total
