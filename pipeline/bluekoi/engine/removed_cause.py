"""Evidence of a set without one of its causes, from the expansion about the set.

A set and the set without a cause are nested: the strengths of the cause, its forms and the
discrepancy that it alone explains leave the quadratic expansion.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .cause_set_columns import CauseSetColumns
from .evidence import (
    information_matrix_and_gradient,
    laplace_log_evidence,
    log_prior,
    prior_precision_at_fit,
)
from .expansion import LikelihoodExpansion
from .problem import CauseSearchProblem


def log_odds_without_cause(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, lay: CauseSetColumns, cause: str
) -> float:
    """Log posterior odds of a fitted set without one of its causes against the set, extrapolated
    from the expansion about the set, at the shares of its fit.

    Strengths that are known to a tolerance remain, as offsets within it.
    """
    H, g = information_matrix_and_gradient(expansion, lay)
    fitted = replace(lay, precision=prior_precision_at_fit(problem, expansion, lay))
    rest, kept = _columns_without_cause(problem, expansion, fitted, cause)
    step = np.where(kept, 0.0, -lay.at)
    without = laplace_log_evidence(H[np.ix_(kept, kept)], (g - H @ step)[kept], rest)
    change = float(g @ step - 0.5 * step @ H @ step)
    return change + without - laplace_log_evidence(H, g, fitted) - log_prior(problem, [cause])


def _columns_without_cause(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, lay: CauseSetColumns, cause: str
) -> tuple[CauseSetColumns, np.ndarray]:
    """Columns of a set without a cause, and which of the set's columns (p,) these are."""
    labels, tolerances = expansion.model.fit.free, problem.tolerances
    own = {
        i
        for i, f in enumerate(labels)
        if f in problem.candidate_by_name[cause].strength_and_form_parameters
    }
    tolerated = np.array([i in own and labels[i].name in tolerances for i in lay.columns])
    none = np.zeros(len(lay.columns))
    others = [stds for name, stds in lay.discrepancy.items() if name != cause]
    alone = (lay.discrepancy.get(cause, none) > 0) & ~np.any([none, *others], axis=0)
    kept = ~((np.isin(lay.columns, list(own)) & ~tolerated) | alone)
    precision = lay.precision.copy()
    precision[tolerated] = [tolerances[labels[i].name] ** -2.0 for i in lay.columns[tolerated]]
    position = np.cumsum(kept) - 1
    rest = replace(
        lay, columns=lay.columns[kept], precision=precision[kept], at=lay.at[kept],
        gaussian=(lay.gaussian | tolerated)[kept], included=lay.included[kept],
        held=(lay.held & ~tolerated)[kept], discrepancy={},
        blocks={name: position[block] for name, block in lay.blocks.items() if name != cause},
    )  # fmt: skip
    return rest, kept
