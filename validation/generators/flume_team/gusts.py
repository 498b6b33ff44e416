"""Moving water as random accelerations: critically damped second-order filtered white noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from .form import Array


@dataclass(frozen=True)
class Gusts:
    """linear: standard deviation of each of two horizontal accelerations, m/s^2. turning: rad/s^2.

    pole: corner of the filter, rad/s: a'' + 2 pole a' + pole^2 a = white noise.
    """

    linear: float
    turning: float
    pole: float

    @property
    def sizes(self) -> Array:
        """Standard deviations of the three accelerations, (3,)."""
        return np.array([self.linear, self.linear, self.turning])

    @property
    def rates(self) -> Array:
        """System matrix of (a, a'), (2, 2)."""
        return np.array([[0.0, 1.0], [-(self.pole**2), -2 * self.pole]])

    def step(self, dt: float) -> tuple[Array, Array]:
        """Transition and noise covariance over dt for unit variance of a, (2, 2) each."""
        phi = expm(self.rates * dt)
        stationary = np.diag([1.0, self.pole**2])
        return phi, stationary - phi @ stationary @ phi.T


def random_series(
    rng: np.random.Generator, gusts: Gusts, steps: int, dt: float, trials: int
) -> Array:
    """Accelerations (steps, 3, trials) at intervals dt, stationary from the start."""
    phi, noise = gusts.step(dt)
    root = np.linalg.cholesky(noise + 1e-18 * np.diag([1.0, gusts.pole**2]))
    state = rng.normal(size=(2, 3 * trials)) * np.array([[1.0], [gusts.pole]])
    kicks = np.einsum("ij,njk->nik", root, rng.normal(size=(steps, 2, 3 * trials)))
    series = np.empty((steps, 3 * trials))
    for n in range(steps):
        series[n] = state[0]
        state = phi @ state + kicks[n]
    return series.reshape(steps, 3, trials) * gusts.sizes[:, None]
