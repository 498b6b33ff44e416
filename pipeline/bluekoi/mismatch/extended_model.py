"""The model with the named causes, with covariances from the variation between trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..engine import (
    CauseSearchProblem,
    FittedCauseSet,
    ScoredCauseSet,
    off_bounds_mask,
    refit_without_discrepancy,
)
from ..fitting import Z_95, TrialSeries, cluster_robust_covariance
from ..tuning import JointFit

CauseSetAndJointFit = tuple[FittedCauseSet, JointFit]
"""A set fitted by its formulas alone, and that with covariances."""
EstimateByLabel = dict[str, tuple[float, float]]
"""Label of a parameter -> value, standard deviation."""


def fit_extended(
    problem: CauseSearchProblem,
    train: Sequence[TrialSeries],
    baseline: JointFit,
    best: ScoredCauseSet,
) -> tuple[CauseSetAndJointFit, FittedCauseSet]:
    """Models of a set of causes and the fit of the first; train: the trials that are fitted, at the
    rate of the fit. Without causes the model with covariances is the baseline.
    """
    model = refit_without_discrepancy(replace(problem, series=tuple(train)), best.model)
    model = model if model.is_finite else refit_without_discrepancy(problem, best.model)
    extended = with_between_trial_covariance(baseline, model) if best.causes else baseline
    return (model, extended), model


def estimates_by_label(model: JointFit) -> EstimateByLabel:
    """Value of each parameter and the standard deviation of a normal distribution with its 95 %
    interval, by label.
    """
    std = 0.5 * np.diff(model.interval_95, axis=1)[:, 0] / Z_95
    return {f.label: (float(value), float(s))
            for f, value, s in zip(model.fit.free, model.fit.values, std, strict=True)}  # fmt: skip


def with_between_trial_covariance(baseline: JointFit, model: FittedCauseSet) -> JointFit:
    """A fitted set with covariances from the variation between trials."""
    spread = cluster_robust_covariance(model.fit.normal, off_bounds_mask(model))
    return JointFit(model.fit, model.noise, spread.cov, baseline.base, spread.df, None)
