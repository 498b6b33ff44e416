"""Log posterior of a fitted set of causes, its discrepancy integrated out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..fitting import cov_hc2
from ..fitting.joint_fit import parameter_definition
from .cause_set_columns import CauseSetColumns, columns_of_cause_set
from .cause_set_fit import FittedCauseSet, refit_from_fitted_values
from .evidence import (
    causes_with_unfitted_discrepancy,
    log_evidence,
    log_prior,
    most_probable_discrepancy,
    most_probable_discrepancy_stds,
)
from .expansion import LikelihoodExpansion, expand_likelihood
from .noise_estimation import MAX_NOISE_ROUNDS, fit_noise_and_parameters
from .problem import CauseSearchProblem

MAX_LOG_STD_CHANGE = 0.3
"""Relative change of the discrepancy's prior deviations for which a set is not fitted again."""


@dataclass(frozen=True)
class ScoredCauseSet:
    """A fitted set with its expansion in its own numbers and discrepancy, and log posterior."""

    model: FittedCauseSet
    expansion: LikelihoodExpansion
    layout: CauseSetColumns
    log_posterior: float

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the set's causes."""
        return self.model.causes

    @property
    def log_joint(self) -> float:
        """Log likelihood at the fit with the prior of its discrepancy, less its constant: fits with
        the same prior are compared by it, others by the log posterior.
        """
        return self.model.log_joint if np.isfinite(self.log_posterior) else -np.inf

    @property
    def overdispersion(self) -> float:
        """Mean generalised design effect tr(H C) / p of the set's numbers (Rao and Scott 1981): how
        many times more they vary between trials than one Fisher matrix H says; C is HC2.
        """
        move = ~self.model.at_bound
        if not move.any():
            return 1.0
        H = self.model.fit.normal.hessian.sum(axis=0)[np.ix_(move, move)]
        C = cov_hc2(self.model.fit.normal, move)[np.ix_(move, move)]
        return float(np.trace(H @ C) / move.sum())


def refit_with_discrepancy(
    problem: CauseSearchProblem,
    scored: ScoredCauseSet,
    *,
    most: int = MAX_NOISE_ROUNDS,
    rounds: int = 1,
) -> ScoredCauseSet:
    """A set fitted together with the discrepancy of its causes and with the offsets within their
    tolerance. most: rounds of noise and parameters. rounds: fits of the discrepancy at the most
    probable shares; its prior is relative to the forces of the causes, which the fit changes.

    The first fit has the smallest shares, the next ones the most probable shares, as long as the
    evidence at the fit increases (docs/decisions/066). A fit begins at the discrepancy that the
    expansion predicts. Where it ends at a poorer fit, it is repeated from the discrepancy as it
    was. If that is no better either, the fit as it was is taken as the optimum: a gain that the
    expansion predicts and no fit reaches is not evidence.
    """
    if not (scored.expansion.is_finite and np.isfinite(scored.log_posterior)):
        return scored
    expansion, lay = scored.expansion, scored.layout
    unfitted = causes_with_unfitted_discrepancy(problem, expansion, lay)
    shares = most_probable_discrepancy_stds(expansion, lay, at_smallest=unfitted)
    predicted = most_probable_discrepancy(problem, expansion, lay, shares)
    if (
        not predicted
        or not np.isfinite(list(predicted.values())).all()
        or _was_fitted_under_prior(
            scored.model, {label: std for label, (_, std) in predicted.items()}
        )
    ):
        return scored
    found = _refit_under_discrepancy_prior(problem, scored, predicted, most=most)
    if not np.isfinite(found.log_posterior):
        return scored
    if predicted.keys() != scored.model.deviations.keys():  # the evidence so far was extrapolated
        return refit_with_discrepancy(problem, found, most=most, rounds=rounds)
    if rounds == 1 or found.log_posterior <= scored.log_posterior:
        return max(scored, found, key=lambda s: s.log_posterior)
    return refit_with_discrepancy(problem, found, most=most, rounds=rounds - 1)


