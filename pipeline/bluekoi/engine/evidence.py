"""Marginal likelihood of a set of causes, by Laplace's approximation at a fitted set.

The numbers of a set are its coefficients b (flat prior, profiled), the strengths s_k of its causes,
their functional forms f ~ N(leading form, spread^2), and a discrepancy d ~ N(0, tau^2): residual
terms in the channels of one of its causes. tau is a share of the force of the cause
(`set_columns.PRIOR_RELATIVE_DISCREPANCY_STDS`), over which m(S) is averaged. With gradient g and
information H of the likelihood, prior precision P, deviations x of f and d from the means of their
priors, g_P = g - P x, n strengths, and G the Schur complement of H + P that is left when b is
profiled,

    log m(S) = log L - 1/2 x' P x + 1/2 g_P' (H + P)^-1 g_P + 1/2 log|P| - 1/2 log|G|
               + n/2 log 2 pi + sum_k log p(s_k)

At a fit, g_P is 0 in the fitted numbers.

The strengths of each cause have a Cauchy prior (Jeffreys 1961, sec. 5.2) as wide as its plausible
magnitude, which its file states: an effect far smaller than plausible costs what its precision
costs, log(magnitude / standard error). Where one sign alone is possible, the half of it, and the
posterior's share on that side.

A number held at a bound that the gradient pushes against has no standard error; the likelihood
falls inside the bound, the faster the more it pushes, and the integral of this takes its place
(`_log_truncated_gaussian_integrals`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.special import erfcx, gammaln, log_ndtr, logsumexp

from ..data import Float
from .cause_set_columns import (
    MIN_INFORMATION,
    MIN_RELATIVE_DISCREPANCY_STD,
    CauseSetColumns,
    discrepancy_std_combinations,
    prior_precisions_given_stds,
)
from .expansion import LikelihoodExpansion
from .problem import CauseSearchProblem

DIAGONAL_RIDGE = 1e-10
"""Added to the information, scaled to a diagonal of ones: a normal prior of 1e5 conditional
standard errors on each number, so wide that it has no part in the evidence. Numbers that no trial
tells apart, and that have no prior of their own, stay invertible: it is 4e5 rounding errors."""
LINEAR_SOLVE_BATCH_SIZE = 64
"""Combinations of shares whose matrices are solved in one call. It bounds the memory and has no
part in the result."""
LOG_PROBABILITY_OF_IMPOSSIBLE = -50.0
"""Log probability of a cause whose strength is held at 0. Finite, so that differences are
defined, and so low that no such set is named."""


def log_evidence(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, lay: CauseSetColumns
) -> float:
    """Log m(S) of a set, averaged over the shares of the discrepancies of its causes.

    Evidence at other shares than those of the fit is extrapolated, and is not counted above that at
    the shares of the fit (docs/decisions/066).
    """
    combinations = discrepancy_std_combinations(lay)
    given = prior_precisions_given_stds(lay, combinations)
    values = _log_evidences(
        expansion, lay, np.vstack([given, prior_precision_at_fit(problem, expansion, lay)])
    )
    return float(logsumexp(np.minimum(values[:-1], values[-1])) - np.log(len(combinations)))


def prior_precision_at_fit(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, lay: CauseSetColumns
) -> Float:
    """Prior precision (p,) of the columns under which the set was fitted; of a discrepancy that was
    not fitted, that at the smallest share.
    """
    smallest = dict.fromkeys(lay.discrepancy, MIN_RELATIVE_DISCREPANCY_STD)
    out = prior_precisions_given_stds(lay, [smallest])[0]
    labels, fitted = _labels_of_discrepancy_columns(problem, expansion), expansion.model.deviations
    for k, column in enumerate(lay.columns):
        if lay.gaussian[k] and (std := fitted.get(labels.get(int(column), ""))):
            out[k] = std**-2.0
    return out


def log_evidence_given_discrepancy_stds(
    expansion: LikelihoodExpansion, lay: CauseSetColumns, shares: Mapping[str, float]
) -> float:
    """Log m(S) of a set with given shares of the discrepancies of its causes."""
    return float(_log_evidences(expansion, lay, prior_precisions_given_stds(lay, [shares]))[0])


def most_probable_discrepancy_stds(
    expansion: LikelihoodExpansion, lay: CauseSetColumns, *, at_smallest: Collection[str] = ()
) -> dict[str, float]:
    """Cause -> the share of its discrepancy with which the set has the largest evidence.

    at_smallest: causes that are given the smallest share.
    """
    every = [one for one in discrepancy_std_combinations(lay)
             if all(one[c] == MIN_RELATIVE_DISCREPANCY_STD for c in at_smallest)]  # fmt: skip
    values = _log_evidences(expansion, lay, prior_precisions_given_stds(lay, every))
    return max(zip(values.tolist(), every, strict=True), key=lambda both: both[0])[1]


def information_matrix_and_gradient(
    expansion: LikelihoodExpansion, lay: CauseSetColumns
) -> tuple[Float, Float]:
    """Information (p, p) and gradient (p,) of the likelihood of all trials in a set's columns."""
    columns = lay.columns
    H, g = expansion.hessian.sum(axis=0), expansion.gradient.sum(axis=0)
    return H[np.ix_(columns, columns)], g[columns]


