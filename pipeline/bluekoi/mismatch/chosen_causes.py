"""Which causes are named, and the model with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..engine import (
    FittedSet,
    NamedCause,
    Posterior,
    Problem,
    ScoredSet,
    best_set,
    causes_of_no_size,
    named_causes,
    off_bounds_mask,
    without_discrepancy,
)
from ..engine.naming import MIN_NAMED_PROBABILITY, Z_95
from ..fitting import Series, cluster_covariance, inverse_fisher
from ..tuning import JointFit

SINGLE_TRIAL_VARIANCE_FACTOR = 2.0
"""Trials cannot disagree on a number that one of them alone informs on: its naive variance counts
twice, the overdispersion above which the report warns."""


@dataclass(frozen=True)
class ChosenCauses:
    """named: causes that are more probable than not and have a size, in the order of the most
    probable set; sizeless: probable causes whose strengths may all be 0. unexplained: probability
    of a force that no candidate describes. best: the most probable set of the named causes; model:
    it fitted by its formulas alone; extended: that with covariances.
    """

    named: list[NamedCause]
    sizeless: list[NamedCause]
    unexplained: float
    best: ScoredSet
    model: FittedSet
    extended: JointFit


def choose_causes(
    problem: Problem, train: Sequence[Series], baseline: JointFit, found: Posterior
) -> ChosenCauses:
    """`ChosenCauses` of a search; train: the trials that the model is fitted to, at the rate of the
    fit. The extended model is the baseline where nothing acts.
    """
    named, unexplained = named_causes(found, problem.by_name)
    sizeless: list[NamedCause] = []
    while True:
        names = [c.name for c in named]
        best = best_set(found, names, unexplained > MIN_NAMED_PROBABILITY, problem.by_name)
        model = without_discrepancy(replace(problem, series=tuple(train)), best.model)
        model = model if model.usable else without_discrepancy(problem, best.model)
        extended = with_between_trial_covariance(baseline, model) if best.causes else baseline
        found_sizeless = causes_of_no_size(named, problem.by_name, estimates(extended))
        if not found_sizeless:
            return ChosenCauses(named, sizeless, unexplained, best, model, extended)
        sizeless += found_sizeless
        named = [c for c in named if c not in sizeless]


def estimates(model: JointFit) -> dict[str, tuple[float, float]]:
    """Value of each number, by label, and the standard deviation of a normal distribution with its
    95 % interval.
    """
    std = 0.5 * np.diff(model.interval_95, axis=1)[:, 0] / Z_95
    return {f.label: (float(value), float(s))
            for f, value, s in zip(model.fit.free, model.fit.values, std, strict=True)}  # fmt: skip


def with_between_trial_covariance(baseline: JointFit, model: FittedSet) -> JointFit:
    """A fitted set with covariances from how its trials disagree."""
    free = off_bounds_mask(model)
    spread = cluster_covariance(model.fit.normal, free)
    cov, df = spread.cov.copy(), spread.df.copy()
    alone = np.flatnonzero(free & (df == 0))  # one trial informs on it: its naive variance
    naive = SINGLE_TRIAL_VARIANCE_FACTOR * np.diag(inverse_fisher(model.fit.normal, free))
    cov[alone, alone] = np.maximum(cov[alone, alone], naive[alone])
    df[alone] = max(len(model.fit.normal.hessian) - 1, 1)
    return JointFit(model.fit, model.noise, cov, baseline.base, df, None)
