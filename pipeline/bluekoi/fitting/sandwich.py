"""Uncertainty from how the trials of a fit disagree, unbiased for few trials.

Errors within a trial are correlated, so that the inverse Fisher matrix is too small; trials are
independent. With the errors whitened by the filter, trial t has the Fisher matrix H_t and the score
g_t at the joint fit; in units in which H = sum H_t is 1 it is S_t = R' H_t R, its leverage.
A trial's score is smaller than its true errors would make it, since the fit went along with it.
Bell and McCaffrey's bias-reduced linearisation puts that right,

    cov = R [sum u_t u_t'] R',    u_t = A_t R' g_t,    A_t V_t A_t' = F_t,
    V_t = F_t - S_t F_t - F_t S_t + S_t (sum F_s) S_t,

with F_t the covariance expected of a trial's true score, V_t of what the fit leaves of it. Were
the errors white, F_t would be S_t and A_t = (1 - S_t)^-1/2. But an error drawn once for each
trial (a servo's) moves its score by s k_t, most in the trials that tell most:
F_t = S_t + s^2 k_t k_t', with s^2 from the scores. F_t need only be about right. Leaving out a
trial altogether (the jackknife, A_t = (1 - S_t)^-1) errs to the wide side. How many trials really
determine a number is expressed by the degrees of freedom of that sum under F_t, for Student's t.
Source: Bell and McCaffrey, Survey Methodology 28 (2002), 169; Pustejovsky and Tipton, Journal of
Business and Economic Statistics 36 (2018), 672.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

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
class ClusterInfluence:
    """Information of each trial, in units in which that of all trials is 1: root R (m, m) of the m
    coefficients off their bounds (p,), and leverage S_t, expected F_t, widened A_t, each (t, m, m).
    """

    move: np.ndarray
    root: Float
    leverage: Float
    expected: Float
    widened: Float

    def freedom(self, direction: Float) -> float:
        """Degrees of freedom of the variance of the sum of numbers with weights `direction` (p,);
        0 where one trial alone holds more than `ALONE` of it.
        """
        c = direction[self.move] @ self.root
        if not np.any(c) or _alone(self.leverage, c) > ALONE:
            return 0.0
        return _freedom(self.leverage, self.expected, self.widened, c)


@dataclass(frozen=True)
class Spread:
    """Covariance (p, p) of fitted numbers between trials, and degrees of freedom (p,) of each.

    freedom is 0 where nothing can be said: of a number that was not fitted, and of one that hangs
    on one trial alone. influence: for the freedom of their sums; None for one trial.
    """

    cov: Float
    freedom: Float
    influence: ClusterInfluence | None = None

    def half_widths(self, level: float = 0.95) -> Float:
        """Half widths (p,) of the intervals that hold the truth with this probability; infinite
        where nothing can be said.
        """
        quantile = stdtrit(np.maximum(self.freedom, 1.0), 0.5 + 0.5 * level)
        return np.where(self.freedom > 0, quantile * np.sqrt(np.diag(self.cov)), np.inf)

    def freedom_of(self, direction: Float) -> float:
        """Degrees of freedom of the sum of numbers with weights `direction` (p,); without
        `influence` the fewest of those that have a part in it.
        """
        if self.influence:
            return self.influence.freedom(direction)
        part = np.abs(direction) * np.sqrt(np.diag(self.cov))
        return float(self.freedom[part >= 0.1 * part.max()].min())

    def half_width(self, direction: Float, level: float = 0.95) -> float:
        """Half width of the interval of the sum of numbers with weights `direction` (p,)."""
        freedom = self.freedom_of(direction)
        if freedom <= 0:
            return np.inf
        quantile = stdtrit(max(freedom, 1.0), 0.5 + 0.5 * level)
        return float(quantile * np.sqrt(direction @ self.cov @ direction))


@dataclass(frozen=True)
class TrialRandomEffect:
    """An error that is constant within a trial and differs between trials, in the normal equations
    of the fitted coefficients: cross (t, p) = J'j, fisher (t,) = j'j, score (t,) = j'e, with j the
    derivative of the whitened predictions with respect to it.
    """

    cross: Float
    fisher: Float
    score: Float

    def variance(self, hessian: Float) -> float:
        """Its variance, from the trials' scores at the fit: E score^2 = a + variance b.

        With C = (sum H_t)^-1 and k = c' C c of a trial: a = h - k, b = h^2 - 2 k h + c' C D C c,
        D = sum c c' over trials: the fit goes along with it.
        """
        C = pseudo_inverse(hessian.sum(axis=0))
        taken = np.einsum("tp,pq,tq->t", self.cross, C, self.cross)
        every = C @ (self.cross.T @ self.cross) @ C
        a = self.fisher - taken
        b = self.fisher**2 - 2 * taken * self.fisher
        b += np.einsum("tp,pq,tq->t", self.cross, every, self.cross)
        seen = b > 1e-9 * b.max(initial=0.0)
        if not seen.any():
            return 0.0
        return max(0.0, float(np.mean((self.score[seen] ** 2 - a[seen]) / b[seen])))


def spread_over_trials(
    normal: Normal,
    moving: np.ndarray | None = None,
    lasting: TrialRandomEffect | None = None,
    *,
    least: float = LEAST_SHARE,
) -> Spread:
    """`Spread` of a joint fit from the normal equations of its trials.

    moving (p,): which numbers the fit could move; those held at a bound get no variance. lasting:
    what is expected of the trials' scores beside white errors. least: share of the naive variance
    that no direction falls below, since few trials may agree by chance. One trial alone says
    nothing of how trials disagree: the naive covariance, with no degree of freedom.
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
    expected = leverage + (_servo_scores_cov(H, root, lasting, move) if lasting else 0.0)
    widened = _cr2_adjustment(leverage, expected)
    scores = np.einsum("tpq,tq->tp", widened, normal.gradient[:, move] @ root)
    cov[np.ix_(move, move)] = root @ _floored(scores.T @ scores, least) @ root.T
    influence = ClusterInfluence(move, root, leverage, expected, widened)
    freedom[move] = [influence.freedom(unit) for unit in np.eye(p)[move]]
    return Spread(cov, freedom, influence)


