"""Speed from an uncertain velocity."""

from __future__ import annotations

import numpy as np

from ..data import Float

_GAUSS_HERMITE_NODES, _GAUSS_HERMITE_WEIGHTS = np.polynomial.hermite_e.hermegauss(9)


def speed_and_std(velocity: Float, cov: Float) -> tuple[Float, Float]:
    """Speed |v| (n,) and its standard deviation, from velocity (n, 2) and covariance (n, 2, 2).

    std^2 = E (|v + e| - |v|)^2, e ~ N(0, cov), by Gauss-Hermite quadrature: far from rest this is
    the delta method, v' C v / |v|^2; at rest it is the root mean square speed, trace C.
    """
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    root = _robust_cholesky(cov)
    points = np.stack(np.meshgrid(_GAUSS_HERMITE_NODES, _GAUSS_HERMITE_NODES), -1).reshape(-1, 2)
    weights = (
        np.outer(_GAUSS_HERMITE_WEIGHTS, _GAUSS_HERMITE_WEIGHTS).ravel()
        / _GAUSS_HERMITE_WEIGHTS.sum() ** 2
    )
    tried = velocity[:, None] + np.einsum("nij,kj->nki", root, points)
    change = np.hypot(tried[..., 0], tried[..., 1]) - speed[:, None]
    return speed, np.sqrt(change**2 @ weights)


def _robust_cholesky(cov: Float) -> Float:
    """Cholesky's factors (n, 2, 2) of covariances (n, 2, 2), also where rounding leaves one that is
    not quite positive.
    """
    root = np.zeros_like(cov)
    root[:, 0, 0] = np.sqrt(np.maximum(cov[:, 0, 0], 1e-30))
    root[:, 1, 0] = cov[:, 1, 0] / root[:, 0, 0]
    root[:, 1, 1] = np.sqrt(np.maximum(cov[:, 1, 1] - root[:, 1, 0] ** 2, 1e-30))
    return root
