"""Newton's step within bounds and a trust region."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import lsq_linear

from ..data import Float

MAX_ITERATIONS = 200
"""Of the least squares within bounds. SciPy's limit, the count of the numbers, ends too early where
a number returns from a bound."""
RIDGE = 1e-8
"""Relative to the diagonal, what is added to it: directions that no data touch stay put."""


def bounded_step(
    hessian: Float, gradient: Float, lower: Float, upper: Float, radius: float = np.inf
) -> Float:
    """Step d (p,) that maximises g'd - d'Hd/2 where lower <= d <= upper, and where no number
    moves by more than `radius` of its conditional standard deviations, 1 / sqrt(H_ii).

    The trust region is a box in these units, so that it and the bounds are one constraint (Conn,
    Gould and Toint, Trust-Region Methods (2000), sec. 7.8). Numbers without information stay.
    lower, upper (p,): at most and at least 0.
    """
    diagonal = np.diag(hessian)
    move = (diagonal > 0) & (upper > lower)
    step = np.zeros(len(gradient))
    if not move.any():
        return step
    scale = 1.0 / np.sqrt(diagonal[move])
    scaled = hessian[np.ix_(move, move)] * np.outer(scale, scale)
    # by QR iterations: divide and conquer found no eigenvalues of a well-conditioned matrix
    values, vectors = eigh(scaled + RIDGE * np.eye(len(scaled)), driver="ev")
    root = np.sqrt(np.maximum(values, RIDGE))
    least, most = (np.clip(b[move] / scale, -radius, radius) for b in (lower, upper))
    along = vectors.T @ (scale * gradient[move])
    found = vectors @ (along / root**2)
    if np.any((found < least) | (found > most)):
        found = lsq_linear(
            root[:, None] * vectors.T, along / root, bounds=(least, most), method="bvls",
            max_iter=MAX_ITERATIONS,
        ).x  # fmt: skip
    step[move] = np.clip(scale * found, lower[move], upper[move])
    return step
