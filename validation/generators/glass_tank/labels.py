"""What a detector network makes of the true pixels, and the log of the motor's shaft."""

from __future__ import annotations

import numpy as np

from .design import Study
from .detector import head_angle
from .dynamics import Motion
from .form import DT, Array, Clock, Situation, act, strengths_of
from .observe import Pose, frame_times, label_pixels
from .weather import ornstein_uhlenbeck

LOG_STEP_S = 0.005


def motor_phase(study: Study, trial: int, t_end: float) -> tuple[Array, Array, Array]:
    """Grid of step DT (s), flapping phase (revolutions) and frequency (Hz) of a trial."""
    t = np.arange(int(np.ceil(t_end / DT)) + 2) * DT
    own = study.trials.take(np.array([trial]))
    flap = own.flap * study.true_flap[trial] / study.trials.flap[trial] + 0 * t
    now = Situation(t, own, study.robot, flap=flap)
    act("motor", now, study.causes, strengths_of(study.causes))
    flap = now.flap
    phase = np.concatenate([[0], np.cumsum(0.5 * DT * (flap[1:] + flap[:-1]))])
    return t, phase, flap


def true_pixels(study: Study, motion: Motion, trial: int, duration: float) -> Array:
    """Pixels (5, frames), complex, of a trial, with recoil and tail beat."""
    robot, noise, strengths = study.robot, study.noise, strengths_of(study.causes)
    stated = np.arange(int(np.floor(duration * study.fps)) + 1) / study.fps
    number = np.full(len(stated), trial)
    t = frame_times(stated, number, study.causes, strengths)
    states = motion.of_trial(trial).at(t[:, None])[0][:, :, 0]
    grid, turns, flap = motor_phase(study, trial, max(t[-1], 0.1))
    phase = 2 * np.pi * (np.interp(t, grid, turns) + study.first_phase[trial])
    share = np.interp(t, grid, flap) / study.trials.flap[trial]
    swing = np.where(t > 0, share, 0.0) * np.clip(t / 0.3, 0, 1)
    recoil = np.sin(phase) + 0.15 * np.sin(2 * phase + 0.7)
    turn = swing * np.radians(noise["recoil_deg"]) * recoil
    side = swing * noise["recoil_sway_BL"] * robot.body_length * np.sin(phase + 1.1)
    own = study.trials.take(number)
    phi = head_angle(study, t, own, study.weather.servo_error(t, trial), strengths)
    centre = states[0] + 1j * states[1] + 1j * side * np.exp(1j * states[2])
    pose = Pose(centre.real, centre.imag, states[2] + turn, phi, own.head)
    beat = swing * np.radians(noise["tail_beat_deg"]) * np.sin(phase - 0.9)
    return label_pixels(study, pose, Clock(stated, number, t), strengths, beat=beat)


def _complex_normal(rng: np.random.Generator, shape: tuple[int, int]) -> Array:
    """Two independent standard normal numbers as real and imaginary parts."""
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


def _with_outliers(
    rng: np.random.Generator, study: Study, pixels: Array, found: Array, likelihood: Array
) -> tuple[Array, Array]:
    """Detections and likelihoods with outliers: jumps, or another label taken for this one."""
    shape = pixels.shape
    body = np.abs(pixels[0] - pixels[3]).mean()
    bad = rng.random(shape) < study.noise["outlier_share"]
    size = np.exp(rng.uniform(np.log(0.15), np.log(2.0), shape))
    jump = body * size * np.exp(2j * np.pi * rng.random(shape))
    swapped = pixels[[3, 2, 1, 0, 0]]
    wrong = np.where(rng.random(shape) < 0.3, swapped, pixels + jump)
    low = rng.random(shape) < 0.65
    doubted = np.where(low, rng.beta(1.2, 3.0, shape), likelihood)
    return np.where(bad, wrong, found), np.where(bad, doubted, likelihood)


def _gaps(rng: np.random.Generator, study: Study, n: int) -> Array:
    """Where single labels or all of them are not found, (5, n)."""
    gone = np.zeros((5, n), bool)
    budget = study.noise["gap_share"] * n
    while budget > 0:
        length = int(min(1 + rng.exponential(0.25) * study.fps, 0.15 * n))
        start = rng.integers(0, n - length)
        every = rng.random() < 0.25
        rows = slice(None) if every else int(rng.integers(5))
        gone[rows, start : start + length] = True
        budget -= length * (1.0 if every else 0.2)
    return gone


def detect(rng: np.random.Generator, study: Study, pixels: Array) -> tuple[Array, Array, Array]:
    """Detections x, y (5, frames) in px of the true pixels, and their likelihoods.

    White plus autocorrelated errors; outliers of which a third keep a high likelihood; gaps of
    single labels and of the whole robot (glare), with a likelihood below 0.1 or NaN.
    """
    noise, shape = study.noise, pixels.shape
    slow = ornstein_uhlenbeck(rng, (5, 2), shape[1], 1 / study.fps, noise["slow_tau_s"])
    error = noise["slow_px"] * (slow[:, :, 0] + 1j * slow[:, :, 1]).T
    error = error + noise["white_px"] * _complex_normal(rng, shape)
    found = pixels + study.label_factor[:, None] * error
    doubt = 10 ** (-rng.gamma(9.0, 0.33, shape)) * (1 + 0.5 * np.abs(error) ** 2)
    likelihood = np.clip(1 - doubt, 0.35, 0.99999)
    found, likelihood = _with_outliers(rng, study, pixels, found, likelihood)
    gone = _gaps(rng, study, shape[1])
    body = np.abs(pixels[0] - pixels[3]).mean()
    far = pixels + body * 0.4 * _complex_normal(rng, shape)
    found = np.where(gone, far, found)
    likelihood = np.where(gone, rng.uniform(0.0, 0.095, shape), likelihood)
    if study.empty_cells:
        found = np.where(gone, np.nan + 1j * np.nan, found)
        likelihood = np.where(gone, np.nan, likelihood)
    return found.real, found.imag, likelihood


def shaft_log(
    rng: np.random.Generator, study: Study, trial: int, t_end: float
) -> tuple[Array, Array]:
    """Times (s) and shaft angles (deg) of the motor log of a trial; NaN for an empty cell."""
    t = np.arange(0, t_end, LOG_STEP_S)
    grid, turns, _ = motor_phase(study, trial, t_end)
    phase = np.interp(t, grid, turns)
    wobble = 2.5 * np.sin(4 * np.pi * phase)
    turned = 360 * (phase + study.first_phase[trial])
    angle = (turned + wobble + rng.normal(0, 0.4, len(t))) % 360
    dead = angle > 360 - study.dead_zone_deg
    if study.dead_zone == "zero":
        angle[dead] = 0.0
    elif study.dead_zone == "empty":
        angle[dead] = np.nan
    else:
        angle = angle[np.maximum.accumulate(np.where(dead, 0, np.arange(len(t))))]
    return t, angle
