"""Linear Gaussian state-space model, the common form of all motions smoothed here.

    x_k = F_k x_{k-1} + w_k,  w_k ~ N(0, Q_k)        state
    z_k = H_k x_k + v_k,      v_k ~ N(0, R_k)        measurement, missing where used_k is False

F[0], Q[0] are never applied: the prior x0, P0 is that of the first time.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..data import Float


@dataclass(frozen=True)
class LinearGaussianModel:
    """Matrices of n times, d states, p measurements.

    F, Q: (n, d, d). H: (n, p, d). R: (n, p, p). z: (n, p). x0: (d,). P0: (d, d).
    """

    F: Float
    Q: Float
    H: Float
    R: Float
    z: Float
    x0: Float
    P0: Float


@dataclass(frozen=True)
class SmoothedStates:
    """State means (n, d) and covariances (n, d, d) given all measurements."""

    x: Float
    P: Float
