"""The filter as filterpy states it: what is published comes from here."""

from __future__ import annotations

import numpy as np
from filterpy.kalman import KalmanFilter

from .chain import Chain, Mask, Smoothed


def filter_and_smooth(chain: Chain, used: Mask) -> Smoothed:
    """Smoothed states by filterpy's Kalman filter and Rauch-Tung-Striebel smoother.

    used: (n,) measurements that count; the others are gaps (`update(None)`). State and measurements
    are one-dimensional, the form that is right in filterpy 1.4 and 2.0 alike.
    Source: Rauch, Tung, Striebel, AIAA Journal 3 (1965) 1445, eqs. 3.28 to 3.31.
    """
    n, p, d = chain.H.shape
    kf = KalmanFilter(dim_x=d, dim_z=p)
    kf.x, kf.P = chain.x0.copy(), chain.P0.copy()
    means, covs = np.empty((n, d)), np.empty((n, d, d))
    for k in range(n):
        if k:
            kf.predict(F=chain.F[k], Q=chain.Q[k])
        kf.H = chain.H[k]
        kf.update(chain.z[k] if used[k] else None, R=chain.R[k])
        kf.P = 0.5 * (kf.P + kf.P.T)
        means[k], covs[k] = kf.x, kf.P
    x, P, _, _ = kf.rts_smoother(means, covs, list(chain.F), list(chain.Q))
    return Smoothed(x, 0.5 * (P + np.swapaxes(P, 1, 2)))
