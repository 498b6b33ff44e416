"""Slowly moving water: a mean drift and random Fourier modes of a stream function."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .robots import GUST_KNOTS, ParallelTrials

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class WaterMotion:
    """Standard deviations per component, m/s, of drift and eddies; longest eddy, m."""

    drift: float
    eddies: float
    longest: float


def draw_water_motion(rng: np.random.Generator) -> WaterMotion:
    """Water that has rested some minutes since the last trial."""
    return WaterMotion(rng.uniform(2e-4, 8e-4), rng.uniform(4e-4, 1.6e-3), rng.uniform(0.6, 1.4))


def draw_fourier_modes(
    rng: np.random.Generator, sea: WaterMotion, count: int, modes: int = 10
) -> Array:
    """Modes of `count` fields, (6, modes, count): a_x, a_y (m/s), k_x, k_y (1/m), rad/s, phase.

    Each wave moves water along its crests, so that the field has no divergence (Kraichnan 1970,
    Phys. Fluids 13, 22). Frequencies are those of eddies that turn over at their own speed.
    """
    length = sea.longest * np.exp(rng.uniform(np.log(0.25), 0, (modes, count)))
    k = 2 * np.pi / length
    way = rng.uniform(0, 2 * np.pi, (modes, count))
    weight = (length / sea.longest) ** (1 / 3)
    a = 2 * sea.eddies * weight / np.sqrt(np.sum(weight**2, 0))
    omega = rng.normal(size=(modes, count)) * k * sea.eddies
    phase = rng.uniform(0, 2 * np.pi, (modes, count))
    return np.stack([-a * np.sin(way), a * np.cos(way), k * np.cos(way), k * np.sin(way),
                     omega, phase])  # fmt: skip


def with_water(rng: np.random.Generator, sea: WaterMotion, lanes: ParallelTrials) -> ParallelTrials:
    """The lanes, each with water of its own."""
    n = lanes.count
    mean = sea.drift * (rng.normal(size=n) + 1j * rng.normal(size=n))
    return replace(lanes, mean=mean, modes=draw_fourier_modes(rng, sea, n))


def eddy_velocity(modes: Array, x: Complex, t: Array | float) -> Complex:
    """Velocity of the eddies, m/s, complex, at places x (m, complex)."""
    a_x, a_y, k_x, k_y, omega, phase = modes
    wave = np.cos(k_x * x.real + k_y * x.imag - omega * t + phase)
    return np.asarray((a_x * wave).sum(0) + 1j * (a_y * wave).sum(0))


def gust_velocity(knots: Complex, t: float) -> Complex:
    """Velocity between knots at 0, 1, 2 ... s, m/s, complex (lanes,)."""
    low = min(int(t), GUST_KNOTS - 2)
    return np.asarray(knots[low] + (t - low) * (knots[low + 1] - knots[low]))


def water_velocity(lanes: ParallelTrials, x: Complex, t: float) -> Complex:
    """Velocity of the water at the robots, m/s, complex; eddies drift with the mean flow."""
    return np.asarray(
        lanes.mean
        + eddy_velocity(lanes.modes, x - lanes.mean * t, t)
        + gust_velocity(lanes.gust, t)
    )


def gust_covariance(
    rng: np.random.Generator, sea: WaterMotion, path: Complex, times: Array
) -> Array:
    """Covariance of the gusts, (2 knots, 2 knots), m^2/s^2, real parts first, met on a path.

    path: places (n,), m, complex, at times (n,), s. From 300 fields, averaged around each knot.
    """
    count = 300
    modes = draw_fourier_modes(rng, sea, count)[..., None]
    a_x, a_y, k_x, k_y, omega, phase = modes
    wave = np.cos(k_x * path.real + k_y * path.imag - omega * times + phase)
    u, v = (a_x * wave).sum(0), (a_y * wave).sum(0)
    hats = np.clip(1 - np.abs(times[:, None] - np.arange(GUST_KNOTS)), 0, None)
    hats = hats / np.maximum(hats.sum(0), 1e-9)
    sample = np.concatenate([u @ hats, v @ hats], 1)
    drift = sea.drift**2 * np.kron(np.eye(2), np.ones((GUST_KNOTS, GUST_KNOTS)))
    floor = (0.1 * sea.eddies) ** 2 * np.eye(2 * GUST_KNOTS)
    return np.asarray(sample.T @ sample / count + drift + floor)
