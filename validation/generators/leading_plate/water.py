"""Slightly moving water: drifting sinusoidal swirls without divergence, and a random torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .robots import Array, Robot

MODES = 7


@dataclass(frozen=True)
class Unrest:
    """Root mean squares of the water's speed (m/s, both axes) and of a torque (N m); memory (s)."""

    speed: float
    torque: float
    memory: float


def draw_unrest(rng: np.random.Generator, robot: Robot) -> Unrest:
    """Water that moves by some tenths of a per cent of the swimming speed."""
    return Unrest(float(rng.uniform(0.002, 0.006) * robot.speed),
                  float(rng.uniform(0.002, 0.006) * robot.drag * robot.body_length),
                  float(rng.uniform(0.4, 1.5)))  # fmt: skip


def draw_swirl(rng: np.random.Generator, unrest: Unrest, robot: Robot, count: int) -> Array:
    """Modes (7, MODES, columns): velocity (2), wave vector (2), frequency (rad/s), phase, 1."""
    shape = (MODES, count)
    length = rng.uniform(2.0, 8.0, shape) * robot.body_length
    angle = rng.uniform(0, 2 * np.pi, shape)
    size = unrest.speed * np.sqrt(2 / MODES) * rng.rayleigh(np.sqrt(0.5), shape)
    wave = 2 * np.pi / length
    return np.stack([
        -size * np.sin(angle), size * np.cos(angle), wave * np.cos(angle), wave * np.sin(angle),
        _frequencies(rng, unrest.memory, shape), rng.uniform(0, 2 * np.pi, shape), np.ones(shape),
    ])  # fmt: skip


def draw_jolts(rng: np.random.Generator, unrest: Unrest, count: int) -> Array:
    """Modes (3, MODES, columns) of a torque: size, frequency (rad/s), phase."""
    shape = (MODES, count)
    size = unrest.torque * np.sqrt(2 / MODES) * rng.rayleigh(np.sqrt(0.5), shape)
    return np.stack([size, _frequencies(rng, unrest.memory, shape),
                     rng.uniform(0, 2 * np.pi, shape)])  # fmt: skip


def _frequencies(rng: np.random.Generator, memory: float, shape: tuple[int, int]) -> Array:
    """Drawn from the spectrum of an exponentially decaying correlation, without its far tail."""
    return np.tan(rng.uniform(-0.45, 0.45, shape) * np.pi) / memory


def swirl(modes: Array, time: Array, place: Array) -> Array:
    """Velocity of the water as complex numbers."""
    along, across, wave_x, wave_y, frequency, phase, _ = modes
    wave = np.cos(wave_x * place.real + wave_y * place.imag + frequency * time + phase)
    return (along * wave).sum(axis=0) + 1j * (across * wave).sum(axis=0)


def jolt(modes: Array, time: Array) -> Array:
    """Torque (N m)."""
    size, frequency, phase = modes
    return (size * np.cos(frequency * time + phase)).sum(axis=0)
