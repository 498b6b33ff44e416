"""Sine, cosine and smooth steps without branches, so that loops over simulations vectorise."""

from __future__ import annotations

import numpy as np
from numba import njit

FAST = frozenset({"nsz", "contract", "arcp", "reassoc"})
compiled_scalar = njit(error_model="numpy", fastmath=set(FAST), inline="always")


@compiled_scalar
def sin_cos(angle: float) -> tuple[float, float]:
    """Sine and cosine, absolute error below 1e-11 for |angle| < 1e4.

    The angle is brought to [-pi/2, pi/2] by multiples of pi, then Taylor series to r^15 and r^16
    in Horner's form (written out: a loop over coefficients would not become vector instructions).
    """
    n = np.floor(angle * 0.3183098861837907 + 0.5)
    r = angle - n * 3.141592653589793
    sign = 1.0 - 2.0 * (n - 2.0 * np.floor(n * 0.5))
    q = r * r
    s = -7.647163731819816e-13 * q + 1.6059043836821613e-10
    s = (s * q - 2.505210838544172e-08) * q + 2.7557319223985893e-06
    s = (s * q - 1.984126984126984e-4) * q + 8.333333333333333e-3
    s = (s * q - 0.16666666666666666) * q + 1.0
    c = 4.779477332387385e-14 * q - 1.1470745597729725e-11
    c = (c * q + 2.08767569878681e-09) * q - 2.755731922398589e-07
    c = (c * q + 2.48015873015873e-05) * q - 1.388888888888889e-3
    c = (c * q + 0.041666666666666664) * q - 0.5
    c = c * q + 1.0
    return sign * r * s, sign * c


@compiled_scalar
def smooth_step(x: float) -> float:
    """0 for x <= 0, 1 for x >= 1, `3 x^2 - 2 x^3` between."""
    c = min(max(x, 0.0), 1.0)
    return c * c * (3.0 - 2.0 * c)
