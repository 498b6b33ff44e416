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
from .joint_fit import regularised_fisher_inverse
from .normal import NormalEquationsByTrial

MIN_INFORMATION_SHARE_LEFT = 0.02
"""A direction of which one trial holds more than 98 % cannot be judged from the others."""
MAX_SINGLE_TRIAL_SHARE = 0.1
"""Largest share of a number's naive variance that may lie in such directions."""
MIN_NAIVE_VARIANCE_SHARE = 0.25
"""Trials may agree by chance: in no direction less than this share of the naive variance."""


@dataclass(frozen=True)
class ClusterInfluence:
    """Information of each trial, in units in which that of all trials is 1: root R (m, m) of the m
    coefficients off their bounds (p,); leverage S_t, expected F_t, adjustment A_t, each (t, m, m).
    """

    move: np.ndarray
    root: Float
    leverage: Float
    expected: Float
    adjustment: Float

    def df(self, direction: Float) -> float:
        """Degrees of freedom of the variance of the sum of numbers with weights `direction` (p,);
        0 where single trials alone hold more than `MAX_SINGLE_TRIAL_SHARE` of it.
        """
        c = direction[self.move] @ self.root
        if not np.any(c) or _single_trial_variance_share(self.leverage, c) > MAX_SINGLE_TRIAL_SHARE:
            return 0.0
        return _satterthwaite_df(self.leverage, self.expected, self.adjustment, c)


@dataclass(frozen=True)
class ClusterCovariance:
    """Covariance (p, p) of fitted numbers between trials, and degrees of freedom (p,) of each.

    df is 0 of a number that was not fitted, and of one that depends on one trial alone.
    influence: for the df of their sums; None for one trial.
    """

    cov: Float
    df: Float
    influence: ClusterInfluence | None = None

    def half_widths(self, level: float = 0.95) -> Float:
        """Half widths (p,) of the intervals that hold the truth with this probability; infinite
        where nothing can be said.
        """
        quantile = stdtrit(np.maximum(self.df, 1.0), 0.5 + 0.5 * level)
        return np.where(self.df > 0, quantile * np.sqrt(np.diag(self.cov)), np.inf)

    def df_of(self, direction: Float) -> float:
        """Degrees of freedom of the sum of numbers with weights `direction` (p,); without
        `influence` the fewest of those that have a part in it.
        """
        if self.influence:
            return self.influence.df(direction)
        part = np.abs(direction) * np.sqrt(np.diag(self.cov))
        return float(self.df[part >= 0.1 * part.max()].min())

    def half_width(self, direction: Float, level: float = 0.95) -> float:
        """Half width of the interval of the sum of numbers with weights `direction` (p,)."""
        df = self.df_of(direction)
        if df <= 0:
            return np.inf
        quantile = stdtrit(max(df, 1.0), 0.5 + 0.5 * level)
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
        C = regularised_fisher_inverse(hessian.sum(axis=0))
        taken = np.einsum("tp,pq,tq->t", self.cross, C, self.cross)
        every = C @ (self.cross.T @ self.cross) @ C
        a = self.fisher - taken
        b = self.fisher**2 - 2 * taken * self.fisher
        b += np.einsum("tp,pq,tq->t", self.cross, every, self.cross)
        seen = b > 1e-9 * b.max(initial=0.0)
        if not seen.any():
            return 0.0
        return max(0.0, float(np.mean((self.score[seen] ** 2 - a[seen]) / b[seen])))


def cluster_covariance(
    normal: NormalEquationsByTrial,
    estimated: np.ndarray | None = None,
    trial_effect: TrialRandomEffect | None = None,
    *,
    min_share: float = MIN_NAIVE_VARIANCE_SHARE,
) -> ClusterCovariance:
    """`ClusterCovariance` of a joint fit from the normal equations of its trials.

    estimated (p,): which numbers are off their bounds; the others get no variance. trial_effect:
    expected contribution to the trials' scores beside white errors. min_share: smallest share of
    the naive variance in any direction, since few trials may agree by chance. For one trial: the
    naive covariance, with no degree of freedom.
    """
    count, p = normal.gradient.shape
    move = np.ones(p, dtype=bool) if estimated is None else estimated
    cov, df = np.zeros((p, p)), np.zeros(p)
    if not move.any():
        return ClusterCovariance(cov, df)
    H = normal.hessian[:, move][:, :, move]
    total = H.sum(axis=0)
    if count < 2:
        cov[np.ix_(move, move)] = regularised_fisher_inverse(total)
        return ClusterCovariance(cov, df)
    root = _inverse_square_root(total)
    leverage = root.T @ H @ root
    expected = leverage + (
        _trial_effect_scores_cov(H, root, trial_effect, move) if trial_effect else 0.0
    )
    adjustment = _cr2_adjustment(leverage, expected)
    scores = np.einsum("tpq,tq->tp", adjustment, normal.gradient[:, move] @ root)
    cov[np.ix_(move, move)] = (
        root @ _with_floored_eigenvalues(scores.T @ scores, min_share) @ root.T
    )
    influence = ClusterInfluence(move, root, leverage, expected, adjustment)
    df[move] = [influence.df(unit) for unit in np.eye(p)[move]]
    return ClusterCovariance(cov, df, influence)


