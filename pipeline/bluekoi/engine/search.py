"""Search of the sets of causes that have posterior probability.

Around the most probable set so far, the second-order expansion scores every further cause; the best
are refitted, with all their functional forms and their own noise; so are the sets that lack one of
the causes, and around these again the best replacements. Other probable sets are fitted without one
of their causes, where the expansion does not exclude that. The search ends where none of this finds
another, more probable set. (Shotgun stochastic search without the dice: Hans, Dobra and West, JASA
102 (2007), 507.) Of a large study the search uses the trials that say most; the probable sets are
then fitted to all trials, and what the expansion about the best adds there.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ..integrate.batch import threaded_map
from .cause_set_fit import FittedCauseSet, refit_from_fitted_values
from .collinear_terms import collinear_terms
from .expansion import (
    expand_likelihood,
    expand_likelihood_in_all_forms,
    restricted_to_likeliest_forms,
)
from .fitted_sets import (
    MAX_LOG_ODDS_TO_REFIT,
    MAX_LOG_ODDS_TO_REFIT_NESTED,
    FitRequest,
    FittedCauseSets,
)
from .noise_estimation import (
    MIN_LOG_LIKELIHOOD_GAIN_PER_ROUND,
    fit_without_causes,
    log_likelihood_gain_under_noise,
)
from .problem import MAX_SEARCH_TRIALS, CauseSearchProblem
from .proposals import (
    MIN_REFITS_PER_SET,
    fit_causes_in_place_of_residual_terms,
    fit_requests_adding_cause,
    fit_requests_at_low_process_noise,
    fit_requests_replacing_cause,
)
from .removed_cause import log_odds_without_cause
from .residual_magnitudes import plausible_residual_magnitudes
from .set_score import (
    ScoredCauseSet,
    refit_with_discrepancy,
    refit_with_reestimated_noise,
    score_cause_set,
)
from .trial_subset import d_optimal_trial_subset

MIN_LOG_POSTERIOR_GAIN = 1.0
"""The search goes on about a set that is e^1 times more probable than the last one; sets that are
nearly as probable have nearly the same neighbours."""
MAX_FURTHER_SETS_VERIFIED = 4
"""How many further sets of a subset of the trials are fitted to all of them, besides the best and
those that lack one of its causes. It bounds the work; sets left out have no probability."""


def search_cause_sets(
    problem: CauseSearchProblem, start: dict[str, float] | None = None
) -> FittedCauseSets:
    """All sets that a search fitted.

    Of more than `MAX_SEARCH_TRIALS` trials a subset is searched, and the probable sets are fitted
    again to all trials.
    """
    if len(problem.series) <= MAX_SEARCH_TRIALS:
        return _search_on_trials(problem, start or {})
    plain = fit_without_causes(problem, start or {}, most=0)
    part = d_optimal_trial_subset(expand_likelihood(problem, plain).hessian, MAX_SEARCH_TRIALS)
    few = replace(problem, series=tuple(problem.series[i] for i in part))
    return _verify_on_all_trials(problem, _search_on_trials(few, plain.fit.values_by_label()))


def _verify_on_all_trials(problem: CauseSearchProblem, few: FittedCauseSets) -> FittedCauseSets:
    """The probable sets of a subset of the trials and the model without causes, fitted to all of
    them with what these add.
    """
    visited = FittedCauseSets(replace(few.problem, series=problem.series))
    known = (few.sets[frozenset()], *_sets_to_verify(few))
    visited.fit_and_keep_in_threads([FitRequest(scored.causes, scored.model) for scored in known])
    visited.converge()
    done: set[frozenset[str]] = set()
    while (best := visited.best).model.key not in done:
        done.add(best.model.key)
        if len(best.causes) < problem.most_causes:
            visited.fit_and_keep_in_threads(
                fit_requests_adding_cause(visited, best, MIN_REFITS_PER_SET)
            )
        visited.fit_and_keep_in_threads(
            [FitRequest(rest, best.model) for rest in _cause_sets_with_one_removed(best)]
        )
        visited.fit_and_keep_in_threads(_fit_requests_without_one_cause(visited))
        visited.converge()
    return visited


def _sets_to_verify(few: FittedCauseSets) -> list[ScoredCauseSet]:
    """The most probable set, those that lack one of its causes, and the next probable ones."""
    best = few.best
    lacking = [few.sets[k] for c in best.causes if (k := best.model.key - {c}) in few.sets]
    others = [s for s in few.sets.values() if s is not best and s not in lacking
              and s.log_posterior > best.log_posterior - MAX_LOG_ODDS_TO_REFIT]  # fmt: skip
    others = sorted(others, key=lambda s: -s.log_posterior)[:MAX_FURTHER_SETS_VERIFIED]
    return [best, *(s for s in lacking if np.isfinite(s.log_posterior)), *others]


def _search_on_trials(problem: CauseSearchProblem, start: dict[str, float]) -> FittedCauseSets:
    """All sets that were worth a fit.

    Raises: LinAlgError where the model without causes has no finite fit.
    """
    first = fit_without_causes(problem, start)
    problem.check_baseline(first.noise, first.passes)
    whole, tried = expand_likelihood_in_all_forms(problem, first)
    if not whole.is_finite:
        raise np.linalg.LinAlgError("the model without causes runs away")
    expansion = restricted_to_likeliest_forms(problem, whole, tried)
    problem = replace(problem, collinear_terms=collinear_terms(problem, whole, tried),
                      residual_sizes=plausible_residual_magnitudes(problem, expansion))  # fmt: skip
    visited = FittedCauseSets(problem)
    visited.sets[frozenset()] = refit_with_discrepancy(problem, score_cause_set(problem, first))
    best, before, explored = visited.best, -np.inf, set[frozenset[str]]()
    while best.log_posterior > before + MIN_LOG_POSTERIOR_GAIN and best.model.key not in explored:
        before = best.log_posterior
        if not _add_further_causes(visited, best):
            explored.add(best.model.key)
            _remove_and_replace_causes(visited, best)
            _refit_with_shared_noise(visited)
        best = visited.best
    return visited


def _add_further_causes(visited: FittedCauseSets, best: ScoredCauseSet) -> bool:
    """Fit the best set with a further cause; where none is more probable, also begun under small
    random forces. Returns: whether a more probable set was found.
    """
    if len(best.causes) >= visited.problem.most_causes:
        return False
    for further in (fit_requests_adding_cause, fit_requests_at_low_process_noise):
        visited.fit_and_keep_in_threads(further(visited, best))
        visited.converge()
        if visited.best.log_posterior > best.log_posterior + MIN_LOG_POSTERIOR_GAIN:
            return True
    return False


def _remove_and_replace_causes(visited: FittedCauseSets, best: ScoredCauseSet) -> None:
    """Fit the best set without each of its causes and with others in its place, and other probable
    sets without one cause.
    """
    lacking = [
        FitRequest(rest, best.model, refit=True) for rest in _cause_sets_with_one_removed(best)
    ]
    fitted = zip(best.causes, visited.fit_and_keep_in_threads(lacking), strict=True)
    found = [(cause, less) for cause, less in fitted if less is not None]
    visited.fit_and_keep_in_threads(
        [
            one
            for fits in threaded_map(
                lambda pair: fit_requests_replacing_cause(visited, *pair), found
            )
            for one in fits
        ]
    )
    fit_causes_in_place_of_residual_terms(visited, best)
    visited.converge()
    visited.fit_and_keep_in_threads(_fit_requests_without_one_cause(visited))
    visited.converge()


def _fit_requests_without_one_cause(visited: FittedCauseSets) -> list[FitRequest]:
    """Fits of sets that lack one cause of a probable set, unless they are expected to be e^20 times
    less probable than the best set.

    A cause that is first found beside a wrong one is otherwise never fitted alone.
    """
    problem, best = visited.problem, visited.best.log_posterior
    probable = [one for one in visited.sets.values()
                if one.log_posterior > best - MAX_LOG_ODDS_TO_REFIT_NESTED]  # fmt: skip
    return [
        FitRequest(rest, one.model)
        for one in sorted(probable, key=lambda one: -one.log_posterior)
        for cause, rest in zip(one.causes, _cause_sets_with_one_removed(one), strict=True)
        if frozenset(rest) not in visited.sets
        and one.log_posterior + log_odds_without_cause(problem, one.expansion, one.layout, cause)
        > best - MAX_LOG_ODDS_TO_REFIT
    ]


def _refit_with_shared_noise(visited: FittedCauseSets) -> None:
    """Refit the probable sets from the noise of the most probable and of the likeliest one.

    The noise likelihood has several optima: two sets are compared fairly only if both had the
    chance of the better one. A set that is behind under its own noise may lead under another's.
    """
    likeliest = max(visited.sets.values(), key=lambda s: s.model.log_likelihood)
    for source in {s.model.key: s for s in (visited.best, likeliest)}.values():
        best = visited.best
        least = best.log_posterior - MAX_LOG_ODDS_TO_REFIT
        others = [one for key, one in visited.sets.items()
                  if key != source.model.key and len(key) <= len(best.causes)
                  and not visited.was_refitted_from_noise_of(one.model, source.model)]  # fmt: skip
        visited.refits_from_noise += [(one.model, source.model) for one in others]
        refit = partial(_refit_from_noise, visited, source.model, least)
        for one, other in zip(others, threaded_map(refit, others), strict=True):
            if other is not None and other.log_posterior > one.log_posterior:
                visited.replace_fit(other)


def _refit_from_noise(
    visited: FittedCauseSets, source: FittedCauseSet, least: float, scored: ScoredCauseSet
) -> ScoredCauseSet | None:
    """A set refitted from the noise of another one; None if the likelihood under both noises
    differs by less than a round of fits has to gain, or if the set's log posterior stays below the
    least with what the likelihood gains under that noise.
    """
    problem, model = visited.problem, scored.model
    gain = log_likelihood_gain_under_noise(problem, model, source.noise)
    if (
        abs(gain) < MIN_LOG_LIKELIHOOD_GAIN_PER_ROUND
        or scored.log_posterior + max(gain, 0.0) <= least
    ):
        return None
    left = visited.transferable_discrepancy(source, model.key) or model.discrepancy
    again = refit_from_fitted_values(problem, model, source.noise, discrepancy=left)
    return refit_with_reestimated_noise(problem, score_cause_set(problem, again))


def _cause_sets_with_one_removed(scored: ScoredCauseSet) -> list[tuple[str, ...]]:
    """The sets that lack one of a set's causes."""
    return [tuple(c for c in scored.causes if c != cause) for cause in scored.causes]
