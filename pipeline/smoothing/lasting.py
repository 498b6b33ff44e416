"""Measuring errors that last: a part of the noise that is still there in the next frame.

    z = H x + e + v,   e_k = exp(-dt / T) e_{k-1} + w_k

e has the same variance in each coordinate, v is white. Shadows, glare and a detector that follows
the frame before make such errors; white noise would take them for motion.
Source: Bar-Shalom, Li, Kirubarajan, Estimation, 2001, sect. 8.2 (autocorrelated measurement noise).
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from .chain import Chain


def with_lasting(chain: Chain, dt_s: Float, variance: float, lasts_s: float) -> Chain:
    """The chain with one more state for each measured number, its error that lasts.

    dt_s: (n,) steps. variance: of the errors; lasts_s: time in which they fall to 1/e.
    """
    n, m, d = chain.H.shape
    keep = np.exp(-dt_s / lasts_s)
    F, Q = np.zeros((n, d + m, d + m)), np.zeros((n, d + m, d + m))
    F[:, :d, :d], Q[:, :d, :d] = chain.F, chain.Q
    at = np.arange(d, d + m)
    F[:, at, at] = keep[:, None]
    Q[:, at, at] = variance * (1 - keep[:, None] ** 2)
    H = np.concatenate([chain.H, np.broadcast_to(np.eye(m), (n, m, m))], axis=2)
    P0 = np.zeros((d + m, d + m))
    P0[:d, :d], P0[at, at] = chain.P0, variance
    return Chain(F, Q, H, chain.R, chain.z, np.concatenate([chain.x0, np.zeros(m)]), P0)
