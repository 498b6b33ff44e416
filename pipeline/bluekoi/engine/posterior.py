"""Posterior probabilities of causes: sets weighted by evidence, averaged over resampled trials.

Where no set of candidates is exactly right, the ratio of two sets' evidences depends on which
trials were filmed. As in pseudo-BMA+ (Yao, Vehtari, Simpson and Gelman, Bayesian Anal. 13 (2018),
917), the weights are averaged over a Bayesian bootstrap (Rubin 1981) of the trials' contributions
l_t to the log likelihood at the fit, so that a probability near 1 stands only where any sample of
trials gives it:

    log m_w(S) = log m(S) + sum_t (w_t - 1) l_t(S),   w ~ n Dirichlet(1, ..., 1)

The numbers of a set are not fitted to each sample: a set whose trials disagree would gain by it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from .problem import CauseSearchProblem
from .set_score import ScoredCauseSet

CAUSE_POSTERIOR_BOOTSTRAP_SAMPLES = 1000
"""Bootstrap samples: the Monte Carlo standard error of a probability is at most (1/4 / 1000)^1/2 =
0.016.
"""
BOOTSTRAP_SEED = 20240517
"""The same samples in each run, so that the same recordings give the same verdict."""
MAX_LOG_ODDS_KEPT = 200.0
"""Sets e^200 times less probable than the best are left out, to save time. Without the limit no
probability changes by more than 1e-4 in six studies (`python -m validation limits`); samples of
trials shift log odds by some tens.
"""


@dataclass(frozen=True)
class Posterior:
    """Probabilities (sets,) of the sets, averaged over samples of trials, and of each candidate."""

    sets: tuple[ScoredCauseSet, ...]
    probability: Float
    inclusion: dict[str, float]

    @property
    def best(self) -> ScoredCauseSet:
        """The most probable set."""
        return self.sets[int(np.argmax(self.probability))]


def posterior_over_sets(
    problem: CauseSearchProblem,
    sets: Sequence[ScoredCauseSet],
    draws: int = CAUSE_POSTERIOR_BOOTSTRAP_SAMPLES,
    max_log_odds: float = MAX_LOG_ODDS_KEPT,
) -> Posterior:
    """`Posterior` over the fitted sets; draws: bootstrap samples. max_log_odds: log odds against
    the best above which a set is left out.
    """
    useful = [s for s in sets if np.isfinite(s.log_posterior)]
    best = max(s.log_posterior for s in useful)
    useful = [s for s in useful if s.log_posterior > best - max_log_odds]
    n = len(problem.series)
    weights = n * np.random.default_rng(BOOTSTRAP_SEED).dirichlet(np.ones(n), size=draws)
    trials = np.array([s.expansion.log_likelihood for s in useful])  # (sets, trials)
    logs = np.array([s.log_posterior for s in useful]) + (weights - 1.0) @ trials.T
    share = np.exp(logs - logs.max(axis=1, keepdims=True))
    share /= share.sum(axis=1, keepdims=True)
    probability = share.mean(axis=0)
    names = {name for s in useful for name in s.causes}
    inclusion = {name: min(1.0, float(sum(p for p, s in zip(probability, useful, strict=True)
                                          if name in s.causes))) for name in names}  # fmt: skip
    return Posterior(tuple(useful), probability, inclusion)
