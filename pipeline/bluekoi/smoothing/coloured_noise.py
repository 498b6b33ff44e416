"""Coloured measurement noise: errors that are still there in the next frame.

    z = H x + e + v,   e_k = exp(-dt / T) e_{k-1} + w_k

e has the same variance in each coordinate, v is white. Shadows, glare and a detector that follows
the frame before cause such errors; a model with white noise alone takes them for motion.
Source: Bar-Shalom, Li, Kirubarajan, Estimation, 2001, sect. 8.2 (autocorrelated measurement noise).
"""

from __future__ import annotations

import numpy as np

from ..data import Float
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
