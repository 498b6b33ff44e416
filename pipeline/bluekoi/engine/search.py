"""Search of the sets of causes that have posterior probability.

Around the most probable set so far, the second-order expansion scores every further cause; the best
are refitted, with all their functional forms and their own noise; so are the sets that lack one of
the causes, and around these again the best replacements. The search ends where none of this finds
a more probable set. (Shotgun stochastic search without the dice: Hans, Dobra and West, JASA 102
(2007), 507.) Of a large study the search uses the trials that say most; the probable sets are then
fitted to all trials, and what the expansion about the best adds there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..integrate.batch import threaded_map
from .candidates import Candidate
from .collinear_terms import collinear_terms
from .evidence import (
    log_evidence_at_discrepancy_shares,
    log_prior,
    most_probable_discrepancy_shares,
)
from .expansion import (
    LikelihoodExpansion,
    expand_likelihood,
    expand_likelihood_in_all_forms,
    one_step_strength_estimates,
    restricted_to_likeliest_forms,
)
from .fitted_sets import MAX_LOG_ODDS_TO_REFIT, FitRequest, FittedCauseSets
from .own_noise import fit_without_causes, is_likelier_under_noise, noise_with_small_random_forces
from .problem import MAX_SEARCH_TRIALS, CauseSearchProblem
from .refit import FittedCauseSet, refit_from_fitted_values, strength_starts
from .residual_magnitudes import plausible_residual_magnitudes
from .set_columns import columns_of_cause_set
from .set_score import ScoredCauseSet, refit_with_discrepancy, score_cause_set, with_own_noise
from .subset import d_optimal_trial_subset

REFITS_PER_SET = 5
"""How many further listed causes are refitted around a set."""
REPLACEMENTS_PER_SET = 2
"""How many listed causes are refitted in the place of one of a set."""
SMALL_FORCE_REFITS_PER_SET = 2
"""How many are refitted that would be most probable if random forces were small."""
MIN_REFITS_PER_SET, MIN_LOG_ODDS_TO_REFIT = 2, -6.0
"""Limits of the computing time: so many are refitted whatever the expansion says; further ones
where it says posterior odds of more than e^-6. Of residual terms, at most so many are refitted in
each of these steps."""
MAX_LOG_ODDS_TO_PROPOSE = 25.0
"""A cause whose expansion says that it makes a set e^25 times less probable than the best proposal
is not refitted."""
MIN_LOG_POSTERIOR_GAIN = 1.0
"""The search goes on about a set that is e^1 times more probable than the last one; sets that are
nearly as probable have nearly the same neighbours."""
MAX_FURTHER_SETS_VERIFIED = 4
"""How many further sets of a subset of the trials are fitted to all of them, besides the best and
those that lack one of its causes. It bounds the work; sets left out have no probability."""


def rank_further_causes(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, among: Sequence[Candidate]
) -> list[tuple[float, str]]:
    """Further causes by the expansion about a set: log posterior odds and name, the best first."""
    causes = expansion.model.causes
    if not expansion.usable:
        return []
    own = columns_of_cause_set(problem, expansion, causes)
    shares = most_probable_discrepancy_shares(expansion, own)
    before = log_evidence_at_discrepancy_shares(expansion, own, shares)
    out: list[tuple[float, str]] = []
    for candidate in among:
        if candidate.name in causes or not expansion.strengths[candidate.name]:
            continue
        lay = columns_of_cause_set(problem, expansion, (*causes, candidate.name))
        after = log_evidence_at_discrepancy_shares(expansion, lay, shares)
        gain = after - before + log_prior(problem, [candidate.name])
        out.append((float(gain) if np.isfinite(gain) else -np.inf, candidate.name))
    return sorted(out, key=lambda o: -o[0])


def allowed_candidates(problem: CauseSearchProblem, causes: Sequence[str]) -> list[Candidate]:
    """Candidates beside a set: residual terms that are part of a cause's form are not, nor those
    that are collinear with a listed cause.
    """
    sources = {s for c in causes if not problem.by_name[c].is_residual
               for s in problem.by_name[c].sources}  # fmt: skip
    return [c for c in problem.candidates
            if c.name not in causes and c.name not in problem.collinear_terms
            and not (c.is_residual and c.sources & sources)]  # fmt: skip


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
    return _verify_on_all_trials(problem, _search_on_trials(few, plain.fit.by_label()))


def _verify_on_all_trials(problem: CauseSearchProblem, few: FittedCauseSets) -> FittedCauseSets:
    """The probable sets of a subset of the trials and the model without causes, fitted to all of
    them with what these add.
    """
    visited = FittedCauseSets(replace(few.problem, series=problem.series))
    known = (few.sets[frozenset()], *_sets_to_verify(few))
    visited.add_side_by_side([FitRequest(scored.causes, scored.model) for scored in known])
    visited.converge()
    done: set[frozenset[str]] = set()
    while (best := visited.best).model.key not in done:
        done.add(best.model.key)
        if len(best.causes) < problem.most_causes:
            visited.add_side_by_side(_fits_of_further_causes(visited, best, MIN_REFITS_PER_SET))
        visited.add_side_by_side([FitRequest(rest, best.model) for rest in _lacking_one(best)])
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
    if not whole.usable:
        raise np.linalg.LinAlgError("the model without causes runs away")
    expansion = restricted_to_likeliest_forms(problem, whole, tried)
    problem = replace(problem, collinear_terms=collinear_terms(problem, whole, tried),
                      residual_sizes=plausible_residual_magnitudes(problem, expansion))  # fmt: skip
    visited = FittedCauseSets(problem)
    visited.sets[frozenset()] = refit_with_discrepancy(problem, score_cause_set(problem, first))
    before = -np.inf
    while (best := visited.best).log_posterior > before + MIN_LOG_POSTERIOR_GAIN:
        before = best.log_posterior
        if len(best.causes) < visited.problem.most_causes:
            for further in (_fits_of_further_causes, _fits_begun_under_small_forces):
                visited.add_side_by_side(further(visited, best))
                visited.converge()
                if visited.best.log_posterior > before + MIN_LOG_POSTERIOR_GAIN:
                    break
        if visited.best.log_posterior > before + MIN_LOG_POSTERIOR_GAIN:
            continue
        lacking = [FitRequest(rest, best.model, refit=True) for rest in _lacking_one(best)]
        found = [less for less in visited.add_side_by_side(lacking) if less is not None]
        visited.add_side_by_side([one for fits in threaded_map(
            lambda less: _fits_of_further_causes(visited, less, REPLACEMENTS_PER_SET), found)
            for one in fits])  # fmt: skip
        _fit_causes_in_place_of_residual_terms(visited, best)
        visited.converge()
        _refit_with_shared_noise(visited)
    return visited


def _refit_with_shared_noise(visited: FittedCauseSets) -> None:
    """Refit the probable sets from the noise of the most probable and of the likeliest one.

    The noise likelihood has several optima: two sets are compared fairly only if both had the
    chance of the better one. A set that is far behind under its own noise may lead under another's.
    """
    likeliest = max(visited.sets.values(), key=lambda s: s.model.log_likelihood)
    for source in {s.model.key: s for s in (visited.best, likeliest)}.values():
        best = visited.best
        least = best.log_posterior - MAX_LOG_ODDS_TO_REFIT
        others = [one for key, one in visited.sets.items()
                  if key != source.model.key and len(key) <= len(best.causes)]  # fmt: skip
        refit = partial(_refit_from_noise, visited, source.model, least)
        for one, other in zip(others, threaded_map(refit, others), strict=True):
            if other is not None and other.log_posterior > one.log_posterior:
                visited.keep(other)


def _refit_from_noise(
    visited: FittedCauseSets, source: FittedCauseSet, least: float, scored: ScoredCauseSet
) -> ScoredCauseSet | None:
    """A set refitted from the noise of another one; None where its log posterior is below the least
    and the trials are not likelier under that noise.
    """
    problem, model = visited.problem, scored.model
    if scored.log_posterior <= least and not is_likelier_under_noise(problem, model, source.noise):
        return None
    left = visited.shared_discrepancy(source, model.key) or model.discrepancy
    again = refit_from_fitted_values(problem, model, source.noise, discrepancy=left)
    return with_own_noise(problem, score_cause_set(problem, again))


def _lacking_one(scored: ScoredCauseSet) -> list[tuple[str, ...]]:
    """The sets that lack one of a set's causes."""
    return [tuple(c for c in scored.causes if c != cause) for cause in scored.causes]


