"""Plausible magnitudes of residual terms, which no physical statement gives."""

from __future__ import annotations

import numpy as np

from .cause_set_columns import plausible_strengths
from .expansion import LikelihoodExpansion
from .problem import CauseSearchProblem


def plausible_residual_magnitudes(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion
) -> dict[str, tuple[float, ...]]:
    """Plausible magnitudes of each residual term: as visible as the median named cause at its own.

    expansion: about the model without causes. With G the information on a strength when the
    coefficients are profiled, m_residual = median(m_k G_k^1/2) / G_residual^1/2.
    """
    H, own = expansion.hessian.sum(axis=0), list(expansion.own)

    def root(column: int) -> float:
        cross = H[own, column]
        left = (
            H[column, column] - cross @ np.linalg.lstsq(H[np.ix_(own, own)], cross, rcond=1e-10)[0]
        )
        return float(np.sqrt(max(left, 1e-6 * H[column, column], 1e-30)))

    named = [plausible_strengths(problem, c.name)[0] * root(expansion.strengths[c.name][0])
             for c in problem.candidates
             if not c.is_residual and len(c.strengths) == 1]  # fmt: skip
    usual = float(np.median(named)) if named else 1.0
    return {c.name: tuple(usual / root(i) for i in expansion.strengths[c.name])
            for c in problem.candidates if c.is_residual}  # fmt: skip
