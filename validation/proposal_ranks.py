"""How far down the list of proposals the causes of the most probable set stand.

Each cause of that set is left out in turn. The expansion about the set without it proposes causes
to add. Its rank among the listed causes (of a residual term: among these terms) is compared with
the numbers that a search fits (`MAX_ADDED_CAUSE_REFITS_PER_SET`,
`MAX_REPLACEMENT_REFITS_PER_CAUSE`, `MIN_REFITS_PER_SET`); its log odds by the expansion, and how
far they are below those of the first proposal, are compared with `MIN_LOG_ODDS_TO_REFIT` and
`MAX_LOG_ODDS_BELOW_BEST_PROPOSAL`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bluekoi.engine import search_cause_sets
from bluekoi.engine.fitted_sets import FittedCauseSets
from bluekoi.engine.proposals import allowed_candidates, rank_further_causes

from .search_limits import study_problem


@dataclass(frozen=True)
class ProposedCause:
    """A cause of the most probable set: rank from 1, log odds by the expansion, how much less they
    are than those of the first proposal, and log odds that the fits give.
    """

    name: str
    rank: int
    log_odds: float
    below_first: float
    fitted_log_odds: float


def proposed_causes(study: Path, results: Path) -> list[ProposedCause]:
    """Causes of the most probable set of a measured study, all of whose trials are fitted."""
    return proposed_causes_of(search_cause_sets(*study_problem(study, results)))


def proposed_causes_of(visited: FittedCauseSets) -> list[ProposedCause]:
    """Causes of the most probable set that the expansion about the set without them proposes."""
    best, by_name, out = visited.best, visited.problem.candidate_by_name, []
    for cause in best.causes:
        less = visited.sets.get(best.model.key - {cause})
        if less is None or not np.isfinite(less.log_posterior):
            continue
        among = allowed_candidates(visited.problem, less.causes)
        found = rank_further_causes(
            visited.problem, visited.expansion_in_all_candidates(less), among
        )
        alike = [(gain, name) for gain, name in found
                 if by_name[name].is_residual == by_name[cause].is_residual]  # fmt: skip
        for rank, (gain, name) in enumerate(alike, 1):
            if name == cause:
                out.append(ProposedCause(cause, rank, gain, found[0][0] - gain,
                                         best.log_posterior - less.log_posterior))  # fmt: skip
    return out


def rank_summary(found: Sequence[ProposedCause]) -> str:
    """Lines on all causes of all studies."""
    ranks, odds, below = (np.array([getattr(one, key) for one in found])
                          for key in ("rank", "log_odds", "below_first"))  # fmt: skip
    counts = ", ".join(f"{np.sum(ranks <= k)} within {k}" for k in (1, 2, 5))
    return (
        f"{len(found)} causes of the most probable sets: ranks {counts}, {ranks.max()} at most\n"
        f"log odds by the expansion: {odds.min():.1f} at least; below the first proposal: "
        f"{np.median(below):.1f} in the median, {below.max():.1f} at most"
    )
