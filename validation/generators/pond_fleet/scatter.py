"""Scatter of an observation about the expected one, and how much of it a trial's errors take up.

Scatter by eddies comes from simulated sessions; that by the segments' starts and by the trial's
servo and thrust is linear; that of tracking is independent between samples, which lie about a tail
beat apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .eddies import draw_eddies
from .experiment import SAMPLES, SEGMENTS, Experiment, Variant
from .law import Law
from .robots import Array
from .trials import SERVO_ERROR

SESSIONS = 50
QUALITY_ERROR = 0.006
START_WIDTH = np.array([3.0, 3.0, 5.0, 3.0, 3.0, 5.0])
"""Prior of the starting state, in the units of Variant.start."""


@dataclass(frozen=True)
class Scatter:
    """Precision of an observation, (trials, n, n) with n = 3 SAMPLES.

    remover: (trials, n, n) takes off what starts, servo and thrust of a trial explain. floor: root
    mean square path error (m) of the true model after that.
    """

    precision: Array
    remover: Array
    floor: float

    def path_error(self, residual: Array) -> float:
        """Root mean square distance (m) left after the starting states, residual (trials, n)."""
        return _path_error(np.einsum("tij,tj->ti", self.remover, residual))


def _path_error(residual: Array) -> float:
    places = residual.reshape(*residual.shape[:-1], SAMPLES, 3)[..., :2]
    return float(np.sqrt((places**2).sum(axis=-1).mean()))


def flat(observation: Array) -> Array:
    """(..., SAMPLES, 3) as (..., n)."""
    return observation.reshape(*observation.shape[:-2], SAMPLES * 3)


def measure_scatter(
    rng: np.random.Generator, experiment: Experiment, laws: Sequence[Law], sizes: tuple[float, ...],
    *, water: float, tracking: tuple[float, float],
) -> Scatter:  # fmt: skip
    """Scatter of a session. water: eddies (m/s). tracking: error of a sample (m, rad)."""
    starts = experiment.segment_starts(laws, sizes)
    base = Variant(sizes=sizes)
    expected = flat(experiment.observe([base], laws, starts))[0]
    cloud = _simulated(rng, experiment, laws, base, starts=starts, water=water) - expected
    noise = np.tile(np.array([tracking[0]] * 2 + [tracking[1]]) ** 2, SAMPLES)
    unexplained = _within_segments(cloud) + np.diag(noise)
    slopes = _trial_slopes(experiment, laws, base, starts, expected)
    information = np.linalg.inv(unexplained)
    priors = np.diag(np.concatenate([np.tile(START_WIDTH**-2.0, SEGMENTS), [1.0, 1.0]]))
    inner = np.swapaxes(slopes, 1, 2) @ information @ slopes + priors
    gain = np.linalg.solve(inner, np.swapaxes(slopes, 1, 2) @ information)
    remover = np.eye(noise.size) - slopes @ gain
    seen = cloud + np.sqrt(noise) * rng.normal(size=cloud.shape)
    floor = _path_error(np.einsum("tij,stj->sti", remover, seen))
    return Scatter(information @ remover, remover, floor)


def _within_segments(cloud: Array) -> Array:
    """Covariance (trials, n, n) of deviations (sessions, trials, n), independent by segment.

    Divided by the factor of Hartlap 2007 (A&A 464, 399), so that its inverse is unbiased.
    """
    size = cloud.shape[2] // SEGMENTS
    whole = np.einsum("sti,stj->tij", cloud, cloud) / (len(cloud) - size - 2)
    return np.asarray(whole * np.kron(np.eye(SEGMENTS), np.ones((size, size))))


def _trial_slopes(
    experiment: Experiment, laws: Sequence[Law], base: Variant, starts: Array, expected: Array
) -> Array:
    """Effects of segment starts and of a trial's servo and thrust errors, (trials, n, effects)."""
    steps = [replace(base, start=row) for row in np.eye(6)]
    steps += [replace(base, servo=SERVO_ERROR), replace(base, quality=QUALITY_ERROR)]
    slopes = np.moveaxis(flat(experiment.observe(steps, laws, starts)) - expected, 0, 2)
    size = slopes.shape[1] // SEGMENTS
    own = [slopes[:, :, :6] * (np.arange(slopes.shape[1]) // size == k)[None, :, None]
           for k in range(SEGMENTS)]  # fmt: skip
    return np.concatenate([*own, slopes[:, :, 6:]], axis=2)


def _simulated(
    rng: np.random.Generator, experiment: Experiment, laws: Sequence[Law], base: Variant,
    *, starts: Array, water: float,
) -> Array:  # fmt: skip
    """Sessions with eddies, (sessions, trials, n)."""
    plant = experiment.plant([base] * SESSIONS, laws)
    eddies = draw_eddies(rng, SESSIONS * starts.shape[1], experiment.robot.body_length, water)
    return flat(experiment.seen(replace(plant, unrest=eddies), np.tile(starts, SESSIONS)))
