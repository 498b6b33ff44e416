"""Circle through points by least distance, with the covariance that correlated errors leave.

Sources: Taubin, IEEE PAMI 13 (1991) 1115, in Newton form after Chernov, Circular and Linear
Regression, 2010, sect. 5.9; Gauss-Newton on the distances: sect. 4.4 of the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data import Float


@dataclass(frozen=True)
class Circle:
    """center_m: (2,). cov: (3, 3) of center x, y and radius. residual_m: (points,), outwards."""

    center_m: Float
    radius_m: float
    cov: Float
    residual_m: Float

    @property
    def radius_std_m(self) -> float:
        """Standard deviation of the radius, m."""
        return float(np.sqrt(self.cov[2, 2]))


def fit_circle(xy_m: Float, error_cov: Float) -> Circle:
    """Circle of least squared distances to xy_m (points, 2), m; 3 points or more.

    The minimum of sum (|p - c| - R)^2. Covariance: J+ C J+', C = error_cov (points, points) [m^2],
    the errors of the points across the circle.
    """
    estimate = taubin_circle(xy_m)
    for _ in range(50):
        away = xy_m - estimate[:2]
        distance = np.hypot(away[:, 0], away[:, 1])
        jacobian = -np.column_stack([away / distance[:, None], np.ones(len(away))])
        step = np.linalg.lstsq(jacobian, distance - estimate[2], rcond=None)[0]
        estimate = estimate - step
        if np.abs(step).max() < 1e-12 * max(estimate[2], 1e-9):
            break
    away = xy_m - estimate[:2]
    distance = np.hypot(away[:, 0], away[:, 1])
    inverse = np.linalg.pinv(np.column_stack([away / distance[:, None], np.ones(len(away))]))
    cov = inverse @ error_cov @ inverse.T
    return Circle(estimate[:2], float(estimate[2]), cov, distance - estimate[2])


def taubin_circle(xy_m: Float) -> Float:
    """Center x, y and radius of Taubin's algebraic circle: min of sum (z + Bx + Cy + D)^2 / grad^2.

    A singular value decomposition of [z - mean, x, y] with z = x^2 + y^2 (Chernov, 5.10).
    """
    mean = xy_m.mean(axis=0)
    at = xy_m - mean
    z = (at**2).sum(axis=1)
    middle = z.mean()
    root = 2 * np.sqrt(max(middle, 1e-300))
    _, _, axes = np.linalg.svd(np.column_stack([(z - middle) / root, at]), full_matrices=False)
    a = axes[2, 0] / root
    a = a if abs(a) > 1e-12 else 1e-12
    center = -axes[2, 1:] / (2 * a)
    radius = np.sqrt(max(float(center @ center + middle), 1e-300))
    return np.array([*(center + mean), radius])