def _servo_scores_cov(H: Float, root: Float, lasting: TrialRandomEffect, move: np.ndarray) -> Float:
    """s^2 k_t k_t' (t, p, p) of the numbers that move."""
    cross = lasting.cross[:, move]
    k = cross @ root
    variance = TrialRandomEffect(cross, lasting.fisher, lasting.score).variance(H)
    return variance * np.einsum("tp,tq->tpq", k, k)


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


def _cr2_adjustment(leverage: Float, expected: Float) -> Float:
    """A_t (t, p, p) with A V A' = F, so that widened scores have the covariance expected."""
    every = expected.sum(axis=0)
    out = []
    for S, F in zip(leverage, expected, strict=True):
        values, vectors = np.linalg.eigh(F)
        seen = values > 1e-9 * max(values[-1], 1e-12)
        size, axes = np.sqrt(values[seen]), vectors[:, seen]
        V = axes.T @ (F - S @ F - F @ S + S @ every @ S) @ axes
        left, turned = np.linalg.eigh(V / np.outer(size, size))
        inverse = (turned / np.sqrt(np.maximum(left, LEAST_LEFT))) @ turned.T
        out.append((axes * size) @ inverse @ (axes / size).T)
    return np.array(out)


def _alone(leverage: Float, direction: Float) -> float:
    """Share of the naive variance of a direction (m,) in directions that one trial alone holds."""
    share = 0.0
    for S in leverage:
        values, vectors = np.linalg.eigh(S)
        share += float(np.sum((direction @ vectors[:, values > 1.0 - LEAST_LEFT]) ** 2))
    return share / float(direction @ direction)


def _floored(matrix: Float, least: float) -> Float:
    values, vectors = np.linalg.eigh(matrix)
    return (vectors * np.maximum(values, least)) @ vectors.T


def _freedom(leverage: Float, expected: Float, widened: Float, direction: Float) -> float:
    """(tr G)^2 / tr G^2, with G_ts the covariance of b_t' r_t and b_s' r_s over trials,

    b_t = A_t' c, r_t what the fit leaves of the score of trial t:
    G_ts = delta_ts b_t' F_t b_t - b_t' F_t S_s b_s - b_t' S_t F_s b_s + b_t' S_t (sum F) S_s b_s.
    """
    b = np.einsum("tqp,q->tp", widened, direction)
    fb, sb = (np.einsum("tpq,tq->tp", M, b) for M in (expected, leverage))
    G = np.diag(np.einsum("tp,tp->t", b, fb)) - fb @ sb.T - sb @ fb.T
    G += sb @ expected.sum(axis=0) @ sb.T
    square = float(np.sum(G * G))
    return float(np.trace(G) ** 2 / square) if square > 0 else 1.0
