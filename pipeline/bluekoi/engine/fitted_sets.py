"""The sets of causes that a search has fitted, each under its own noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..integrate.batch import threaded_map
from .cause_set_fit import FittedCauseSet, fit_cause_set, likeliest_strength_start
from .expansion import LikelihoodExpansion, expand_likelihood
from .problem import CauseSearchProblem
from .set_score import (
    ScoredCauseSet,
    refit_with_discrepancy,
    refit_with_reestimated_noise,
    score_cause_set,
)

MAX_LOG_ODDS_TO_REFIT = 20.0
"""Sets e^20 times less probable than the best after one round of noise and parameters are not
fitted further. From the noise of the model without causes, further rounds raise the log posterior
of a set by 257.6 at most (34 sets of five studies, `python -m validation limits`). A search loses
less, because its fits begin at the noise of a probable set."""
MAX_DISCREPANCY_ROUNDS = 4
"""Fits of a set's discrepancy under priors that are relative to the forces of the fit before. They
end where prior and forces agree, or where the evidence at the fit no longer increases; this bounds
the work."""
MAX_NESTED_LOG_LIK_LOSS = 1.0
"""A set is at least as likely as a part of it, up to the accuracy of a fit. A fit that is e^1 times
less likely has ended at a worse maximum: it is repeated from where the further cause is absent."""
MAX_LOG_ODDS_TO_REFIT_NESTED = float(np.log(3000))
"""As `MAX_LOG_ODDS_TO_REFIT`, for a set that adds a cause to a probable set and whose fit began at
the final noise of that set. Left as it is, it has posterior odds below 1 / 3000; that changes a
probability by a fiftieth of its Monte Carlo error
(`posterior.CAUSE_POSTERIOR_BOOTSTRAP_SAMPLES`)."""


@dataclass(frozen=True)
class FitRequest:
    """A set of causes to fit, begun at the values and the noise of a fitted set and, of the labels
    in start, at these. refit: also a set that has been fitted.
    """

    causes: tuple[str, ...]
    near: FittedCauseSet
    start: Mapping[str, float] = field(default_factory=dict)
    refit: bool = False

    @property
    def key(self) -> frozenset[str]:
        """The set of causes."""
        return frozenset(self.causes)


@dataclass
class FittedCauseSets:
    """All sets fitted so far."""

    problem: CauseSearchProblem
    sets: dict[frozenset[str], ScoredCauseSet] = field(default_factory=dict)
    full: dict[frozenset[str], LikelihoodExpansion] = field(default_factory=dict)
    converged: set[frozenset[str]] = field(default_factory=set)
    refits_from_noise: list[tuple[FittedCauseSet, FittedCauseSet]] = field(default_factory=list)

    @property
    def best(self) -> ScoredCauseSet:
        """The most probable set."""
        return max(self.sets.values(), key=lambda s: s.log_posterior)

    def replace_fit(self, scored: ScoredCauseSet) -> None:
        """Replace the fit of a set, and forget the expansion about the one before."""
        before = self.sets.get(scored.model.key)
        self.sets[scored.model.key] = scored
        if before is None or scored.expansion is not before.expansion:
            self.full.pop(scored.model.key, None)

    def was_refitted_from_noise_of(self, model: FittedCauseSet, source: FittedCauseSet) -> bool:
        """Whether this fit of a set has been repeated from the noise of this fit of another set."""
        return any(model is m and source is s for m, s in self.refits_from_noise)

    def fit_and_keep(self, wanted: FitRequest) -> ScoredCauseSet | None:
        """Fit a set under its own noise and keep it where it fits better than before.

        Returns: the best fit of the set so far; None where it runs away.
        """
        return self.fit_and_keep_in_threads([wanted])[0]

    def fit_and_keep_in_threads(self, wanted: Sequence[FitRequest]) -> list[ScoredCauseSet | None]:
        """As `add`, of several sets, in threads."""
        fitted = set(self.sets)
        due = []
        for one in wanted:
            if one.refit or one.key not in fitted:
                due.append(one)
                fitted.add(one.key)
        for one, found in zip(due, threaded_map(self._fit_requested_set, due), strict=True):
            before = self.sets.get(one.key)
            if found is not None and (before is None or found.log_posterior > before.log_posterior):
                self.replace_fit(found)
                self.converged.discard(one.key)
        return [self.sets.get(one.key) for one in wanted]

    def _fit_requested_set(self, wanted: FitRequest) -> ScoredCauseSet | None:
        """Fit of a set; None where it runs away."""
        problem, near, causes, key = self.problem, wanted.near, wanted.causes, wanted.key
        problem.progress(" + ".join(causes) or "baseline")
        known = {**near.fit.values_by_label(), **wanted.start}
        for cause in key - near.key:
            known |= likeliest_strength_start(problem, near, cause)
        left = self.transferable_discrepancy(near, key)
        stds = {label: std for label, std in near.deviations.items() if label in left}
        effects = near.fitted_trial_effects(problem)
        model = fit_cause_set(problem, causes, near.noise, known, discrepancy=left,
                              deviations=stds, effects=effects)  # fmt: skip
        if near.key < key and model.log_joint < near.log_joint - MAX_NESTED_LOG_LIK_LOSS:
            absent = {f.label: 0.0 for cause in key - near.key
                      for f in problem.candidate_by_name[cause].strengths}  # fmt: skip
            model = fit_cause_set(problem, causes, near.noise, {**known, **absent},
                                  discrepancy=left, deviations=stds, effects=effects)  # fmt: skip
        if not model.is_finite:
            return None
        plain = score_cause_set(problem, model)
        found = refit_with_discrepancy(problem, plain, most=1)
        if found is plain:
            found = refit_with_reestimated_noise(problem, plain, most=1)
        return found

    def transferable_discrepancy(
        self, near: FittedCauseSet, causes: frozenset[str]
    ) -> dict[str, float]:
        """What the formulas of another set's causes leave that these causes may leave as well, and
        the offsets within their tolerance.
        """
        by_name = self.problem.candidate_by_name
        covered = {
            f.label
            for term in self.problem.candidates
            if term.name not in causes
            and any(self.problem.cause_covers_residual_term(by_name[c], term) for c in causes)
            for f in term.strengths
        }
        covered |= {f.label for c in self.problem.candidates if c.name not in causes
                    for f in c.strengths if f.name in self.problem.tolerances}  # fmt: skip
        return {label: v for label, v in near.discrepancy.items() if label in covered}

    def converge(self) -> None:
        """Fit noise and numbers of the probable sets until they no longer improve: of the most
        probable one first, since it decides which others are; then of these side by side.
        """
        while todo := [
            k for k, s in self.sets.items() if k not in self.converged
            and s.log_posterior > self.best.log_posterior - self._max_log_odds_to_refit(k)
        ]:  # fmt: skip
            best = self.best.model.key
            keys = [best] if best in todo else todo
            self.converged.update(keys)
            for found in threaded_map(lambda k: _fit_until_converged(self.problem, self.sets[k]),
                                      keys):  # fmt: skip
                self.replace_fit(found)

    def _max_log_odds_to_refit(self, key: frozenset[str]) -> float:
        """How much less probable than the best a set may be for its fit to be continued."""
        likely = self.best.log_posterior - MAX_LOG_ODDS_TO_REFIT_NESTED
        nested = any(other < key and self.sets[other].log_posterior > likely
                     for other in self.converged)  # fmt: skip
        return MAX_LOG_ODDS_TO_REFIT_NESTED if nested else MAX_LOG_ODDS_TO_REFIT

    def expansion_in_all_candidates(self, scored: ScoredCauseSet) -> LikelihoodExpansion:
        """Expansion about a set in the numbers of all candidates."""
        key = scored.model.key
        if key not in self.full:
            self.full[key] = expand_likelihood(self.problem, scored.model)
        return self.full[key]


def _fit_until_converged(problem: CauseSearchProblem, scored: ScoredCauseSet) -> ScoredCauseSet:
    """A set whose noise, numbers and discrepancy are fitted in turn until none improves."""
    found = refit_with_reestimated_noise(problem, scored)
    return refit_with_discrepancy(problem, found, rounds=MAX_DISCREPANCY_ROUNDS)
