"""Tracking errors, random water motion, tail-beat recoil, motor logs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from validation.generators.manoeuvring.dynamics import POOL, Array

OCTAVES_S = np.array([0.06, 0.17, 0.5])  # correlation times whose sum has a 1/f spectrum


@dataclass(frozen=True)
class Noise:
    """Levels of one study: white and 1/f errors (px), rates a frame, water (m/s), recoil."""

    white_px: float
    coloured_px: float
    outlier_rate: float
    gap_rate: float
    water_m_s: float
    recoil_deg: float
    recoil_m: float
    servo_deg: float
    flap_pct: float


def draw_noise(rng: np.random.Generator) -> Noise:
    """Levels drawn over the ranges of the brief."""
    u = rng.uniform
    return Noise(
        white_px=float(np.exp(u(np.log(0.2), np.log(1.5)))),
        coloured_px=float(u(0.1, 0.35)),
        outlier_rate=float(u(0.0005, 0.004)),
        gap_rate=float(u(0.0, 0.004)),
        water_m_s=float(np.exp(u(np.log(0.0004), np.log(0.0016)))),
        recoil_deg=float(u(0.4, 2.5)),
        recoil_m=float(u(0.0005, 0.003)),
        servo_deg=float(u(0.2, 0.4)),
        flap_pct=float(u(0.2, 0.4)),
    )


def pink_noise(rng: np.random.Generator, frames: int, dt: float, shape: tuple[int, ...]) -> Array:
    """Unit-variance noise (frames, *shape) with spectrum near 1/f between 0.3 and 3 Hz.

    Sum of three first-order Gauss-Markov processes an octave and a half apart (van der Ziel 1950).
    """
    total = np.zeros((frames, *shape))
    for tau in OCTAVES_S:
        a = np.exp(-dt / tau)
        w = rng.standard_normal((frames, *shape)) * np.sqrt(1 - a * a)
        w[0] /= np.sqrt(1 - a * a)
        total += lfilter([1.0], [1.0, -a], w, axis=0)
    return total / np.sqrt(len(OCTAVES_S))


def draw_vortices(rng: np.random.Generator, n: int, level: float) -> Array:
    """Four drifting vortices a trial, (5, 4, n), of about `level` m/s where the robot swims."""
    v = np.empty((5, 4, n))
    v[0], v[1] = rng.uniform(0.2, POOL[0] - 0.2, (4, n)), rng.uniform(0.15, POOL[1] - 0.15, (4, n))
    v[2] = rng.standard_normal((4, n)) * level * 2.8  # two pi times the mean of d / (d^2 + a^2)
    v[3:] = rng.normal(0, 0.02, (2, 4, n))
    return v


def keypoint_positions(
    robot: object, head: float, tracks: Array, phase: Array, noise: Noise
) -> Array:
    """Keypoints (frames, 5, 2) in m: head_tip, hinge, core_center, tail_base, tail_tip.

    tracks (4, frames): x, y, psi, phi of C; recoil moves the whole body at the tail beat.
    """
    x, y, psi, phi = tracks
    beat = (phase > 0) * 1.0
    psi = psi + beat * np.radians(noise.recoil_deg) * np.sin(phase + 0.7)
    core = np.exp(1j * (psi + phi))
    C = x + 1j * y + beat * 1j * core * noise.recoil_m * np.sin(phase)
    hinge = C + robot.hinge_to_com * core
    base = C - robot.aft * core
    tip = base - robot.tail_length * core * np.exp(1j * beat * 0.25 * np.sin(phase - 1.0))
    z = np.stack([hinge + head * np.exp(1j * psi), hinge, C, base, tip], axis=1)
    return np.stack([z.real, z.imag], axis=-1)


def tracked_keypoints(
    rng: np.random.Generator, px: Array, fps: float, noise: Noise
) -> tuple[Array, Array]:
    """Detections (frames, 5, 2) px and likelihoods (frames, 5) of true image points."""
    frames = len(px)
    out = px + noise.coloured_px * pink_noise(rng, frames, 1 / fps, px.shape[1:])
    out = out + noise.white_px * rng.standard_normal(px.shape)
    like = 1 - 0.04 * rng.beta(1, 4, px.shape[:2])
    wild = rng.random(px.shape[:2]) < noise.outlier_rate
    out[wild] += rng.normal(0, 60, (wild.sum(), 2))
    like[wild] = np.where(rng.random(wild.sum()) < 0.85, rng.uniform(0.11, 0.5, wild.sum()), 0.95)
    for k, j in np.argwhere(rng.random(px.shape[:2]) < noise.gap_rate):
        gap = slice(k, k + int(rng.integers(1, 11)))
        if rng.random() < 0.5:
            out[gap, j] = np.nan
        else:
            out[gap, j] += rng.normal(0, 30, out[gap, j].shape)
        like[gap, j] = rng.uniform(0.0, 0.08)
    return out, like


def motor_log(
    rng: np.random.Generator, t: Array, phase: Array, dead_deg: float, fill: str
) -> Array:
    """Shaft angle, degrees, at times t: wrapped, blind over `dead_deg`, there filled by `fill`."""
    angle = np.degrees(phase + rng.uniform(0, 2 * np.pi)) % 360
    angle = (angle + rng.normal(0, 0.25, len(t))) % 360
    blind = angle > 360 - dead_deg
    if fill == "zero":
        return np.where(blind, 0.0, angle)
    angle = np.where(blind, np.nan, angle)
    if fill == "empty":
        return angle
    last = np.maximum.accumulate(np.where(np.isnan(angle), 0, np.arange(len(t))))
    return np.where(np.isnan(angle[last]), 0.0, angle[last])