def _was_fitted_under_prior(model: FittedCauseSet, stds: Mapping[str, float]) -> bool:
    """Whether a set was fitted with these prior deviations of its discrepancy, nearly."""
    known = model.deviations
    return stds.keys() == known.keys() and all(
        abs(np.log(std / known[label])) < MAX_LOG_STD_CHANGE for label, std in stds.items()
    )


def _refit_under_discrepancy_prior(
    problem: CauseSearchProblem,
    scored: ScoredCauseSet,
    predicted: Mapping[str, tuple[float, float]],
    *,
    most: int,
) -> ScoredCauseSet:
    """A set fitted with a discrepancy; where no fit gains, the set as it was under that prior.

    predicted: label -> value by the expansion, prior standard deviation.
    """
    stds = {label: std for label, (_, std) in predicted.items()}
    held = {label: scored.model.discrepancy.get(label, 0.0) for label in stds}
    before = replace(scored.model, deviations=stds, discrepancy=held, noise_is_final=False)
    for start in ({label: value for label, (value, _) in predicted.items()}, held):
        model = refit_from_fitted_values(problem, scored.model, scored.model.noise, deviations=stds,
                                         discrepancy=start)  # fmt: skip
        if model.is_finite:
            found = refit_with_reestimated_noise(
                problem, score_cause_set(problem, model), most=most
            )
            if found.log_joint >= before.log_joint:
                return found
    return score_cause_set(problem, before)


def refit_with_reestimated_noise(
    problem: CauseSearchProblem, scored: ScoredCauseSet, *, most: int = MAX_NOISE_ROUNDS
) -> ScoredCauseSet:
    """A set under its own noise where that has more evidence; otherwise unchanged.

    The noise is estimated at the fitted parameters, as if these were known. With many parameters,
    such as the weights of a discrepancy, it is underestimated (Patterson and Thompson, Biometrika
    58 (1971), 545). The evidence, in which the parameters are integrated out, decides.
    """
    model = fit_noise_and_parameters(problem, scored.model, most=most)
    if model.fit is scored.model.fit:
        return replace(scored, model=model)
    return max(scored, score_cause_set(problem, model), key=lambda s: s.log_posterior)


def score_cause_set(problem: CauseSearchProblem, model: FittedCauseSet) -> ScoredCauseSet:
    """Log posterior of a fitted set, its causes' discrepancy integrated out."""
    causes = [problem.candidate_by_name[c] for c in model.causes]
    covered = [
        c
        for c in problem.candidates
        if any(problem.cause_covers_residual_term(own, c) for own in causes)
        or any(f.name in problem.tolerances for f in c.strengths)
    ]
    expansion = make_expansion_stationary_at_fit(
        problem, expand_likelihood(problem, model, covered)
    )
    lay = columns_of_cause_set(problem, expansion, model.causes)
    value = log_evidence(problem, expansion, lay) + log_prior(problem, model.causes)
    return ScoredCauseSet(model, expansion, lay, value if np.isfinite(value) else -np.inf)


def make_expansion_stationary_at_fit(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion
) -> LikelihoodExpansion:
    """An expansion whose gradient is that of an optimum: 0 in the fitted numbers, of those at a
    bound no slope away from it, and in the fitted discrepancy what its prior balances.

    With the filter's gains held, the likelihood has a slope that no refit follows, since the gains
    and the innovations' covariance would go along. Evidence extrapolated along it is not real.
    """
    model = expansion.model
    gradient = expansion.gradient.copy()
    slopes = gradient.sum(axis=0)
    wanted = {}
    for k, (free, held) in enumerate(zip(model.fit.free, model.at_bound, strict=True)):
        inward = (
            1
            if model.fit.values[k] <= parameter_definition(problem.kernel.system, free).lower
            else -1
        )
        wanted[k] = inward * min(inward * slopes[k], 0.0) if held else 0.0
    for name, columns in expansion.strengths.items():
        for free, column in zip(problem.candidate_by_name[name].strengths, columns, strict=True):
            if free.label in model.deviations:
                std = model.deviations[free.label]
                wanted[column] = model.discrepancy.get(free.label, 0.0) / std**2
    own = list(wanted)
    excess = gradient[:, own].sum(axis=0) - np.array(list(wanted.values()))
    gradient[:, own] -= excess / len(gradient)
    return replace(expansion, gradient=gradient)
