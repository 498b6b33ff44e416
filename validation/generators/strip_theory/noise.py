"""Tracking errors: ARMA and white noise, outliers, gaps, likelihood; shaft angle log."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Noise:
    """Levels of one study."""

    white_px: float
    correlated_px: float
    correlation_s: float
    outlier_share: float
    gap_share: float
    water_rms_m_s: float
    recoil_heading_rad: float
    recoil_sway_m: float
    tail_wag_m: float


def draw_noise(rng: np.random.Generator) -> Noise:
    """Draw the levels of one study."""
    return Noise(
        white_px=float(np.exp(rng.uniform(np.log(0.2), np.log(1.5)))),
        correlated_px=float(rng.uniform(0.2, 0.9)),
        correlation_s=float(np.exp(rng.uniform(np.log(0.05), np.log(0.5)))),
        outlier_share=float(rng.uniform(0.001, 0.008)),
        gap_share=float(rng.uniform(0.002, 0.01)),
        water_rms_m_s=float(rng.uniform(2e-4, 1.2e-3)),
        recoil_heading_rad=float(np.radians(rng.uniform(0.8, 3.0))),
        recoil_sway_m=float(rng.uniform(0.5e-3, 2.5e-3)),
        tail_wag_m=float(rng.uniform(0.008, 0.022)),
    )


def arma_noise(rng: np.random.Generator, shape: tuple[int, ...], dt: float, tau: float) -> Floats:
    """Unit-variance ARMA(2, 1) noise along axis 0: two real poles exp(-dt/tau), exp(-3 dt/tau)."""
    p, q = np.exp(-dt / tau), np.exp(-3.0 * dt / tau)
    a, b = [1.0, -(p + q), p * q], [1.0, 0.3]
    impulse = lfilter(b, a, np.eye(1, 4000)[0])
    burn = int(8 * tau / dt) + 10
    white = rng.normal(size=(shape[0] + burn, *shape[1:]))
    return lfilter(b, a, white, axis=0)[burn:] / np.sqrt(np.sum(impulse**2))


def tracked_keypoints(
    pixels: Floats, fps: float, noise: Noise, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return detections `(frames, points, 2)` and likelihoods `(frames, points)`."""
    n, points, _ = pixels.shape
    tau = noise.correlation_s
    own = arma_noise(rng, (n, points, 2), 1 / fps, tau)
    common = arma_noise(rng, (n, 1, 2), 1 / fps, tau)
    out = pixels + noise.correlated_px * np.sqrt(0.5) * (own + common)
    out = out + rng.normal(0.0, noise.white_px, out.shape)
    likelihood = np.clip(1.0 - rng.gamma(1.2, 0.012, (n, points)), 0.6, 1.0)
    wrong = rng.random((n, points)) < noise.outlier_share
    angle = rng.uniform(0, 2 * np.pi, wrong.sum())
    jump = rng.uniform(8, 80, wrong.sum())[:, None]
    out[wrong] += jump * np.column_stack([np.cos(angle), np.sin(angle)])
    doubtful = rng.random(wrong.sum()) < 0.8
    likelihood[wrong] = np.where(doubtful, rng.uniform(0.01, 0.6, wrong.sum()), 0.95)
    for frame, point in np.argwhere(rng.random((n, points)) < noise.gap_share):
        gap = slice(frame, frame + int(rng.integers(1, 11)))
        if rng.random() < 0.5:
            out[gap, point] = np.nan
        likelihood[gap, point] = rng.uniform(0.0, 0.08)
    return out, likelihood


def shaft_log(
    freq: Floats, dt: float, dead_zone: tuple[float, str], rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return times (s, 5 ms) and shaft angle (deg) of a potentiometer from f(t) sampled every `dt`.

    The dead zone (deg, how it is filled: hold, zero or empty) sits at the wrap; 10-bit steps.
    """
    turns = np.concatenate([[0.0], np.cumsum(0.5 * dt * (freq[1:] + freq[:-1]))])
    t = np.arange(0.0, dt * (len(freq) - 1), 0.005)
    angle = 360.0 * (np.interp(t, dt * np.arange(len(freq)), turns) + rng.random()) % 360.0
    width, filling = dead_zone
    dead = angle > 360.0 - width
    read = np.round((angle + rng.normal(0, 0.3, len(t))) % 360.0 * 1023 / 360) * 360 / 1023
    last = np.maximum.accumulate(np.where(dead, -1, np.arange(len(t))))
    held = np.where(last >= 0, read[np.maximum(last, 0)], 0.0)
    fill = {"hold": held, "zero": np.zeros(len(t)), "empty": np.full(len(t), np.nan)}[filling]
    return t, np.where(dead, fill, read)
