"""Covariance of a two-step fit: the errors of the first step enter the second (Murphy and Topel).

With the later step's Fisher matrix in blocks of its own numbers s and the earlier ones b, other
values of b move its numbers by G db, G = -H_ss^-1 H_sb; G cov_b G' is added to their covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Float
from ..fitting import (
    TrialSeries,
    off_bounds,
    sensitivity_to_other_parameters,
    trial_normal_equations,
)
from ..fitting.sandwich import MAX_SINGLE_TRIAL_SHARE
from .joint_fit import JointFit
from .similar_robots import compiled_trial_system


def sensitivity_to_earlier_step(
    series: Sequence[TrialSeries], later: JointFit, earlier: JointFit
) -> Float:
    """G (p, q): response of the later fit, of these trials, to the earlier one's q numbers."""
    kernel, p = compiled_trial_system(series), len(later.fit.values)
    out = np.zeros((p, len(earlier.fit.values)))
    free = (*later.fit.free, *earlier.fit.free)
    at = np.concatenate([later.fit.values, earlier.fit.values])
    normal = trial_normal_equations(kernel, series, later.base, free, at, noise=later.noise)
    own = np.flatnonzero(off_bounds(later.fit)).tolist()
    if normal.all_finite and own:
        out[own] = sensitivity_to_other_parameters(
            normal.hessian.sum(axis=0), own, range(p, len(free))
        )
    return out


def with_earlier_step_covariance(
    later: JointFit, earlier: JointFit, sensitivity: Float
) -> JointFit:
    """The later fit with the earlier one's covariance in its own, sensitivity = G.

    Degrees of freedom of a sum of two variances by Satterthwaite, v^2 / f = v1^2 / f1 + v2^2 / f2;
    none where one of the two, and more than `MAX_SINGLE_TRIAL_SHARE` of the sum, cannot be judged.
    """
    added = sensitivity @ earlier.cov @ sensitivity.T
    cov = later.cov + added
    before, after = np.diag(later.cov), np.diag(added)
    own = later.covariance.df
    other = np.array([earlier.covariance.df_of(row) if row.any() else 0.0 for row in sensitivity])
    unsure = (own <= 0) | ((other <= 0) & (after > MAX_SINGLE_TRIAL_SHARE * np.diag(cov)))
    parts = before**2 / np.maximum(own, 1.0) + after**2 / np.maximum(other, 1.0)
    df = np.diag(cov) ** 2 / np.where(parts > 0, parts, 1.0)
    return replace(later, cov=cov, df=np.where(unsure, 0.0, df), influence=None)