def _fits_of_further_causes(
    visited: FittedCauseSets, scored: ScoredCauseSet, count: int = REFITS_PER_SET
) -> list[FitRequest]:
    """Fits of the most promising further causes beside a set: `count` listed ones, and residual
    terms besides, which are many and alike and would otherwise take the places of the listed cause
    that they resemble.
    """
    expansion = visited.expansion(scored)
    found = rank_further_causes(
        visited.problem, expansion, allowed_candidates(visited.problem, scored.causes)
    )
    candidates = visited.problem.by_name
    several = [n for _, n in found if strength_starts(visited.problem, candidates[n])]
    out = [FitRequest((name,), scored.model) for name in several if not scored.causes]
    listed = [one for one in found if not candidates[one[1]].is_residual][:count]
    terms = [one for one in found if candidates[one[1]].is_residual][:MIN_REFITS_PER_SET]
    for i, (gain, name) in enumerate(sorted([*listed, *terms], key=lambda one: -one[0])):
        if gain > found[0][0] - MAX_LOG_ODDS_TO_PROPOSE and (
            i < MIN_REFITS_PER_SET or gain > MIN_LOG_ODDS_TO_REFIT
        ):
            start = _start_of_further_cause(visited.problem, expansion, name)
            out.append(FitRequest((*scored.causes, name), scored.model, start))
    return out


