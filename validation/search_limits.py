"""What the limits of the finder's search and posterior leave out, in measured studies.

For each set of causes that a search has fitted to the end: by how much its log posterior exceeds
that after a single round of noise and numbers (`MAX_LOG_ODDS_TO_REFIT`). And by how much the
inclusion probabilities change if no set is left out of the posterior (`MAX_LOG_ODDS_KEPT`), and by
how much another fit of its discrepancy changes a set whose prior has not come to rest
(`MAX_DISCREPANCY_ROUNDS`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bluekoi.campaign import load_campaign
from bluekoi.engine import CauseSearchProblem, posterior_over_sets, search_cause_sets
from bluekoi.engine.cause_set_fit import fit_cause_set
from bluekoi.engine.fitted_sets import FittedCauseSets
from bluekoi.engine.noise_estimation import fit_noise_and_parameters
from bluekoi.engine.set_score import refit_with_discrepancy, score_cause_set
from bluekoi.mismatch.find import SEARCH_SAMPLING_RATE_HZ
from bluekoi.mismatch.robot_problem import robot_cause_search_problem
from bluekoi.stages.tuning import campaign_flapping, campaign_series
from bluekoi.study import load_study
from bluekoi.tuning import (
    compiled_trial_system,
    downsampled,
    downsampled_with_head_angle_changes,
    fit_all_trials,
)


@dataclass(frozen=True)
class LimitEffects:
    """One study: log posterior that further rounds of a fit add (sets,), sets below the limit of
    the posterior, the largest change of an inclusion probability without that limit, and changes of
    the log posterior by another fit of the discrepancy where its prior is not at rest.
    """

    study: str
    round_gains: tuple[float, ...]
    sets_left_out: int
    probability_change: float
    discrepancy_changes: tuple[float, ...] = ()


def study_problem(study: Path, results: Path) -> tuple[CauseSearchProblem, dict[str, float]]:
    """Problem of a measured study, all of whose trials are fitted, and the fitted coefficients."""
    campaign = load_campaign(results, load_study(study), measured=True)
    series = campaign_series(campaign, campaign_flapping(campaign))
    kernel, baseline = compiled_trial_system(series), fit_all_trials(downsampled(series))
    searched = downsampled_with_head_angle_changes(series, SEARCH_SAMPLING_RATE_HZ)
    problem = robot_cause_search_problem(
        kernel, searched, baseline, displaced=(), progress=lambda _: None
    )
    return problem, baseline.fit.values_by_label()


def limit_effects(study: Path, results: Path) -> LimitEffects:
    """`LimitEffects` of a measured study, all of whose trials are fitted."""
    problem, start = study_problem(study, results)
    visited = search_cause_sets(problem, start)
    sets = list(visited.sets.values())
    limited, all_sets = (posterior_over_sets(visited.problem, sets, **limit)
                         for limit in ({}, {"max_log_odds": np.inf}))  # fmt: skip
    change = max((abs(p - limited.inclusion.get(name, 0.0))
                  for name, p in all_sets.inclusion.items()), default=0.0)  # fmt: skip
    return LimitEffects(study.name, round_gains(visited, start),
                        len(all_sets.sets) - len(limited.sets), change,
                        discrepancy_changes(visited))  # fmt: skip


def discrepancy_changes(visited: FittedCauseSets) -> tuple[float, ...]:
    """Changes of the log posterior by another fit of the discrepancy, of the sets fitted to the end
    whose prior does not belong to the forces of the fit.
    """
    pairs = [(one, refit_with_discrepancy(visited.problem, one))
             for one in (visited.sets[key] for key in visited.converged)]  # fmt: skip
    return tuple(again.log_posterior - one.log_posterior for one, again in pairs
                 if again is not one)  # fmt: skip


def round_gains(visited: FittedCauseSets, start: Mapping[str, float]) -> tuple[float, ...]:
    """Log posterior of the sets fitted to the end, less that after one round from the start."""
    problem, out = visited.problem, []
    for key in visited.converged:
        final = visited.sets[key]
        once = fit_cause_set(
            problem, final.causes, problem.noise, {**start, **final.model.fit.values_by_label()}
        )
        if once.is_finite and np.isfinite(final.log_posterior):
            one_round = score_cause_set(problem, fit_noise_and_parameters(problem, once, most=1))
            out.append(final.log_posterior - one_round.log_posterior)
    return tuple(gain for gain in out if np.isfinite(gain))


def limit_line(found: LimitEffects) -> str:
    """A line on one study."""
    return (
        f"{found.study}: {len(found.round_gains)} sets fitted to the end, further rounds add "
        f"{max(found.round_gains, default=0.0):.1f} at most; {found.sets_left_out} sets left out, "
        f"probabilities change by {found.probability_change:.4f} without the limit; "
        f"{len(found.discrepancy_changes)} sets whose discrepancy has not come to rest"
    )


def limit_summary(found: Sequence[LimitEffects]) -> str:
    """A line on all studies."""
    gains = np.array([gain for one in found for gain in one.round_gains])
    changes = np.array([change for one in found for change in one.discrepancy_changes])
    return (
        f"{len(found)} studies: {len(gains)} sets, further rounds add {np.median(gains):.1f} in "
        f"the median, {gains.max():.1f} at most; probabilities change by "
        f"{max(one.probability_change for one in found):.4f} at most; the discrepancy of "
        f"{len(changes)} has not come to rest, another fit changes their log posterior by "
        f"{np.abs(changes).max(initial=0.0):.1f} at most"
    )
