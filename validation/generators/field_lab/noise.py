"""What the tracker makes of exact pixels: errors, outliers, swaps, gaps, likelihoods."""

import math

import numpy as np
from scipy.signal import lfilter


def tracking_error(
    rng: np.random.Generator, n: int, noise: dict[str, float], light: float
) -> np.ndarray:
    """Errors (n, 5, 2) px: white plus first-order autoregressive, larger in poor light."""
    a = math.exp(-1 / (noise["fps"] * noise["track_tau_s"]))
    kick = rng.normal(size=(n, 5, 2)) * math.sqrt(1 - a * a)
    kick[0] /= math.sqrt(1 - a * a)
    slow = lfilter([1.0], [1.0, -a], kick, axis=0)
    return light * (noise["track_px"] * slow + noise["white_px"] * rng.normal(size=(n, 5, 2)))


def likelihoods(rng: np.random.Generator, error: np.ndarray, use: float) -> np.ndarray:
    """Likelihoods (n, 5), loosely falling with the error; ``use`` 0 to 1 is how informative."""
    miss = np.linalg.norm(error, axis=2)
    return np.clip(1 - rng.beta(0.6, 12, miss.shape) - 0.03 * use * np.minimum(miss, 6), 0.3, 1.0)


def add_outliers(rng: np.random.Generator, px: np.ndarray, lk: np.ndarray, share: float) -> None:
    """Move bursts of 1 to 4 frames of one keypoint by 10 to 60 px; four in five of low
    likelihood.
    """
    n = len(px)
    for _ in range(rng.poisson(share * n * 5 / 2)):
        i, part, run = rng.integers(n), rng.integers(5), rng.integers(1, 5)
        away = rng.uniform(10, 60) * np.exp(1j * rng.uniform(0, 2 * np.pi))
        px[i : i + run, part] += [away.real, away.imag]
        if rng.random() < 0.8:
            lk[i : i + run, part] = rng.uniform(0.02, 0.5)


def swap_head_and_tail(
    rng: np.random.Generator, px: np.ndarray, lk: np.ndarray, share: float
) -> None:
    """Exchange head tip and tail tip in single frames."""
    for i in np.flatnonzero(rng.random(len(px)) < share):
        px[i, [0, 4]] = px[i, [4, 0]]
        if rng.random() < 0.5:
            lk[i, [0, 4]] = rng.uniform(0.2, 0.7, 2)


def add_gaps(
    rng: np.random.Generator, px: np.ndarray, lk: np.ndarray, per_s: float, fps: float
) -> None:
    """Blank 1 to 10 frames of one keypoint or of all: empty cells or likelihood below 0.1."""
    n = len(px)
    for _ in range(rng.poisson(per_s * n / fps * 2)):
        i, run = rng.integers(n), rng.integers(1, 11)
        part = slice(None) if rng.random() < 0.3 else int(rng.integers(5))
        if rng.random() < 0.5:
            px[i : i + run, part], lk[i : i + run, part] = np.nan, np.nan
        else:
            lk[i : i + run, part] = rng.uniform(0, 0.09)


def repeat_frames(rng: np.random.Generator, px: np.ndarray, share: float) -> None:
    """Repeat the preceding frame's image in a few frames."""
    for i in np.flatnonzero(rng.random(len(px)) < share):
        if i:
            px[i] = px[i - 1]


def tracked_keypoints(
    rng: np.random.Generator, px: np.ndarray, noise: dict[str, float], light: float
) -> tuple[np.ndarray, np.ndarray]:
    """Tracked pixels (n, 5, 2) and likelihoods (n, 5) of exact pixels ``px``."""
    error = tracking_error(rng, len(px), noise, light)
    out, lk = px + error, likelihoods(rng, error, noise["likelihood_use"])
    repeat_frames(rng, out, noise["frozen_share"])
    swap_head_and_tail(rng, out, lk, noise["swap_share"])
    add_outliers(rng, out, lk, noise["outlier_share"])
    add_gaps(rng, out, lk, noise["gaps_per_s"], noise["fps"])
    return out, lk


def logged_shaft_angle(
    rng: np.random.Generator, angle_deg: np.ndarray, dead_zone: str
) -> list[float | None]:
    """Logged shaft angle (deg, wrapping at 360) with a dead zone at 342 to 360 degrees."""
    a = (angle_deg + rng.normal(0, 0.4, len(angle_deg))) % 360
    out: list[float | None] = []
    last = 0.0
    for v in a:
        if v < 342:
            last = round(float(v), 2)
            out.append(last)
        else:
            out.append({"hold": last, "zero": 0.0, "empty": None}[dead_zone])
    return out
