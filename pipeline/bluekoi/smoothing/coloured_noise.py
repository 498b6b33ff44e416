"""Coloured measurement noise: errors that are still there in the next frame.

    z = H x + e + v,   e_k = exp(-dt / T) e_{k-1} + w_k

e has the same variance in each coordinate, v is white. Shadows, glare and a detector that follows
the frame before cause such errors; a model with white noise alone takes them for motion.
Source: Bar-Shalom, Li, Kirubarajan, Estimation, 2001, sect. 8.2 (autocorrelated measurement noise).
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from .likelihood_gradient import LikelihoodGradient
from .linear_gaussian import LinearGaussianModel


def with_coloured_noise(
    model: LinearGaussianModel, dt_s: Float, variance: float, correlation_s: float
) -> LinearGaussianModel:
    """The model with one more state for each measured number, its coloured error.

    dt_s: (n,) steps. variance: of the errors; correlation_s: time in which they fall to 1/e.
    """
    n, m, d = model.H.shape
    keep = np.exp(-dt_s / correlation_s)
    F, Q = np.zeros((n, d + m, d + m)), np.zeros((n, d + m, d + m))
    F[:, :d, :d], Q[:, :d, :d] = model.F, model.Q
    at = np.arange(d, d + m)
    F[:, at, at] = keep[:, None]
    Q[:, at, at] = variance * (1 - keep[:, None] ** 2)
    H = np.concatenate([model.H, np.broadcast_to(np.eye(m), (n, m, m))], axis=2)
    P0 = np.zeros((d + m, d + m))
    P0[:d, :d], P0[at, at] = model.P0, variance
    return LinearGaussianModel(
        F, Q, H, model.R, model.z, np.concatenate([model.x0, np.zeros(m)]), P0
    )


def coloured_noise_gradient(
    by_matrices: LikelihoodGradient, dt_s: Float, variance: float, correlation_s: float
) -> Float:
    """Derivatives of a cost with respect to the logs of variance and correlation time, (2,), from
    those with respect to the matrices of `with_coloured_noise`.
    """
    m = by_matrices.R.shape[1]
    decay = np.exp(-dt_s[1:] / correlation_s)
    by_decay, by_Q = (np.einsum("nii->n", g[1:, -m:, -m:]) for g in (by_matrices.F, by_matrices.Q))
    by_P0 = float(np.trace(by_matrices.P0[-m:, -m:]))
    by_variance = variance * (by_P0 + float(by_Q @ (1 - decay**2)))
    by_time = (by_decay - 2 * variance * decay * by_Q) @ (decay * dt_s[1:] / correlation_s)
    return np.array([by_variance, float(by_time)])