def laplace_log_evidence(H: Float, g: Float, lay: CauseSetColumns) -> float:
    """What the numbers of a set add to the log likelihood: best step, Occam factor and priors.

    H (p, p), g (p,): information and gradient of the likelihood in the columns of the layout.
    """
    return float(_laplace_log_evidences(H, g, lay, lay.precision[None])[0])


def _log_evidences(expansion: LikelihoodExpansion, lay: CauseSetColumns, given: Float) -> Float:
    """Log m(S) (n,) of a set with each of the prior precisions (n, p) of its columns."""
    H, g = information_matrix_and_gradient(expansion, lay)
    found = [_laplace_log_evidences(H, g, lay, given[k : k + LINEAR_SOLVE_BATCH_SIZE])
             for k in range(0, len(given), LINEAR_SOLVE_BATCH_SIZE)]  # fmt: skip
    return np.asarray(expansion.log_likelihood.sum() + np.concatenate(found))


def _laplace_log_evidences(H: Float, g: Float, lay: CauseSetColumns, given: Float) -> Float:
    """`laplace_log_evidence` (n,) with each of the prior precisions (n, p) in place of the
    layout's.
    """
    index = np.flatnonzero(~lay.held)
    precision = np.where(lay.included, 0.0, given)
    off = np.where(lay.gaussian & ~lay.included, lay.at, 0.0)  # from the mean of their prior, 0
    slopes = g - precision * off
    A = np.repeat(H[np.ix_(index, index)][None], len(given), axis=0)
    diagonal = np.arange(len(index))
    A[:, diagonal, diagonal] += precision[:, index]
    scale = 1.0 / np.sqrt(np.maximum(A[:, diagonal, diagonal], 1e-30))
    A *= scale[:, :, None] * scale[:, None, :]
    A[:, diagonal, diagonal] += DIAGONAL_RIDGE
    step = np.zeros_like(slopes)
    step[:, index] = scale * np.linalg.solve(A, (scale * slopes[:, index])[:, :, None])[:, :, 0]
    # the width of the Cauchy prior regularises the step; it does not pull a strength to 0
    pull = np.where(lay.gaussian, 0.0, given)
    gain = 0.5 * np.sum(slopes * step + pull * step**2 - precision * off**2, axis=1)
    if len(lay.at) == lay.count:
        return np.asarray(gain)
    cov = np.linalg.inv(A) * scale[:, :, None] * scale[:, None, :]
    own = index >= lay.count
    rest = index[own]
    if own.any():
        whole = cov[:, own][:, :, own]  # G^-1
        with np.errstate(invalid="ignore"):  # of a set with which a trial runs away: NaN
            gain += 0.5 * np.linalg.slogdet(whole)[1]
        gain += 0.5 * np.log(given[:, rest][:, lay.gaussian[rest]]).sum(axis=1)
    held = np.flatnonzero(lay.held & (np.arange(len(lay.at)) >= lay.count))
    across = H[np.ix_(held, index)]
    widths = _log_truncated_gaussian_integrals(
        slopes[:, held] - step[:, index] @ across.T,
        np.diag(H)[held] + precision[:, held] - np.einsum("hf,nfg,hg->nh", across, cov, across),
    )
    gaussian = lay.gaussian[held]
    gain += widths[:, gaussian].sum(axis=1)
    gain += 0.5 * np.log(given[:, held[gaussian]] / (2.0 * np.pi)).sum(axis=1)
    for cause in lay.blocks:
        gain += _log_strength_prior(cause, cov[:, own][:, :, own], rest, step, lay)
        gain += widths[:, np.isin(held, lay.blocks[cause])].sum(axis=1)
    return np.asarray(gain)


