"""Errors of a keypoint tracker: Gaussian processes, outliers, gaps and swapped labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tracker:
    """Standard deviations of slow and white errors, px; memory of the slow, s; rates a frame."""

    slow: float
    white: float
    memory: float
    outliers: float
    gaps: float
    swaps: float


def draw_tracker(rng: np.random.Generator) -> Tracker:
    """A network that was trained on some hundred frames."""
    return Tracker(
        rng.uniform(0.25, 0.7),
        rng.uniform(0.15, 0.4),
        rng.uniform(0.05, 0.15),
        rng.uniform(0.002, 0.01),
        rng.uniform(0.001, 0.003),
        rng.uniform(2e-4, 1e-3),
    )


def error_covariance(tracker: Tracker, times: Array, share: float = 1.0) -> Array:
    """Covariance (times, times), px^2: Matern 3/2 and `share` of the white variance.

    (1 + sqrt3 d/l) exp(-sqrt3 d/l) (Rasmussen and Williams 2006, eq. 4.17).
    """
    lag = np.sqrt(3) * np.abs(times[:, None] - times) / tracker.memory
    slow = tracker.slow**2 * (1 + lag) * np.exp(-lag)
    return np.asarray(slow + share * tracker.white**2 * np.eye(len(times)))


def correlated_errors(
    rng: np.random.Generator, tracker: Tracker, times: Array, columns: int
) -> Array:
    """Errors, px, (times, columns), of independent keypoint coordinates."""
    root = np.linalg.cholesky(error_covariance(tracker, times))
    return np.asarray(root @ rng.normal(size=(len(times), columns)))


def detections(rng: np.random.Generator, tracker: Tracker, px: Array, noise: Array) -> Array:
    """u, v and likelihood (frames, 5, 3) of points px (frames, 5, 2) with noise as px."""
    frames, points = px.shape[:2]
    found = np.concatenate([px + noise, 1 - rng.beta(1, 40, (frames, points, 1))], -1)
    wild = rng.random((frames, points)) < tracker.outliers
    count = int(wild.sum())
    found[wild, :2] += rng.normal(size=(count, 2)) * rng.choice([6, 15, 40], (count, 1))
    found[wild, 2] = np.where(rng.random(count) < 0.7, rng.uniform(0.1, 0.7, count), 0.95)
    _swap_labels(rng, tracker, found)
    _add_gaps(rng, tracker, found)
    return found


def _swap_labels(rng: np.random.Generator, tracker: Tracker, found: Array) -> None:
    """Head and tail, or hinge and centre, exchanged for one to three frames."""
    for first in np.flatnonzero(rng.random(len(found)) < tracker.swaps):
        a, b = ((0, 4), (1, 2))[rng.integers(2)]
        run = slice(first, first + int(rng.integers(1, 4)))
        found[run, a, :2], found[run, b, :2] = found[run, b, :2].copy(), found[run, a, :2].copy()
        found[run, a, 2], found[run, b, 2] = rng.uniform(0.02, 0.3, 2)


def _add_gaps(rng: np.random.Generator, tracker: Tracker, found: Array) -> None:
    """Gaps of 2 to 12 frames: likelihood below 0.1, the place wandering off or empty."""
    for first, point in np.argwhere(rng.random(found.shape[:2]) < tracker.gaps / 3):
        run = slice(first, first + int(rng.integers(2, 13)))
        size = len(found[run])
        found[run, point, :2] += np.cumsum(rng.normal(0, 2, (size, 2)), 0)
        found[run, point, 2] = rng.uniform(0, 0.09, size)
        if rng.random() < 0.3:
            found[run, point] = np.nan
