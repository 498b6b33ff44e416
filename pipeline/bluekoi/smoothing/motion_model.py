"""The state-space models that are fitted, as functions of the logarithms of their noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..data import Float
from .coloured_noise import coloured_noise_gradient, with_coloured_noise
from .likelihood_gradient import LikelihoodGradient
from .linear_gaussian import LinearGaussianModel
from .screening import ScreenedMeasurements

MIN_LOG_NOISE_RATIO = float(np.log(1e-4))
"""Log of the least variance of white noise over that stated; below, rounding errors matter."""


class NoiseParametrisedModel(Protocol):
    """A linear Gaussian model for each vector of the logarithms of its noise."""

    def model_at_log_noise(self, logs: Float) -> LinearGaussianModel:
        """The model with this noise."""

    def gradient(self, logs: Float, by_matrices: LikelihoodGradient) -> Float:
        """Derivatives (logs,) of a cost with respect to the logs, from those of the matrices."""


@dataclass(frozen=True)
class MotionMatrices:
    """F and Q of a channel for its noise, and the chain rule through them (`motion_gradient`)."""

    of_noise: Callable[[Float], tuple[Float, Float]]
    noise_gradient: Callable[[Float, Float, Float], Float]


@dataclass(frozen=True)
class MotionModel:
    """Mean motion and recoil with white measurement noise.

    logs: of the noise of `matrices` over its `units`, then of the variance of the measurements over
    that stated. H: (n, m, d), of m coordinates. x0: mean of the first state; start_variances:
    prior variances of position, rate and acceleration; of a moving body, the acceleration has that
    of the process as well. recoil_share: variance of the recoil in the first state over that in
    motion.
    """

    data: ScreenedMeasurements
    matrices: MotionMatrices
    H: Float
    units: Float
    x0: Float
    start_variances: Float
    moving: bool
    recoil_share: float

    def model_at_log_noise(self, logs: Float) -> LinearGaussianModel:
        """The model with this noise."""
        noise = self._noise_from_logs(logs)
        F, Q = self.matrices.of_noise(noise)
        m = self.data.z.shape[1]
        first = self.start_variances.copy()
        first[2] += self._process_acceleration_variance(noise)
        recoil = self._recoil_variances(noise)
        P0 = np.diag(np.concatenate([np.repeat(first, m), np.repeat(recoil, 2)]))
        R = self.data.R * np.exp(max(logs[-1], MIN_LOG_NOISE_RATIO))
        return LinearGaussianModel(F, Q, self.H, R, self.data.z, self.x0, P0)

    def gradient(self, logs: Float, by_matrices: LikelihoodGradient) -> Float:
        """Derivatives (logs,) of a cost with respect to the logs, from those of the matrices."""
        noise, m = self._noise_from_logs(logs), self.data.z.shape[1]
        out = np.zeros(len(logs))
        out[:-1] = self.matrices.noise_gradient(noise, by_matrices.F, by_matrices.Q)
        by_first = np.diag(by_matrices.P0)
        by_acceleration = by_first[2 * m : 3 * m].sum()
        out[[0, 2]] += self._process_acceleration_variance(noise) * by_acceleration
        recoil = self._recoil_variances(noise)
        by_recoil = by_first[3 * m : 3 * m + 2 * len(recoil)].reshape(-1, 2).sum(axis=1)
        out[3 + m : 3 + m + len(recoil)] += recoil * by_recoil
        if logs[-1] > MIN_LOG_NOISE_RATIO:
            out[-1] = np.sum(by_matrices.R * self.data.R) * np.exp(logs[-1])
        return out

    def _noise_from_logs(self, logs: Float) -> Float:
        return np.asarray(self.units * np.exp(logs[:-1]))

    def _process_acceleration_variance(self, noise: Float) -> float:
        """Variance q tau / 2 of the process's acceleration in the first state; 0 from rest."""
        return 0.5 * float(noise[0] * noise[2]) if self.moving else 0.0

    def _recoil_variances(self, noise: Float) -> Float:
        """Variances of the recoils in the first state."""
        m = self.data.z.shape[1]
        recoils = (self.H.shape[2] - 3 * m) // 2
        return np.asarray(noise[3 + m : 3 + m + recoils] * self.recoil_share)


@dataclass(frozen=True)
class ColouredNoiseModel:
    """A motion model whose measurements have coloured noise as well.

    logs: those of `white`, with two before the last: of variance and correlation time of the
    coloured noise over their units. dt_s: (n,) steps.
    """

    white: NoiseParametrisedModel
    dt_s: Float
    variance: float
    correlation_time_s: float

    def model_at_log_noise(self, logs: Float) -> LinearGaussianModel:
        """The model with this noise."""
        variance, time_s = self._variance_and_time(logs)
        white = self.white.model_at_log_noise(np.delete(logs, (-3, -2)))
        return with_coloured_noise(white, self.dt_s, variance, time_s)

    def gradient(self, logs: Float, by_matrices: LikelihoodGradient) -> Float:
        """Derivatives (logs,) of a cost with respect to the logs, from those of the matrices."""
        d = len(by_matrices.P0) - by_matrices.R.shape[1]
        F, Q = by_matrices.F[:, :d, :d], by_matrices.Q[:, :d, :d]
        inner = LikelihoodGradient(F, Q, by_matrices.R, by_matrices.P0[:d, :d])
        white = self.white.gradient(np.delete(logs, (-3, -2)), inner)
        own = coloured_noise_gradient(by_matrices, self.dt_s, *self._variance_and_time(logs))
        return np.concatenate([white[:-1], own, white[-1:]])

    def _variance_and_time(self, logs: Float) -> tuple[float, float]:
        size, time = np.exp(logs[-3:-1])
        return self.variance * float(size), self.correlation_time_s * float(time)
