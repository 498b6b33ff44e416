"""Random water motion, tracking errors, gaps and the motor's potentiometer.

Water motion is the Ornstein-Uhlenbeck equation da = -a dt/tau + sigma sqrt(2/tau) dW for the
accelerations of the robot; tracking errors are Matern-3/2 processes (Hartikainen & Sarkka 2010).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np


@dataclass(frozen=True)
class Noise:
    """Levels of all random errors of one study."""

    gust_m_s2: float
    gust_rad_s2: float
    gust_tau_s: float
    white_px: float
    matern_px: float
    matern_tau_s: float
    outlier_rate: float
    gap_rate_hz: float
    servo_rad: float
    frequency: float
    recoil_rad: float
    recoil_m: float
    label_m: float

    def as_dict(self) -> dict:
        """Plain dictionary for the truth file."""
        return asdict(self)


def draw_noise(rng: np.random.Generator) -> Noise:
    """Levels of one study."""
    return Noise(
        gust_m_s2=rng.uniform(0.0015, 0.006),
        gust_rad_s2=rng.uniform(0.012, 0.045),
        gust_tau_s=rng.uniform(0.3, 1.0),
        white_px=rng.uniform(0.2, 1.0),
        matern_px=rng.uniform(0.2, 0.8),
        matern_tau_s=rng.uniform(0.05, 0.3),
        outlier_rate=rng.uniform(0.001, 0.006),
        gap_rate_hz=rng.uniform(0.02, 0.12),
        servo_rad=np.radians(rng.uniform(0.2, 0.4)),
        frequency=rng.uniform(0.002, 0.004),
        recoil_rad=np.radians(rng.uniform(0.8, 2.2)),
        recoil_m=rng.uniform(0.0008, 0.003),
        label_m=rng.uniform(0.0002, 0.0006),
    )


def water_accelerations(
    rng: np.random.Generator, noise: Noise, trials: int, seconds: float
) -> np.ndarray:
    """Exact samples (times, 3, trials) at 40 per second of the three coloured accelerations."""
    steps = int(seconds * 40) + 10
    rho = np.exp(-1 / 40 / noise.gust_tau_s)
    white = rng.normal(size=(steps, 3, trials))
    out = white.copy()
    for k in range(1, steps):
        out[k] = rho * out[k - 1] + np.sqrt(1 - rho**2) * white[k]
    return out * np.array([noise.gust_m_s2, noise.gust_m_s2, noise.gust_rad_s2])[None, :, None]


def matern_process(
    rng: np.random.Generator, frames: int, dt: float, tau: float, shape: tuple
) -> np.ndarray:
    """Unit Matern-3/2 process (frames, *shape) with kernel (1 + t/l) exp(-t/l), l = tau / 2."""
    lam = 2 / tau
    e = np.exp(-lam * dt)
    A = e * np.array([[1 + lam * dt, dt], [-(lam**2) * dt, 1 - lam * dt]])
    stationary = np.diag([1, lam**2])
    noise = np.linalg.cholesky(stationary - A @ stationary @ A.T + 1e-12 * stationary)
    draws = rng.normal(size=(frames, 2, int(np.prod(shape))))
    state, out = np.sqrt(stationary) @ draws[0], np.empty((frames, int(np.prod(shape))))
    for k in range(frames):
        out[k] = state[0]
        state = A @ state + noise @ draws[k]
    return out.reshape(frames, *shape)


def tracked_keypoints(
    rng: np.random.Generator, noise: Noise, pixels: np.ndarray, fps: float
) -> tuple[np.ndarray, np.ndarray]:
    """Detections of ``pixels`` (frames, parts, 2) and likelihoods (frames, parts), with faults."""
    frames, parts, _ = pixels.shape
    error = noise.matern_px * matern_process(rng, frames, 1 / fps, noise.matern_tau_s, (parts, 2))
    found = pixels + error + rng.normal(0, noise.white_px, pixels.shape)
    likelihood = 1 - rng.beta(1.2, 60, (frames, parts))
    wrong = rng.random((frames, parts)) < noise.outlier_rate
    found[wrong] += rng.normal(0, 40, (wrong.sum(), 2))
    fooled = rng.random((frames, parts)) < 0.1
    low = wrong & ~fooled
    likelihood[low] = rng.uniform(0.11, 0.5, low.sum())
    for part in range(parts):
        for start in np.flatnonzero(rng.random(frames) < noise.gap_rate_hz / fps):
            gap = slice(start, start + int(rng.integers(1, 11)))
            found[gap, part] = np.nan if rng.random() < 0.5 else found[gap, part]
            likelihood[gap, part] = np.nan if np.isnan(found[start, part, 0]) else 0.03
    return found, likelihood


def motor_log(rng: np.random.Generator, turns: np.ndarray, dead: tuple) -> np.ndarray:
    """Shaft angle (deg) at cumulative ``turns``; ``dead`` = (from deg, to deg, hold | zero |
    empty).
    """
    angle = (turns * 360 + rng.uniform(0, 360)) % 360
    inside = (angle >= dead[0]) & (angle < dead[1])
    measured = np.clip(angle + rng.normal(0, 0.4, len(angle)), 0, 359.99)
    if dead[2] == "hold":
        last = np.maximum.accumulate(np.where(inside, 0, np.arange(len(angle))))
        return measured[last]
    measured[inside] = 0.0 if dead[2] == "zero" else np.nan
    return measured
