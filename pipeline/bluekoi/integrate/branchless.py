"""Sine, exponential, power and smooth steps without branches: loops over simulations vectorise.

Functions of a model may use them; in the kernel they are written out (`inlining`).
"""

from __future__ import annotations

import math

import numpy as np


def sin_cos(angle: float) -> tuple[float, float]:
    """Sine and cosine, absolute error below 1e-11 for |angle| < 1e4.

    Half the angle is brought to [-pi/2, pi/2] by multiples of pi, so that no signs are to be set:
    sin = 2 s c, cos = 1 - 2 s^2 of its sine s and cosine c. These are polynomials that meet sine
    and cosine at the zeros of Chebyshev's polynomial of degree 7 in the square, in Horner's form
    (written out: a loop over coefficients would not become vector instructions).
    """
    h = 0.5 * angle - 3.141592653589793 * np.floor(0.15915494309189535 * angle + 0.5)
    q = h * h
    s = 1.5411219670658934e-10 * q - 2.5030268183566736e-08
    s = (s * q + 2.755695291272191e-06) * q - 0.00019841266683129065
    s = (s * q + 0.00833333332035834) * q - 0.1666666666646667
    s = (s * q + 0.9999999999999496) * h
    c = 1.9907506011734316e-09 * q - 2.7524670418858716e-07
    c = (c * q + 2.4801039927851903e-05) * q - 0.0013888884170787264
    c = (c * q + 0.0416666664728517) * q - 0.4999999999701275
    c = c * q + 0.9999999999992479
    d = s + s
    return d * c, 1.0 - d * s


def smooth_step(x: float) -> float:
    """0 for x <= 0, 1 for x >= 1, `3 x^2 - 2 x^3` between."""
    c = min(max(x, 0.0), 1.0)
    return c * c * (3.0 - 2.0 * c)


def exponential(x: float) -> float:
    """exp(x), relative error below 1e-11 for |x| < 10, below 3e-6 for |x| < 60, constant beyond.

    exp(x) = exp(x / 256)^256, the inner one by its series.
    """
    q = min(max(x, -60.0), 60.0) / 256.0
    e = 1.0 + q * (1.0 + q / 2 * (1.0 + q / 3 * (1.0 + q / 4 * (1.0 + q / 5 * (1.0 + q / 6)))))
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    return e * e


def branchless_power(x: float, p: float) -> float:
    """x^p for 1e-12 < x < 1e6, relative error below 1e-10 while |p log x| < 10.

    log x = 64 log y with y = x^(1/64) by square roots, and log y = 2 artanh((y - 1) / (y + 1)).
    """
    y = math.sqrt(math.sqrt(math.sqrt(math.sqrt(math.sqrt(math.sqrt(x))))))
    z = (y - 1.0) / (y + 1.0)
    q = z * z
    a = 1.0 + q * (1 / 3 + q * (1 / 5 + q * (1 / 7 + q * (1 / 9 + q * (1 / 11 + q / 13)))))
    return exponential(128.0 * z * a * p)