def _log_truncated_gaussian_integrals(slopes: Float, curvatures: Float) -> Float:
    """Log of the widths (n, h) that the likelihood has inside the bounds at which numbers are held.

    Inside its bound by t, the log likelihood of such a number is lower by a t + b t^2 / 2, a its
    slope and b its curvature where the free numbers follow:

        w = integral over t > 0 of exp(-a t - b t^2 / 2) = sqrt(pi / 2 b) erfcx(a / sqrt(2 b))
    """
    a, b = np.abs(slopes), np.maximum(curvatures, MIN_INFORMATION)
    return np.asarray(0.5 * np.log(0.5 * np.pi / b) + np.log(erfcx(a / np.sqrt(2.0 * b))))


def _log_strength_prior(
    cause: str, cov: Float, rest: np.ndarray, step: Float, lay: CauseSetColumns
) -> Float | float:
    """Log p(s) + k/2 log 2 pi of a cause's best strengths (n,), k of which are free; see
    `laplace_log_evidence`.

    Strengths that are all held at 0 make the cause absent: e^-50, for no set is named for it.
    """
    block = lay.blocks[cause]
    free = np.isin(block, rest)
    values = lay.at[block] + step[:, block]
    if not free.any() and not values.any():
        return LOG_PROBABILITY_OF_IMPOSSIBLE
    side: Float | float = 0.0
    if lay.signed[cause]:
        side = np.log(2.0)
        if free[0]:
            at = int(np.flatnonzero(rest == block[0])[0])
            side += log_ndtr(values[:, 0] / np.sqrt(cov[:, at, at]))
    log_volume = 0.5 * int(free.sum()) * float(np.log(2.0 * np.pi))
    return np.asarray(_log_cauchy(values, lay.sizes[cause]) + log_volume + side)


def _log_cauchy(values: Float, sizes: Float) -> Float:
    """Log density (...) of the Cauchy distribution with these widths (k,) at values (..., k)."""
    k = len(sizes)
    return np.asarray(
        gammaln(0.5 * (k + 1))
        - 0.5 * (k + 1) * np.log(np.pi)
        - np.log(sizes).sum()
        - 0.5 * (k + 1) * np.log1p(np.sum((values / sizes) ** 2, axis=-1))
    )


def log_prior(problem: CauseSearchProblem, causes: Sequence[str]) -> float:
    """Log prior probability of a set, relative to that of no cause."""
    odds = [
        problem.candidate_by_name[c].prior / (1.0 - problem.candidate_by_name[c].prior)
        for c in causes
    ]
    return float(np.log(odds).sum())


def most_probable_discrepancy(
    problem: CauseSearchProblem,
    expansion: LikelihoodExpansion,
    lay: CauseSetColumns,
    shares: Mapping[str, float],
) -> dict[str, tuple[float, float]]:
    """Label -> most probable value of a residual term as a discrepancy of the set's causes, or of
    an offset within its tolerance, and its prior standard deviation at these shares.
    """
    H, g = information_matrix_and_gradient(expansion, lay)
    given = prior_precisions_given_stds(lay, [shares])[0]
    precision = np.where(lay.included, 0.0, given)
    prior = np.where(lay.gaussian & ~lay.included, lay.at, 0.0)
    free = ~lay.held
    A = (H + np.diag(precision))[np.ix_(free, free)]
    step = np.zeros(len(g))
    step[free] = np.linalg.lstsq(A, (g - precision * prior)[free], rcond=1e-10)[0]
    labels = _labels_of_discrepancy_columns(problem, expansion)
    return {labels[i]: (float(lay.at[k] + step[k]), float(given[k] ** -0.5))
            for k, i in enumerate(lay.columns) if i in labels and lay.gaussian[k]}  # fmt: skip


def causes_with_unfitted_discrepancy(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, lay: CauseSetColumns
) -> set[str]:
    """Causes of a set whose discrepancy has weights that were not fitted."""
    labels, fitted = _labels_of_discrepancy_columns(problem, expansion), expansion.model.deviations
    return {cause for cause, deviations in lay.discrepancy.items()
            if any(labels[i] not in fitted for i in lay.columns[deviations > 0])}  # fmt: skip


def _labels_of_discrepancy_columns(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion
) -> dict[int, str]:
    """Column of an expansion -> label of the residual term or of the offset within a tolerance."""
    return {
        column: free.label
        for name, columns in expansion.strengths.items()
        for free, column in zip(problem.candidate_by_name[name].strengths, columns, strict=True)
        if problem.candidate_by_name[name].is_residual or free.name in problem.tolerances
    }  # fmt: skip
