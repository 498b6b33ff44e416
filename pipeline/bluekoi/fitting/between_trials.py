"""Covariance of fitted parameters from the variation between trials."""

from __future__ import annotations

import numpy as np

from .normal import NormalEquationsByTrial
from .resampling import inverse_fisher
from .sandwich import ClusterCovariance, cluster_covariance

Z_95 = 1.96
"""Half the width of a 95 % interval in standard deviations: the 0.975 quantile of the standard
normal distribution."""
MAX_OVERDISPERSION = 2.0
"""Variance of the parameters between trials, over that of their naive standard errors: above it the
report warns. Trials say nothing on the overdispersion of a parameter that a single trial informs
on: the largest one without a warning is assumed."""


def cluster_robust_covariance(
    normal: NormalEquationsByTrial, free: np.ndarray
) -> ClusterCovariance:
    """Covariance (p, p) and degrees of freedom (p,) from the variation between trials; free (p,):
    which parameters are off their bounds.

    A parameter that a single trial informs on has `MAX_OVERDISPERSION` times its naive variance.
    """
    spread = cluster_covariance(normal, free)
    cov, df = spread.cov.copy(), spread.df.copy()
    alone = np.flatnonzero(free & (df == 0))
    naive = MAX_OVERDISPERSION * np.diag(inverse_fisher(normal, free))
    cov[alone, alone] = np.maximum(cov[alone, alone], naive[alone])
    df[alone] = max(len(normal.hessian) - 1, 1)
    return ClusterCovariance(cov, df)