def _trial_effect_scores_cov(
    H: Float, root: Float, trial_effect: TrialRandomEffect, move: np.ndarray
) -> Float:
    """s^2 k_t k_t' (t, p, p) of the numbers that move."""
    cross = trial_effect.cross[:, move]
    k = cross @ root
    variance = TrialRandomEffect(cross, trial_effect.fisher, trial_effect.score).variance(H)
    return variance * np.einsum("tp,tq->tpq", k, k)


def newton_step_ignoring_bounds(normal: NormalEquationsByTrial) -> tuple[Float, ClusterCovariance]:
    """Change (p,) to where all numbers would go if none were held at a bound, by one Newton step,
    and their `ClusterCovariance` there.
    """
    change = regularised_fisher_inverse(normal.hessian.sum(axis=0)) @ normal.gradient.sum(axis=0)
    gradient = normal.gradient - normal.hessian @ change
    return change, cluster_covariance(
        NormalEquationsByTrial(normal.hessian, gradient, normal.log_likelihood)
    )


def _inverse_square_root(matrix: Float) -> Float:
    """R with R R' = matrix^-1, columns of directions that nothing informs small, not infinite."""
    size = np.sqrt(np.where(np.diag(matrix) > 0, np.diag(matrix), 1.0))
    values, vectors = np.linalg.eigh(matrix / np.outer(size, size))
    return (vectors / np.sqrt(np.maximum(values, 1e-12))) / size[:, None]


def _cr2_adjustment(leverage: Float, expected: Float) -> Float:
    """A_t (t, p, p) with A V A' = F, so that adjusted scores have the covariance expected."""
    every = expected.sum(axis=0)
    values, axes = np.linalg.eigh(expected)
    seen = values > 1e-9 * np.maximum(values[:, -1:], 1e-12)
    size = np.sqrt(np.where(seen, values, 1.0))
    onto = np.where(seen, 1 / size, 0.0)[:, None, :] * axes
    remaining = expected - leverage @ expected - expected @ leverage + leverage @ every @ leverage
    left, turned = np.linalg.eigh(onto.mT @ remaining @ onto)
    inverse = turned / np.sqrt(np.maximum(left, MIN_INFORMATION_SHARE_LEFT))[:, None, :] @ turned.mT
    return np.where(seen, size, 0.0)[:, None, :] * axes @ inverse @ onto.mT


def _single_trial_variance_share(leverage: Float, direction: Float) -> float:
    """Share of the naive variance of a direction (m,) in directions that one trial alone holds."""
    values, vectors = np.linalg.eigh(leverage)
    held = (direction @ vectors)[values > 1.0 - MIN_INFORMATION_SHARE_LEFT]
    return float(held @ held / (direction @ direction))


def _with_floored_eigenvalues(matrix: Float, min_value: float) -> Float:
    values, vectors = np.linalg.eigh(matrix)
    return (vectors * np.maximum(values, min_value)) @ vectors.T


def _satterthwaite_df(
    leverage: Float, expected: Float, adjustment: Float, direction: Float
) -> float:
    """(tr G)^2 / tr G^2, with G_ts the covariance of b_t' r_t and b_s' r_s over trials,

    b_t = A_t' c, r_t what the fit leaves of the score of trial t:
    G_ts = delta_ts b_t' F_t b_t - b_t' F_t S_s b_s - b_t' S_t F_s b_s + b_t' S_t (sum F) S_s b_s.
    """
    b = np.einsum("tqp,q->tp", adjustment, direction)
    fb, sb = (np.einsum("tpq,tq->tp", M, b) for M in (expected, leverage))
    G = np.diag(np.einsum("tp,tp->t", b, fb)) - fb @ sb.T - sb @ fb.T
    G += sb @ expected.sum(axis=0) @ sb.T
    square = float(np.sum(G * G))
    return float(np.trace(G) ** 2 / square) if square > 0 else 1.0
