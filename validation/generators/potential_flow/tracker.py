"""Errors of the keypoint tracker and of the potentiometer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class Tracker:
    """ARMA(1, 1) errors with Student's t innovations, outliers and gaps."""

    sigma: np.ndarray
    """(5,) standard deviation of each keypoint's error, px."""
    memory: float
    """Time constant of the autoregression, s."""
    average: float
    """Moving-average coefficient."""
    freedom: float
    """Degrees of freedom of the innovations."""
    outliers: float
    """Share of outliers."""
    gaps: float
    """Gaps a second and keypoint."""

    def arma(self, fps: float) -> tuple[float, float, np.ndarray]:
        """Coefficients a, b of n_t = a n_(t-1) + e_t + b e_(t-1), and the std of e, (5,) px."""
        a, b = float(np.exp(-1 / (fps * self.memory))), self.average
        gain = (1 + 2 * a * b + b * b) / (1 - a * a)
        return a, b, self.sigma / np.sqrt(gain)

    @property
    def sharpness(self) -> float:
        """Fisher information of location over that of a normal of the same variance."""
        v = self.freedom
        return (v + 1) * v / ((v + 3) * (v - 2))


def draw_tracker(rng: np.random.Generator) -> Tracker:
    """0.4 to 0.9 px, 40 to 150 ms, 0.2 to 1 % outliers, a gap every 10 to 50 s."""
    base = rng.uniform(0.4, 0.8) * np.array([1.0, 0.9, 0.8, 1.0, 1.3])
    return Tracker(
        sigma=base * rng.uniform(0.9, 1.1, 5),
        memory=rng.uniform(0.04, 0.15),
        average=rng.uniform(-0.2, 0.4),
        freedom=rng.uniform(4.5, 8.0),
        outliers=rng.uniform(0.002, 0.01),
        gaps=rng.uniform(0.02, 0.1),
    )


def correlated_errors(
    rng: np.random.Generator, tracker: Tracker, frames: int, fps: float
) -> np.ndarray:
    """(frames, 5, 2) errors without outliers, px; 3 s before the first frame are dropped."""
    a, b, scale = tracker.arma(fps)
    before = int(3 * fps)
    v = tracker.freedom
    e = rng.standard_t(v, (frames + before, 5, 2)) * np.sqrt((v - 2) / v) * scale[:, None]
    return lfilter([1, b], [1, -a], e, axis=0)[before:]


def tracked_keypoints(rng: np.random.Generator, tracker: Tracker, pixels, fps: float) -> np.ndarray:
    """(frames, 5, 3) detections: x, y (px) and likelihood; NaN with low likelihood where unseen."""
    frames = len(pixels)
    out = np.empty((frames, 5, 3))
    out[..., :2] = pixels + correlated_errors(rng, tracker, frames, fps)
    out[..., 2] = 1 - np.minimum(rng.exponential(0.015, (frames, 5)), 0.35)
    wild = rng.random((frames, 5)) < tracker.outliers
    far = rng.uniform(8, 60, wild.sum()) * np.exp(2j * np.pi * rng.random(wild.sum()))
    out[wild, 0] += far.real
    out[wild, 1] += far.imag
    out[wild, 2] = rng.uniform(0.3, 0.97, wild.sum())
    for point in range(5):
        for _ in range(rng.poisson(tracker.gaps * frames / fps)):
            first = rng.integers(frames)
            _add_gap(rng, out[first : first + int(rng.geometric(0.12)), point])
    return out


def _add_gap(rng: np.random.Generator, part) -> None:
    """One gap: half of the gaps have no position, half a wrong one; likelihood below 0.09."""
    part[:, 2] = rng.uniform(0.0, 0.09, len(part))
    if rng.random() < 0.5:
        part[:, :2] = np.nan
    else:
        part[:, :2] += rng.normal(0, 25, (len(part), 2))


@dataclass(frozen=True)
class Potentiometer:
    """Noise (deg), zero (deg), dead zone (first angle and width, deg) and what it logs there."""

    noise: float
    zero: float
    dead: tuple[float, float]
    fill: str


def draw_potentiometer(rng: np.random.Generator) -> Potentiometer:
    """1 to 2 deg of noise, a dead zone of 8 to 25 deg that holds, reads 0 or is empty."""
    return Potentiometer(rng.uniform(1.0, 2.0), rng.uniform(0, 360),
                         (rng.uniform(0, 330), rng.uniform(8, 25)),
                         str(rng.choice(["hold", "zero", "empty"])))  # fmt: skip


def shaft_log(rng: np.random.Generator, sensor: Potentiometer, phase) -> list[str]:
    """Cells of the log for shaft angles `phase` (rad), wrapped at 360 degrees."""
    true = (np.rad2deg(phase) + sensor.zero) % 360
    read = (true + sensor.noise * rng.normal(size=len(true))) % 360
    inside = (true - sensor.dead[0]) % 360 < sensor.dead[1]
    cells, last = [], "0.00"
    for value, dead in zip(read, inside, strict=True):
        if dead:
            cells.append({"hold": last, "zero": "0.00", "empty": ""}[sensor.fill])
        else:
            last = f"{value:.2f}"
            cells.append(last)
    return cells
