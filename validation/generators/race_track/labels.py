"""Labels as a tracker writes them: slow errors, jitter, outliers, glare, gaps, likelihoods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .robots import Array

LABELS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
LABEL_FACTOR = np.array([1.0, 0.9, 1.0, 1.1, 1.6])
"""How the error of each label compares."""


@dataclass(frozen=True)
class Tracker:
    """Errors in pixels; memory: s; rates: share of points, gaps a second and label."""

    jitter: float
    slow: float
    memory: float
    outliers: float
    sure_outliers: float
    gaps: float
    glare: tuple[float, float, float]


def draw_tracker(rng: np.random.Generator, size: tuple[int, int]) -> Tracker:
    """A tracker; glare: centre and radius in the image (pixels)."""
    factor = rng.uniform(0.6, 1.6)
    x, y, radius = (
        rng.uniform(0, size[0]),
        rng.uniform(0, size[1]),
        rng.uniform(0.02, 0.06) * size[0],
    )
    return Tracker(
        jitter=float(0.35 * factor), slow=float(0.6 * factor), memory=float(rng.uniform(0.1, 0.5)),
        outliers=float(rng.uniform(0.001, 0.008)), sure_outliers=float(rng.uniform(0, 0.25)),
        gaps=float(rng.uniform(0, 0.12)), glare=(float(x), float(y), float(radius)),
    )  # fmt: skip


def point_noise(tracker: Tracker, scale: float) -> float:
    """Error of the smoothed centre (m): the slow part. scale: pixels by metre."""
    return tracker.slow / scale


def detected(
    rng: np.random.Generator, tracker: Tracker, pixels: Array, fps: float
) -> tuple[Array, Array]:
    """Detected pixels (frames, 5, 2), NaN where empty, and likelihoods (frames, 5)."""
    frames = len(pixels)
    dim = np.linalg.norm(pixels - np.array(tracker.glare[:2]), axis=-1) < tracker.glare[2]
    factor = (LABEL_FACTOR * np.where(dim, 2.5, 1.0))[..., None]
    keep = np.exp(-1 / (fps * tracker.memory))
    white = rng.normal(size=(frames + 100, 5, 2)) * np.sqrt(1 - keep**2)
    slow = lfilter([1.0], [1.0, -keep], white, axis=0)[100:]
    jitter = rng.standard_t(6, size=(frames, 5, 2)) * tracker.jitter
    seen = pixels + factor * (tracker.slow * slow + jitter)
    sure = 1 - rng.gamma(1.2, 0.012, (frames, 5)) * np.where(dim, 12, 1)
    seen, sure = _outliers(rng, tracker, seen, sure)
    return _gaps(rng, tracker, seen, sure, fps=fps)


def _outliers(
    rng: np.random.Generator, tracker: Tracker, seen: Array, sure: Array
) -> tuple[Array, Array]:
    """Single points that jump, most of them with a low likelihood."""
    hit = rng.random(sure.shape) < tracker.outliers
    jump = rng.normal(0, 45, seen.shape)
    sure = np.where(hit & (rng.random(sure.shape) > tracker.sure_outliers),
                    rng.uniform(0.02, 0.6, sure.shape), sure)  # fmt: skip
    return np.where(hit[..., None], seen + jump, seen), np.clip(sure, 0.001, 1.0)


def _gaps(
    rng: np.random.Generator, tracker: Tracker, seen: Array, sure: Array, *, fps: float
) -> tuple[Array, Array]:
    """Labels hidden for 0.1 to 0.5 s, empty or guessed with a likelihood below 0.1."""
    frames = len(seen)
    for label in range(5):
        for _ in range(rng.poisson(tracker.gaps * frames / fps)):
            first = int(rng.integers(5, max(6, frames - 5)))
            part = slice(first, first + int(rng.uniform(0.1, 0.5) * fps))
            sure[part, label] = rng.uniform(0.005, 0.08)
            seen[part, label] = np.nan if rng.random() < 0.6 else seen[part, label] + 12.0
    return seen, sure
