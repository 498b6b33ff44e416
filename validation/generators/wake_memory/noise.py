"""Random parts of a study: water motion, tracking errors, gaps, outliers, shaft angle log."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]
KEYPOINT_NOISE_FACTORS = np.array(
    [1.15, 0.85, 0.75, 1.0, 1.6]
)  # head_tip, hinge, core_center, tail_base, tail_tip


@dataclass(frozen=True)
class Noise:
    """Standard deviations and correlation times; pixels, seconds, m/s, N m."""

    white_px: float
    tracking_px: float
    tracking_s: float
    bias_px: float
    outlier_rate: float
    gap_rate: float
    gust_m_s: float
    gust_nm: float
    gust_s: float
    servo_rad: float = np.radians(0.3)
    flap_ratio: float = 0.003


def draw_noise(rng: np.random.Generator) -> Noise:
    """Noise of one study."""
    return Noise(
        white_px=float(rng.uniform(0.2, 0.9)),
        tracking_px=float(rng.uniform(0.15, 0.6)),
        tracking_s=float(np.exp(rng.uniform(np.log(0.05), np.log(0.5)))),
        bias_px=float(rng.uniform(0.05, 0.28)),
        outlier_rate=float(rng.uniform(0.001, 0.006)),
        gap_rate=float(rng.uniform(0.001, 0.008)),
        gust_m_s=float(np.exp(rng.uniform(np.log(8e-4), np.log(3e-3)))),
        gust_nm=float(np.exp(rng.uniform(np.log(5e-5), np.log(3e-4)))),
        gust_s=float(rng.uniform(0.5, 2.5)),
    )


def ornstein_uhlenbeck(
    rng: np.random.Generator, shape: tuple[int, int], dt: float, tau: float
) -> Array:
    """Stationary unit-variance process (steps, channels) of correlation time tau (s)."""
    a = np.exp(-dt / tau)
    kicks = rng.normal(size=shape)
    kicks[1:] *= np.sqrt(1 - a * a)
    return lfilter([1.0], [1.0, -a], kicks, axis=0)


def water_motion(rng: np.random.Generator, noise: Noise, frames: int, fps: float) -> Array:
    """Water velocity (m/s, 2) and disturbing moment (N m) at every frame, (frames, 3)."""
    scale = np.array([noise.gust_m_s, noise.gust_m_s, noise.gust_nm])
    return ornstein_uhlenbeck(rng, (frames, 3), 1 / fps, noise.gust_s) * scale


def tracked_keypoints(
    rng: np.random.Generator, noise: Noise, pixels: Array, heading: Array, fps: float
) -> tuple[Array, Array]:
    """Detections (frames, 5, 2) and likelihoods (frames, 5) of exact pixels.

    The detector's bias turns with the heading; outliers mostly show a low likelihood.
    """
    n = len(pixels)
    level = np.repeat(KEYPOINT_NOISE_FACTORS, 2)
    error = noise.white_px * rng.normal(size=(n, 10)) * level
    error += noise.tracking_px * ornstein_uhlenbeck(rng, (n, 10), 1 / fps, noise.tracking_s) * level
    phase = np.arange(10) * 1.7
    error += noise.bias_px * np.sin((1 + np.arange(10) % 2) * heading[:, None] + phase)
    seen = pixels + error.reshape(n, 5, 2)
    likelihood = 1 - rng.beta(1.2, 40, size=(n, 5))
    wild = rng.random((n, 5)) < noise.outlier_rate
    seen[wild] += rng.normal(0, 40, size=(int(wild.sum()), 2))
    quiet = wild & (rng.random((n, 5)) < 0.8)
    likelihood[quiet] = rng.uniform(0.1, 0.6, int(quiet.sum()))
    return with_gaps(rng, noise.gap_rate, seen, likelihood)


def with_gaps(
    rng: np.random.Generator, rate: float, seen: Array, likelihood: Array
) -> tuple[Array, Array]:
    """Detections with runs of 1 to 10 unseen frames, as NaN or as a likelihood below 0.1."""
    as_nan = rng.random() < 0.5
    for frame, part in np.argwhere(rng.random(likelihood.shape) < rate):
        hole = slice(frame, frame + int(rng.integers(1, 11)))
        if as_nan:
            seen[hole, part], likelihood[hole, part] = np.nan, np.nan
        else:
            seen[hole, part] += rng.normal(0, 60, size=seen[hole, part].shape)
            likelihood[hole, part] = rng.uniform(0, 0.08)
    return seen, likelihood


def shaft_log(
    rng: np.random.Generator, times: Array, cycles: Array, fill: str, dead_deg: float
) -> Array:
    """Motor log (samples, 2): time (s) and angle (deg), wrapping, every 5 ms.

    The potentiometer is dead over the last `dead_deg` of a turn: it holds, reads 0, or is empty.
    """
    t = np.arange(0.0, times[-1], 0.005)
    turn = rng.random()
    angle = 360 * ((np.interp(t, times, cycles) + turn) % 1.0)
    angle = np.clip(angle + rng.normal(0, 0.25, len(t)), 0, 359.99)
    dead = angle > 360 - dead_deg
    if fill == "zero":
        angle[dead] = 0.0
    elif fill == "empty":
        angle[dead] = np.nan
    else:
        held = np.maximum.accumulate(np.where(dead, 0, np.arange(len(t))))
        angle = angle[held]
    return np.column_stack([t, angle])
