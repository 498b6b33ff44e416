"""Residual terms that are collinear with a listed cause.

A residual term stands for a force that no listed cause describes. Where a named form of a cause
has nearly the same force, in the same channel and as a function of the same variable, the trials
cannot tell the two apart, and the term would only take the place of the cause. With H, the
information matrix of the trials in the coefficients c of the model, the term i and the strength j
of the form, the form explains the share

    R^2 = P_ij^2 / (P_ii P_jj),   P = H - H_c (H_cc)^-1 H_c'

of the information on the term that is left after the best fit of the coefficients.
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from .expansion import LikelihoodExpansion, TriedForms
from .problem import CauseSearchProblem

MAX_VARIANCE_INFLATION = 10.0
"""Variance inflation factor 1 / (1 - R^2) above which two regressors count as collinear (Marquardt,
Technometrics 12 (1970), 591). Fitted together, their standard errors are then more than 10^1/2
times larger than fitted alone: a force of z standard errors differs from the form by z / 3 at most.
"""


def collinear_terms(
    problem: CauseSearchProblem, whole: LikelihoodExpansion, tried: TriedForms
) -> frozenset[str]:
    """Residual terms that are collinear with a form of a listed cause of the same channel and
    variable; tried: forms of all candidates.
    """
    P = _schur_complement(whole.hessian.sum(axis=0), list(whole.own))
    listed = [
        (problem.candidate_by_name[name], columns)
        for name, forms in tried.items()
        if not problem.candidate_by_name[name].is_residual
        for _, columns in forms
    ]
    out = set()
    for name, forms in tried.items():
        term = problem.candidate_by_name[name]
        if term.is_residual and len(forms) == 1 and len(forms[0][1]) == 1:
            (i,) = forms[0][1]
            own = [j for cause, columns in listed if cause.sources & term.sources for j in columns]
            least = 1.0 - 1.0 / MAX_VARIANCE_INFLATION  # of R^2
            if any(P[i, j] ** 2 > least * P[i, i] * P[j, j] for j in own):
                out.add(name)
    return frozenset(out)


def _schur_complement(H: Float, own: list[int]) -> Float:
    """Information matrix after the best fit of the numbers in the columns `own`; positive."""
    P: Float = H - H[:, own] @ np.linalg.pinv(H[np.ix_(own, own)]) @ H[own, :]
    empty = np.diag(P) <= 1e-9 * np.diag(H)  # what the coefficients take up entirely
    P[empty], P[:, empty] = 0.0, 0.0
    return P
