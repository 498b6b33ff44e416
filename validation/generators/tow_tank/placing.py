"""Start of each trial, so that the robot stays in the pool as long as it can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .robots import Array, ParallelTrials

WALL_MARGIN_M = 0.24
"""Least distance of the centre of mass from a wall, m."""


def draw_start_poses(
    rng: np.random.Generator, lanes: ParallelTrials, paths: Array, pool: tuple[float, float, float]
) -> ParallelTrials:
    """Lanes with new starts. paths: complex (times, lanes), m."""
    start, heading = lanes.start.copy(), lanes.heading.copy()
    for k in range(paths.shape[1]):
        path = (paths[:, k] - paths[0, k]) * np.exp(-1j * lanes.heading[k])
        start[k], heading[k] = _fit_in_pool(rng, path, pool)
    return replace(lanes, start=start, heading=heading)


def _fit_in_pool(
    rng: np.random.Generator, path: Array, pool: tuple[float, float, float]
) -> tuple[complex, float]:
    angles = rng.uniform(0, 2 * np.pi) + np.linspace(0, 2 * np.pi, 40, endpoint=False)
    turned = path[::6, None] * np.exp(1j * angles)
    low = np.minimum.accumulate(turned.real), np.minimum.accumulate(turned.imag)
    high = np.maximum.accumulate(turned.real), np.maximum.accumulate(turned.imag)
    room = pool[0] - 2 * WALL_MARGIN_M - 0.03, pool[1] - 2 * WALL_MARGIN_M - 0.03
    fits = (high[0] - low[0] < room[0]) & (high[1] - low[1] < room[1])
    lasting = fits.sum(0)
    best = int(rng.choice(np.flatnonzero(lasting >= lasting.max() - 1)))
    end = max(lasting[best] - 1, 0)
    free = [max(r - float(h[end, best] - w[end, best]), 0) for r, h, w in zip(room, high, low)]  # noqa: B905
    x, y = (
        WALL_MARGIN_M + 0.015 + rng.uniform(0, f) - float(w[end, best])
        for f, w in zip(free, low, strict=True)
    )
    angle = float(angles[best])
    return complex(x, y), angle


def frames_inside_pool(paths: Array, pool: tuple[float, float, float]) -> Array:
    """Number of frames before each lane comes too near to a wall."""
    x, y = paths.real, paths.imag
    out = (
        (np.minimum(x, y) < WALL_MARGIN_M)
        | (x > pool[0] - WALL_MARGIN_M)
        | (y > pool[1] - WALL_MARGIN_M)
    )
    return np.where(out.any(0), out.argmax(0), len(paths))
