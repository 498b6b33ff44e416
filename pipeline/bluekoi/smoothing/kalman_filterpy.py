"""The filter as filterpy states it: what is published comes from here."""

from __future__ import annotations

import numpy as np
from filterpy.kalman import KalmanFilter

from ..data import BoolNDArray, Float
from .kalman_numba import smooth_backward
from .linear_gaussian import LinearGaussianModel, SmoothedStates


def filter_and_smooth(model: LinearGaussianModel, used: BoolNDArray) -> SmoothedStates:
    """Smoothed states: filterpy's Kalman filter, then the backward pass of Bryson and Frazier.

    used: (n,) measurements that count; the others are gaps (`update(None)`). State and measurements
    are one-dimensional, the form that is right in filterpy 1.4 and 2.0 alike. filterpy's own
    `rts_smoother` gives the same, but inverts the predicted covariance,
    which a motion without process noise makes singular.
    """
    n, p, d = model.H.shape
    kf = _new_kalman_filter(model)
    means, covs = np.empty((n, d)), np.empty((n, d, d))
    inverses, innovations = np.zeros((n, p, p)), np.zeros((n, p))
    for k in range(n):
        _predict_and_update(kf, model, k, bool(used[k]))
        means[k], covs[k] = kf.x_prior, 0.5 * (kf.P_prior + kf.P_prior.T)
        if used[k]:
            inverses[k], innovations[k] = kf.SI, kf.y
    return smooth_backward(
        model, used, means=means, covs=covs, inverses=inverses, innovations=innovations
    )


def _new_kalman_filter(model: LinearGaussianModel) -> KalmanFilter:
    _, p, d = model.H.shape
    kf = KalmanFilter(dim_x=d, dim_z=p)
    kf.x, kf.P = model.x0.copy(), model.P0.copy()
    return kf


def _predict_and_update(kf: KalmanFilter, model: LinearGaussianModel, k: int, used: bool) -> None:
    """Predict to time k (the first is the prior itself), then update where it was measured."""
    d = len(model.x0)
    F: Float = model.F[k] if k else np.eye(d)
    kf.predict(F=F, Q=model.Q[k] if k else np.zeros((d, d)))
    kf.H = model.H[k]
    kf.update(model.z[k] if used else None, R=model.R[k])