def _fit_causes_in_place_of_residual_terms(
    visited: FittedCauseSets, scored: ScoredCauseSet
) -> None:
    """Fit the causes that make a force of the kind of a set's residual terms, in place of all of
    two terms or more, and what is promising beside each.

    Two terms may describe what is one cause with another one beside it. No step that replaces one
    term comes to that set, if the cause alone describes less than both terms. The fit with the
    other one begins both at the cause alone, which may be bent to describe the whole, and at the
    set without either.
    """
    problem = visited.problem
    terms = [problem.by_name[c] for c in scored.causes if problem.by_name[c].is_residual]
    rest = tuple(c for c in scored.causes if not problem.by_name[c].is_residual)
    if len(terms) < 2:
        return
    less = visited.add(FitRequest(rest, scored.model, refit=True))
    if less is None:
        return
    expansion = visited.expansion(less)
    alike = [c for c in allowed_candidates(problem, rest)
             if not c.is_residual and any(c.sources & term.sources for term in terms)]  # fmt: skip
    best = rank_further_causes(problem, expansion, alike)[:REPLACEMENTS_PER_SET]
    alone = visited.add_side_by_side([
        FitRequest((*rest, name), less.model, _start_of_further_cause(problem, expansion, name))
        for _, name in best])  # fmt: skip
    for found in (one for one in alone if one is not None):
        visited.add_side_by_side(_fits_of_further_causes(visited, found, REPLACEMENTS_PER_SET))
        both = [k for k in visited.sets if k > found.model.key and len(k) == len(rest) + 2]
        visited.add_side_by_side([FitRequest(tuple(k), less.model, refit=True) for k in both])


def _fits_begun_under_small_forces(
    visited: FittedCauseSets, scored: ScoredCauseSet
) -> list[FitRequest]:
    """Fits of the most promising further causes by the expansion under small random forces, begun
    there: what the random forces of a set explain by themselves shows no gain under its own noise.
    """
    problem = visited.problem
    model = refit_from_fitted_values(
        problem, scored.model, noise_with_small_random_forces(problem, scored.model.noise)
    )
    if not model.usable:
        return []
    expansion = expand_likelihood(problem, model)
    found = rank_further_causes(problem, expansion, allowed_candidates(problem, scored.causes))
    return [FitRequest((*scored.causes, name), model,
                       _start_of_further_cause(problem, expansion, name), refit=True)
            for _, name in found[:SMALL_FORCE_REFITS_PER_SET]]  # fmt: skip


def _start_of_further_cause(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, name: str
) -> dict[str, float]:
    """Where the fit of a further cause begins: at the strength and the form of the expansion."""
    return one_step_strength_estimates(problem, expansion, name) | expansion.starts.get(name, {})
