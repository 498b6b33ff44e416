"""Uncertainty by leaving out trials, and draws from a fit.

Errors within a trial are correlated, so that the inverse Fisher matrix is many times too small.
Trials are independent: leaving each out in turn, by one Newton step from the joint fit, gives the
jackknife covariance (Efron and Stein, Ann. Statist. 9 (1981), 586), which errs to the wide side;
`sandwich` is free of that.
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from ..integrate import Kernel
from .joint import Fit, pseudo_inverse
from .normal import Normal


def jackknife_cov(normal: Normal, moving: np.ndarray | None = None) -> Float:
    """Covariance (p, p) of the fitted numbers from leaving out one trial at a time.

    moving (p,): which numbers the fit could move; those held at a bound get zero variance.
    """
    H, g = normal.hessian, normal.gradient
    count, p = g.shape
    move = np.ones(p, dtype=bool) if moving is None else moving
    cov = np.zeros((p, p))
    if count < 2 or not move.any():
        return pseudo_inverse(H.sum(axis=0))
    total = H.sum(axis=0)[np.ix_(move, move)]
    informed = [t for t in range(count) if np.any(np.diag(H[t]) > 0)]
    shifts = []
    for t in informed:
        rest = total - H[t][np.ix_(move, move)]
        # sum of gradients is zero at the fit, so the rest's gradient is -g_t
        shifts.append(pseudo_inverse(_floor(rest, total)) @ -g[t][move])
    n = max(len(informed), 2)
    spread = np.array(shifts)
    cov[np.ix_(move, move)] = (n - 1) / n * spread.T @ spread
    return cov + _diagonal_floor(pseudo_inverse(H.sum(axis=0)), move)


def _floor(rest: Float, total: Float) -> Float:
    """Fisher matrix of the remaining trials, kept invertible where one trial alone informs."""
    return rest + 1e-3 * np.diag(np.diag(total))


def _diagonal_floor(naive: Float, move: np.ndarray) -> Float:
    """Never less than a quarter of the naive variance: few trials may agree by chance."""
    return np.where(np.outer(move, move), 0.25 * naive, 0.0)


def moving(kernel: Kernel, found: Fit) -> np.ndarray:
    """Which fitted numbers are off their bounds, (p,)."""
    parameters = [kernel.system.parameters[kernel.system.slot[f.name]] for f in found.free]
    inside = [p.lower < v < p.upper for p, v in zip(parameters, found.values, strict=True)]
    return np.array(inside, dtype=bool)


def ensemble(fit: Fit, cov: Float, count: int, rng: np.random.Generator) -> Float:
    """Draws (count, p) of the fitted numbers for bands in figures."""
    vectors = np.linalg.eigh(0.5 * (cov + cov.T))
    root = vectors[1] * np.sqrt(np.maximum(vectors[0], 0.0))
    return fit.values + rng.standard_normal((count, len(fit.values))) @ root.T
