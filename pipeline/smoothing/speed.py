"""Speed from an uncertain velocity."""

from __future__ import annotations

import numpy as np

from ..data import Float

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(9)


def speed_and_std(velocity: Float, cov: Float) -> tuple[Float, Float]:
    """Speed |v| (n,) and its standard deviation, from velocity (n, 2) and covariance (n, 2, 2).

    std^2 = E (|v + e| - |v|)^2, e ~ N(0, cov), by Gauss-Hermite quadrature: far from rest this is
    the delta method, v' C v / |v|^2; at rest it is the root mean square speed, trace C.
    """
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    root = np.linalg.cholesky(cov + 1e-30 * np.eye(2))
    points = np.stack(np.meshgrid(_NODES, _NODES), -1).reshape(-1, 2)
    weights = np.outer(_WEIGHTS, _WEIGHTS).ravel() / _WEIGHTS.sum() ** 2
    tried = velocity[:, None] + np.einsum("nij,kj->nki", root, points)
    change = np.hypot(tried[..., 0], tried[..., 1]) - speed[:, None]
    return speed, np.sqrt(change**2 @ weights)
