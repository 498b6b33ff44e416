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

import numpy as np

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
from .fitted_sets import MAX_LOG_ODDS_TO_REFIT, FittedCauseSets
from .own_noise import fit_own_noise, is_likelier_under_noise, noise_with_small_random_forces
from .problem import MAX_SEARCH_TRIALS, CauseSearchProblem
from .refit import FittedCauseSet, fit_cause_set, refit_from_fitted_values, strength_starts
from .residual_magnitudes import plausible_residual_magnitudes
from .set_columns import columns_of_cause_set
from .set_score import ScoredCauseSet, score_cause_set
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
    plain = fit_cause_set(problem, (), problem.noise, start or {})
    part = d_optimal_trial_subset(expand_likelihood(problem, plain).hessian, MAX_SEARCH_TRIALS)
    few = replace(problem, series=tuple(problem.series[i] for i in part))
    return _verify_on_all_trials(problem, _search_on_trials(few, plain.fit.by_label()))


def _verify_on_all_trials(problem: CauseSearchProblem, few: FittedCauseSets) -> FittedCauseSets:
    """The probable sets of a subset of the trials and the model without causes, fitted to all of
    them with what these add.
    """
    visited = FittedCauseSets(replace(few.problem, series=problem.series))
    for scored in (few.sets[frozenset()], *_sets_to_verify(few)):
        visited.add(scored.causes, scored.model)
    visited.converge()
    done: set[frozenset[str]] = set()
    while (best := visited.best).model.key not in done:
        done.add(best.model.key)
        if len(best.causes) < problem.most_causes:
            _fit_further_causes(visited, best, MIN_REFITS_PER_SET)
        for cause in best.causes:
            visited.add(tuple(c for c in best.causes if c != cause), best.model)
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
    first = fit_own_noise(problem, fit_cause_set(problem, (), problem.noise, start))
    problem.check_baseline(first.noise, first.passes)
    whole, tried = expand_likelihood_in_all_forms(problem, first)
    if not whole.usable:
        raise np.linalg.LinAlgError("the model without causes runs away")
    expansion = restricted_to_likeliest_forms(problem, whole, tried)
    problem = replace(problem, collinear_terms=collinear_terms(problem, whole, tried),
                      residual_sizes=plausible_residual_magnitudes(problem, expansion))  # fmt: skip
    visited = FittedCauseSets(problem)
    visited.sets[frozenset()] = score_cause_set(problem, first)
    visited.full[frozenset()] = expansion
    before = -np.inf
    while (best := visited.best).log_posterior > before + MIN_LOG_POSTERIOR_GAIN:
        before = best.log_posterior
        if len(best.causes) < visited.problem.most_causes:
            for fit_further in (_fit_further_causes, _fit_further_under_small_forces):
                fit_further(visited, best)
                visited.converge()
                if visited.best.log_posterior > before + MIN_LOG_POSTERIOR_GAIN:
                    break
        if visited.best.log_posterior > before + MIN_LOG_POSTERIOR_GAIN:
            continue
        for cause in best.causes:
            rest = tuple(c for c in best.causes if c != cause)
            less = visited.add(rest, best.model, refit=True)
            if less is not None:
                _fit_further_causes(visited, less, REPLACEMENTS_PER_SET)
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
        for key, scored in list(visited.sets.items()):
            if key == source.model.key or len(key) > len(visited.best.causes):
                continue
            close = scored.log_posterior > visited.best.log_posterior - MAX_LOG_ODDS_TO_REFIT
            if close or is_likelier_under_noise(visited.problem, scored.model, source.model.noise):
                _keep_better_noise(visited, scored, source.model)


def _keep_better_noise(
    visited: FittedCauseSets, scored: ScoredCauseSet, source: FittedCauseSet
) -> None:
    """Keep the refit of a set from another's noise where that fits better."""
    problem, model = visited.problem, scored.model
    left = visited.shared_discrepancy(source, model.key)
    again = refit_from_fitted_values(
        problem, model, source.noise, discrepancy=left or model.discrepancy
    )
    other = score_cause_set(problem, fit_own_noise(problem, again))
    if other.log_joint > scored.log_joint:
        visited.sets[scored.model.key] = other
        visited.full.pop(scored.model.key, None)


def _fit_further_causes(
    visited: FittedCauseSets, scored: ScoredCauseSet, count: int = REFITS_PER_SET
) -> None:
    """Fit the most promising further causes beside a set: `count` listed ones, and residual terms
    besides, which are many and alike and would otherwise take the places of the listed cause that
    they resemble.
    """
    expansion = visited.expansion(scored)
    found = rank_further_causes(
        visited.problem, expansion, allowed_candidates(visited.problem, scored.causes)
    )
    candidates = visited.problem.by_name
    several = [n for _, n in found if strength_starts(visited.problem, candidates[n])]
    for name in several if not scored.causes else ():
        visited.add((*scored.causes, name), scored.model)
    listed = [one for one in found if not candidates[one[1]].is_residual][:count]
    terms = [one for one in found if candidates[one[1]].is_residual][:MIN_REFITS_PER_SET]
    for i, (gain, name) in enumerate(sorted([*listed, *terms], key=lambda one: -one[0])):
        if gain > found[0][0] - MAX_LOG_ODDS_TO_PROPOSE and (
            i < MIN_REFITS_PER_SET or gain > MIN_LOG_ODDS_TO_REFIT
        ):
            visited.add(
                (*scored.causes, name),
                scored.model,
                _start_of_further_cause(visited, expansion, name),
            )


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
    less = visited.add(rest, scored.model, refit=True) if len(terms) > 1 else None
    if less is None:
        return
    expansion = visited.expansion(less)
    alike = [c for c in allowed_candidates(problem, rest)
             if not c.is_residual and any(c.sources & term.sources for term in terms)]  # fmt: skip
    for _, name in rank_further_causes(problem, expansion, alike)[:REPLACEMENTS_PER_SET]:
        start = _start_of_further_cause(visited, expansion, name)
        found = visited.add((*rest, name), less.model, start)
        if found is None:
            continue
        _fit_further_causes(visited, found, REPLACEMENTS_PER_SET)
        for key in [k for k in visited.sets if k > found.model.key and len(k) == len(rest) + 2]:
            visited.add(tuple(key), less.model, refit=True)


def _fit_further_under_small_forces(visited: FittedCauseSets, scored: ScoredCauseSet) -> None:
    """Fit the most promising further causes by the expansion under small random forces, and begin
    there: what the random forces of a set explain by themselves shows no gain under its own noise.
    """
    problem = visited.problem
    model = refit_from_fitted_values(
        problem, scored.model, noise_with_small_random_forces(problem, scored.model.noise)
    )
    if not model.usable:
        return
    expansion = expand_likelihood(problem, model)
    found = rank_further_causes(problem, expansion, allowed_candidates(problem, scored.causes))
    for _, name in found[:SMALL_FORCE_REFITS_PER_SET]:
        visited.add(
            (*scored.causes, name),
            model,
            _start_of_further_cause(visited, expansion, name),
            refit=True,
        )


def _start_of_further_cause(
    visited: FittedCauseSets, expansion: LikelihoodExpansion, name: str
) -> dict[str, float]:
    """Where the fit of a further cause begins: at the strength and the form of the expansion."""
    return one_step_strength_estimates(visited.problem, expansion, name) | expansion.starts.get(
        name, {}
    )
