"""Posterior probabilities of causes: sets weighted by evidence, averaged over resampled trials.

Where no set of candidates is exactly right, the ratio of two sets' evidences hangs on which trials
happened to be filmed. Bagging over trials (Huggins and Miller, Bayesian Anal. 18 (2023), 79)
averages the posterior over bootstrap samples of the trials, so that a probability near 1 stands
only where any sample of trials gives it.

Where the numbers of the most probable set vary between trials c times more (in variance) than their
standard errors allow, trials carry 1/c of the information that the likelihood says, and the
likelihood may count to the power 1/c (Rao and Scott, J. Am. Statist. Assoc. 76 (1981), 221;
Bissiri, Holmes and Walker, J. R. Statist. Soc. B 78 (2016), 1103).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from .evidence import log_evidence, log_prior
from .problem import Problem
from .search import Scored

DRAWS = 100
"""Bootstrap samples: the Monte Carlo standard error of a probability is at most (1/4 / 100)^1/2 =
0.05.
"""
SEED = 20240517
"""The same samples in each run, so that the same recordings give the same verdict."""


@dataclass(frozen=True)
class Posterior:
    """Probabilities (sets,) of the sets, bagged, and of each candidate."""

    sets: tuple[Scored, ...]
    probability: Float
    inclusion: dict[str, float]

    @property
    def best(self) -> Scored:
        """The most probable set."""
        return self.sets[int(np.argmax(self.probability))]


def posterior(
    problem: Problem, sets: Sequence[Scored], draws: int = DRAWS, *, discounted: bool = False
) -> Posterior:
    """`Posterior` over the fitted sets.

    discounted: whether the likelihood counts to the power 1/c where trials disagree; with a handful
    of trials, c is not known well enough.
    """
    useful = [s for s in sets if np.isfinite(s.log_posterior)]
    best = max(s.log_posterior for s in useful)
    useful = [s for s in useful if s.log_posterior > best - 200.0]
    n = len(problem.series)
    rng = np.random.default_rng(SEED)
    excess = max(1.0, max(useful, key=lambda s: s.log_posterior).overdispersion)
    excess = excess if discounted else 1.0
    weights = rng.multinomial(n, np.full(n, 1.0 / n), size=draws) / excess
    prior = np.array([log_prior(problem, s.causes) for s in useful])
    logs = np.array([[log_evidence(s.expansion, s.layout, w) for s in useful] for w in weights])
    logs = np.nan_to_num(logs, nan=-np.inf) + prior
    share = np.exp(logs - logs.max(axis=1, keepdims=True))
    share /= share.sum(axis=1, keepdims=True)
    probability = share.mean(axis=0)
    names = {name for s in useful for name in s.causes}
    inclusion = {name: float(sum(p for p, s in zip(probability, useful, strict=True)
                                 if name in s.causes)) for name in names}  # fmt: skip
    return Posterior(tuple(useful), probability, inclusion)
