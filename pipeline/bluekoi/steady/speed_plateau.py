"""Steady speed: the plateau that the start-up runs into.

From rest against drag that grows with speed squared, m v' = T - k v^2:
    v(t) = v_inf tanh((t - t0) / tau)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ..data import Float

SETTLED_SPEED_SHARE = 0.99
"""Settled means this share of v_inf."""


@dataclass(frozen=True)
class Plateau:
    """Steady speed v_inf [m/s] with its deviation, start t0 and time constant tau [s].

    settled_s: time at which v reaches 99 % of v_inf.
    """

    speed_m_s: float
    speed_std_m_s: float
    start_s: float
    tau_s: float
    settled_s: float


def fit_plateau(time_s: Float, speed_m_s: Float, cov: Float) -> Plateau:
    """Plateau of a speed (n,) with error covariance (n, n), by least squares.

    Parameters v_inf, t0, tau; covariance J+ C J+'.
    """
    span = float(np.ptp(time_s))
    top = float(np.quantile(speed_m_s, 0.9))
    weight = 1.0 / np.sqrt(np.diag(cov) + (0.01 * top) ** 2)
    bounds = ([0.0, time_s[0] - 5 * span, 1e-3 * span], [5 * top, time_s[-1], 5 * span])
    start = [top, time_s[0] - 0.01 * span, 0.2 * span]
    found = least_squares(
        lambda p: weight * (p[0] * np.tanh((time_s - p[1]) / p[2]) - speed_m_s),
        start,
        bounds=bounds,
        loss="soft_l1",
        x_scale=[max(top, 1e-9), span, span],
    )
    inverse = np.linalg.pinv(found.jac) * weight
    std = float(np.sqrt((inverse @ cov @ inverse.T)[0, 0]))
    speed, begin, tau = (float(v) for v in found.x)
    return Plateau(speed, std, begin, tau, begin + tau * float(np.arctanh(SETTLED_SPEED_SHARE)))
