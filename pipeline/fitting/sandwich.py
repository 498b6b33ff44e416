"""Uncertainty from how the trials of a fit disagree, unbiased for few trials.

Errors within a trial are correlated, so that the inverse Fisher matrix is too small; trials are
independent. With the errors whitened by the filter, trial t has the Fisher matrix H_t and the score
g_t at the joint fit; in units in which H = sum H_t is 1, S_t = H^-1/2 H_t H^-1/2 is its leverage.
A trial's score is smaller than its true errors would make it, since the fit went along with it.
Bell and McCaffrey's bias-reduced linearisation puts that right,

    cov = H^-1/2 [sum u_t u_t'] H^-1/2,    u_t = (1 - S_t)^-1/2 H^-1/2 g_t,

where leaving out a trial altogether (the jackknife, power -1) errs to the wide side. How many
trials really speak of a number is told by the degrees of freedom of that sum, for Student's t.
Source: Bell and McCaffrey, Survey Methodology 28 (2002), 169; Pustejovsky and Tipton, Journal of
Business and Economic Statistics 36 (2018), 672.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from ..data import Float
from .joint import pseudo_inverse
from .normal import Normal

LEAST_LEFT = 0.02
"""A direction of which one trial holds more than 98 % cannot be judged from the others."""
ALONE = 0.1
"""A number is not judged where this share of its naive variance lies in such directions."""
LEAST_SHARE = 0.25
"""Trials may agree by chance: in no direction less than this share of the naive variance."""


@dataclass(frozen=True)
class Spread:
    """Covariance (p, p) of fitted numbers between trials, and degrees of freedom (p,) of each.

    freedom is 0 where nothing can be said: of a number that was not fitted, and of one that hangs
    on one trial alone.
    """

    cov: Float
    freedom: Float

    def half_widths(self, level: float = 0.95) -> Float:
        """Half widths (p,) of the intervals that hold the truth with this probability; infinite
        where nothing can be said.
        """
        quantile = student.ppf(0.5 + 0.5 * level, np.maximum(self.freedom, 1.0))
        return np.where(self.freedom > 0, quantile * np.sqrt(np.diag(self.cov)), np.inf)


def spread_over_trials(normal: Normal, moving: np.ndarray | None = None) -> Spread:
    """`Spread` of a joint fit from the normal equations of its trials.

    moving (p,): which numbers the fit could move; those held at a bound get no variance. One trial
    alone says nothing of how trials disagree: the naive covariance, with no degree of freedom.
    """
    count, p = normal.gradient.shape
    move = np.ones(p, dtype=bool) if moving is None else moving
    cov, freedom = np.zeros((p, p)), np.zeros(p)
    if not move.any():
        return Spread(cov, freedom)
    H = normal.hessian[:, move][:, :, move]
    total = H.sum(axis=0)
    if count < 2:
        cov[np.ix_(move, move)] = pseudo_inverse(total)
        return Spread(cov, freedom)
    root = _inverse_root(total)
    leverage = root.T @ H @ root
    widened = np.array([_root_of_rest(S) for S in leverage])
    scores = np.einsum("tpq,tq->tp", widened, normal.gradient[:, move] @ root)
    cov[np.ix_(move, move)] = root @ _floored(scores.T @ scores) @ root.T
    told = np.array([_freedom(leverage, widened, c) for c in root])
    freedom[move] = np.where(_alone(leverage, root) > ALONE, 0.0, told)
    return Spread(cov, freedom)


def without_bounds(normal: Normal) -> tuple[Float, Spread]:
    """Change (p,) to where all numbers would go if none were held at a bound, by one Newton step,
    and their `Spread` there.
    """
    change = pseudo_inverse(normal.hessian.sum(axis=0)) @ normal.gradient.sum(axis=0)
    gradient = normal.gradient - normal.hessian @ change
    return change, spread_over_trials(Normal(normal.hessian, gradient, normal.log_likelihood))


def _inverse_root(matrix: Float) -> Float:
    """R with R R' = matrix^-1, columns of directions that nothing informs small, not infinite."""
    size = np.sqrt(np.where(np.diag(matrix) > 0, np.diag(matrix), 1.0))
    values, vectors = np.linalg.eigh(matrix / np.outer(size, size))
    return (vectors / np.sqrt(np.maximum(values, 1e-12))) / size[:, None]


def _root_of_rest(leverage: Float) -> Float:
    """(1 - S)^-1/2."""
    values, vectors = np.linalg.eigh(leverage)
    return (vectors / np.sqrt(np.maximum(1.0 - values, LEAST_LEFT))) @ vectors.T


def _alone(leverage: Float, root: Float) -> Float:
    """Share (p,) of each number's naive variance in directions that one trial alone holds."""
    share = np.zeros(len(root))
    for S in leverage:
        values, vectors = np.linalg.eigh(S)
        share += np.sum((root @ vectors[:, values > 1.0 - LEAST_LEFT]) ** 2, axis=1)
    return share / np.sum(root**2, axis=1)


def _floored(matrix: Float) -> Float:
    values, vectors = np.linalg.eigh(matrix)
    return (vectors * np.maximum(values, LEAST_SHARE)) @ vectors.T


def _freedom(leverage: Float, widened: Float, direction: Float) -> float:
    """(tr G)^2 / tr G^2 with G_ts = delta_ts b_t' S_t b_t - b_t' S_t S_s b_s and
    b_t = (1 - S_t)^-1/2 c.
    """
    b = widened @ direction
    sb = np.einsum("tpq,tq->tp", leverage, b)
    G = np.diag(np.einsum("tp,tp->t", b, sb)) - sb @ sb.T
    square = float(np.sum(G * G))
    return float(np.trace(G) ** 2 / square) if square > 0 else 1.0
