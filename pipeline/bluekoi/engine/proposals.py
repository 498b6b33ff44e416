"""Sets that are fitted next.

Around a set, the second-order expansion scores every cause that is not in the set; the most
promising ones are fitted. A cause of the set is replaced by those that are most promising without
it, and by the most promising of those that it can be confused with: about strengths of 0, the
expansion is inaccurate for a strong nonlinear cause such as a dead time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .candidates import CandidateCause
from .cause_set_columns import columns_of_cause_set
from .cause_set_fit import multi_start_strengths, refit_from_fitted_values
from .evidence import (
    log_evidence_given_discrepancy_stds,
    log_prior,
    most_probable_discrepancy_stds,
)
from .expansion import LikelihoodExpansion, expand_likelihood, one_step_strength_estimates
from .fitted_sets import FitRequest, FittedCauseSets
from .noise_estimation import noise_with_small_random_forces
from .problem import CauseSearchProblem
from .set_score import ScoredCauseSet

MAX_ADDED_CAUSE_REFITS_PER_SET = 5
"""How many further listed causes are refitted around a set. This and the next constants bound the
computing time: a cause that is not refitted has no probability. `python -m validation proposals`
ranks the causes of the most probable sets by the expansion without them: of 16 in ten studies of
`harbour_dock` 9203, 13 are first and 3 second (causes that the search did not find do not count).
"""
MAX_REPLACEMENT_REFITS_PER_CAUSE = 2
"""How many listed causes are refitted in the place of one of a set: the lowest rank of these 16."""
LOW_PROCESS_NOISE_REFITS_PER_SET = 2
"""How many are refitted that would be most probable if random forces were small: taken to be the
number of replacements, not measured by itself."""
MIN_REFITS_PER_SET, MIN_LOG_ODDS_TO_REFIT = 2, -6.0
"""So many are refitted whatever the expansion says; further ones where it says posterior odds of
more than e^-6, at which a cause has a probability of 0.0025. The log odds of these 16 are -1.6 at
least. Of residual terms, at most so many are refitted in each of these steps."""
MAX_LOG_ODDS_BELOW_BEST_PROPOSAL = 25.0
"""A cause whose expansion says that it makes a set e^25 times less probable than the best proposal
is not refitted. These 16 are 4.1 below the best proposal at most."""


def rank_further_causes(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, among: Sequence[CandidateCause]
) -> list[tuple[float, str]]:
    """Further causes by the expansion about a set: log posterior odds and name, the best first."""
    causes = expansion.model.causes
    if not expansion.is_finite:
        return []
    own = columns_of_cause_set(problem, expansion, causes)
    shares = most_probable_discrepancy_stds(expansion, own)
    before = log_evidence_given_discrepancy_stds(expansion, own, shares)
    out: list[tuple[float, str]] = []
    for candidate in among:
        if candidate.name in causes or not expansion.strengths[candidate.name]:
            continue
        lay = columns_of_cause_set(problem, expansion, (*causes, candidate.name))
        after = log_evidence_given_discrepancy_stds(expansion, lay, shares)
        gain = after - before + log_prior(problem, [candidate.name])
        out.append((float(gain) if np.isfinite(gain) else -np.inf, candidate.name))
    return sorted(out, key=lambda o: -o[0])


def allowed_candidates(problem: CauseSearchProblem, causes: Sequence[str]) -> list[CandidateCause]:
    """Candidates beside a set: residual terms that are part of a cause's form are not, nor those
    that are collinear with a listed cause.
    """
    sources = {s for c in causes if not problem.candidate_by_name[c].is_residual
               for s in problem.candidate_by_name[c].sources}  # fmt: skip
    return [c for c in problem.candidates
            if c.name not in causes and c.name not in problem.collinear_terms
            and not (c.is_residual and c.sources & sources)]  # fmt: skip


def fit_requests_adding_cause(
    visited: FittedCauseSets,
    scored: ScoredCauseSet,
    count: int = MAX_ADDED_CAUSE_REFITS_PER_SET,
    *,
    without: str = "",
) -> list[FitRequest]:
    """Fits of a set with one more cause, of the most promising ones: `count` listed causes, and
    residual terms besides, which are many and alike and would otherwise take the places of the
    listed cause that they resemble. without: a cause that is not proposed.
    """
    expansion = visited.expansion_in_all_candidates(scored)
    allowed = allowed_candidates(visited.problem, scored.causes)
    found = rank_further_causes(
        visited.problem, expansion, [c for c in allowed if c.name != without]
    )
    candidates = visited.problem.candidate_by_name
    several = [n for _, n in found if multi_start_strengths(visited.problem, candidates[n])]
    out = [FitRequest((name,), scored.model) for name in several if not scored.causes]
    listed = [one for one in found if not candidates[one[1]].is_residual][:count]
    terms = [one for one in found if candidates[one[1]].is_residual][:MIN_REFITS_PER_SET]
    for i, (gain, name) in enumerate(sorted([*listed, *terms], key=lambda one: -one[0])):
        if gain > found[0][0] - MAX_LOG_ODDS_BELOW_BEST_PROPOSAL and (
            i < MIN_REFITS_PER_SET or gain > MIN_LOG_ODDS_TO_REFIT
        ):
            start = _start_values_of_added_cause(visited.problem, expansion, name)
            out.append(FitRequest((*scored.causes, name), scored.model, start))
    return out


def fit_requests_replacing_cause(
    visited: FittedCauseSets, cause: str, less: ScoredCauseSet
) -> list[FitRequest]:
    """Fits in which another cause replaces `cause`. less: the set without it.

    The replacements are the most promising causes, and the most promising of those that `cause`
    can be confused with.
    """
    problem = visited.problem
    fits = fit_requests_adding_cause(visited, less, MAX_REPLACEMENT_REFITS_PER_CAUSE, without=cause)
    confused = _causes_confused_with(problem, cause)
    among = [c for c in allowed_candidates(problem, less.causes) if c.name in confused]
    expansion = visited.expansion_in_all_candidates(less)
    for _, name in rank_further_causes(problem, expansion, among)[:1]:
        start = _start_values_of_added_cause(problem, expansion, name)
        fits.append(FitRequest((*less.causes, name), less.model, start))
    return fits


def _causes_confused_with(problem: CauseSearchProblem, cause: str) -> set[str]:
    """Causes that have nearly the same effect on the motion, by the file of either."""
    effects = {e.name: e for e in problem.kernel.system.effects}
    own = effects[cause].confused_with if cause in effects else ()
    return {*own, *(e.name for e in effects.values() if cause in e.confused_with)}


def fit_causes_in_place_of_residual_terms(visited: FittedCauseSets, scored: ScoredCauseSet) -> None:
    """Fit the causes that make a force of the kind of a set's residual terms, in place of all of
    two terms or more, and what is promising beside each.

    Two terms may describe what is one cause with another one beside it. No step that replaces one
    term comes to that set, if the cause alone describes less than both terms. The fit with the
    other one begins both at the cause alone, which may be bent to describe the whole, and at the
    set without either.
    """
    problem = visited.problem
    terms = [
        problem.candidate_by_name[c]
        for c in scored.causes
        if problem.candidate_by_name[c].is_residual
    ]
    rest = tuple(c for c in scored.causes if not problem.candidate_by_name[c].is_residual)
    if len(terms) < 2:
        return
    less = visited.fit_and_keep(FitRequest(rest, scored.model, refit=True))
    if less is None:
        return
    expansion = visited.expansion_in_all_candidates(less)
    alike = [c for c in allowed_candidates(problem, rest)
             if not c.is_residual and any(c.sources & term.sources for term in terms)]  # fmt: skip
    best = rank_further_causes(problem, expansion, alike)[:MAX_REPLACEMENT_REFITS_PER_CAUSE]
    alone = visited.fit_and_keep_in_threads(
        [
            FitRequest(
                (*rest, name), less.model, _start_values_of_added_cause(problem, expansion, name)
            )
            for _, name in best
        ]
    )
    for found in (one for one in alone if one is not None):
        visited.fit_and_keep_in_threads(
            fit_requests_adding_cause(visited, found, MAX_REPLACEMENT_REFITS_PER_CAUSE)
        )
        both = [k for k in visited.sets if k > found.model.key and len(k) == len(rest) + 2]
        visited.fit_and_keep_in_threads(
            [FitRequest(tuple(k), less.model, refit=True) for k in both]
        )


def fit_requests_at_low_process_noise(
    visited: FittedCauseSets, scored: ScoredCauseSet
) -> list[FitRequest]:
    """Fits of the most promising further causes by the expansion under small random forces, begun
    there: what the random forces of a set explain by themselves shows no gain under its own noise.
    """
    problem = visited.problem
    model = refit_from_fitted_values(
        problem, scored.model, noise_with_small_random_forces(problem, scored.model.noise)
    )
    if not model.is_finite:
        return []
    expansion = expand_likelihood(problem, model)
    found = rank_further_causes(problem, expansion, allowed_candidates(problem, scored.causes))
    return [FitRequest((*scored.causes, name), model,
                       _start_values_of_added_cause(problem, expansion, name), refit=True)
            for _, name in found[:LOW_PROCESS_NOISE_REFITS_PER_SET]]  # fmt: skip


def _start_values_of_added_cause(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, name: str
) -> dict[str, float]:
    """Where the fit of a further cause begins: at the strength and the form of the expansion."""
    return one_step_strength_estimates(problem, expansion, name) | expansion.starts.get(name, {})
