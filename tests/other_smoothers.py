"""Other methods to estimate speed and yaw rate, as a careful user would apply them.

Wrong points are taken out by a running median first and gaps bridged by a line, since none of them
does it for itself. All return velocity (n, 2) and yaw rate (n,).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import make_smoothing_spline
from scipy.ndimage import median_filter
from scipy.signal import savgol_filter

from bluekoi.data import Float, Pose
from bluekoi.smoothing.kalman_numba import compiled_filter_and_smooth
from bluekoi.smoothing.linear_gaussian import LinearGaussianModel

Rates = tuple[Float, Float]


def without_outliers(pose: Pose) -> Float:
    """x, y, heading (n, 3) without points 5 sigma off a running median, gaps bridged."""
    out = pose.values[:, :3].copy()
    for channel in out.T:
        seen = np.isfinite(channel)
        rest = channel[seen] - median_filter(channel[seen], 7, mode="nearest")
        limit = 5 * 1.4826 * np.median(np.abs(rest)) + 1e-12
        seen[np.flatnonzero(seen)[np.abs(rest) > limit]] = False
        channel[:] = np.interp(pose.time_s, pose.time_s[seen], channel[seen])
    return out


def savitzky_golay(pose: Pose, setting: tuple[int, int]) -> Rates:
    """setting: window in frames, order."""
    window, order = setting
    step = float(np.median(np.diff(pose.time_s)))
    rate = savgol_filter(without_outliers(pose), window, order, deriv=1, delta=step, axis=0)
    return rate[:, :2], rate[:, 2]


def spline(pose: Pose, setting: float) -> Rates:
    """setting: penalty on the second derivative."""
    at = [make_smoothing_spline(pose.time_s, c, lam=setting) for c in without_outliers(pose).T]
    rate = np.column_stack([s.derivative()(pose.time_s) for s in at])
    return rate[:, :2], rate[:, 2]


def constant_velocity(pose: Pose, setting: float) -> Rates:
    """Kalman filter and smoother with white acceleration; setting: its density over R / s^3."""
    t, z = pose.time_s, without_outliers(pose)
    dt = np.diff(t, prepend=t[0])
    n = len(t)
    F, Q = np.tile(np.eye(2), (n, 1, 1)), np.empty((n, 2, 2))
    F[:, 0, 1] = dt
    Q[:, 0, 0], Q[:, 1, 1] = dt**3 / 3, dt
    Q[:, 0, 1] = Q[:, 1, 0] = dt**2 / 2
    H, R = np.tile([[[1.0, 0.0]]], (n, 1, 1)), np.ones((n, 1, 1))
    columns = []
    for channel in z.T:
        x0, P0 = np.array([channel[0], 0.0]), np.diag([1e4, 1e4])
        chain = LinearGaussianModel(F, setting * Q, H, R, channel[:, None], x0, P0)
        columns.append(compiled_filter_and_smooth(chain, np.ones(n, bool)).x[:, 1])
    rate = np.column_stack(columns)
    return rate[:, :2], rate[:, 2]


def rival_settings(frames: int) -> dict[str, tuple[Callable[..., Rates], list]]:
    """The rivals with the settings among which each is given its best."""
    windows = [w for w in (5, 9, 13, 19, 25, 33, 45, 61, 81) if w < frames]
    return {
        "savitzky_golay": (savitzky_golay, [(w, k) for w in windows for k in (1, 2, 3)]),
        "spline": (spline, list(np.geomspace(1e-6, 1e2, 17))),
        "constant_velocity": (constant_velocity, list(np.geomspace(1e-2, 1e7, 19))),
    }
