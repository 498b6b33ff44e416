"""Recordings made elsewhere, predicted by a fitted model without the causes of its own site."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..engine.cause_selection import UNLISTED_FORCE_LABEL
from ..fitting import Noise, TrialSeries, filter_series, free_runs
from ..fitting.filtering import parameters_with_random_effects_on
from ..integrate import CompiledSystem
from ..integrate.batch import repeat_over_lanes, simulate_batch
from .cause_search import CauseSearchResult, series_of_further_trials
from .comparison import (
    PREDICTION_ERRORS,
    CriterionFit,
    conditions_by_fold,
    fit_by_criterion,
    refit_to_trials,
    rms_errors,
)
from .model import Model
from .trials import Trial, validated_trials

DEFAULT_KNOWN_S, MIN_KNOWN_SAMPLES = 1.0, 3
RUNAWAY_OVER_OBSERVED_RANGE = 10.0
"""A free run that leaves its recording by so many times the range of an observation ran away."""


@dataclass(frozen=True)
class FreeSimulation:
    """A trial simulated freely: times (n,), simulated and seen (n, observations)."""

    trial: str
    times: Float
    simulated: Float
    seen: Float
    errors: dict[str, float]
    measures: dict[str, float]


@dataclass(frozen=True)
class PredictedTrials:
    """Free runs (simulations) of trials that the model was not fitted to.

    - runs: (`baseline` or `extended`, `start fitted` or `start from the first seconds`) -> a run
      for each trial. The initial state is fitted to the whole trial, or estimated from its first
      `known_s` seconds;
    - measured: for each trial, the values of `Model.measures` in the recording;
    - not_applied: named causes that belong to the place of the fitted recordings;
    - messages: remarks, in sentences.
    """

    runs: dict[tuple[str, str], list[FreeSimulation]]
    measured: list[dict[str, float]]
    known_s: float
    not_applied: tuple[str, ...]
    messages: tuple[str, ...]


START_FITTED, START_ESTIMATED = "start fitted", "start from the first seconds"
"""How the start of a free run was found."""


def predict(
    found: CauseSearchResult, trials: Sequence[Trial], *, known_s: float = DEFAULT_KNOWN_S
) -> PredictedTrials:
    """`PredictedTrials` for trials that the model was not fitted to."""
    model = found.model
    series = series_of_further_trials(found.prepared, validated_trials(model, trials))
    site = tuple(c for c in found.extended.model.causes
                 if c in model.by_name and model.by_name[c].site)  # fmt: skip
    models = {"baseline": found.baseline, "extended": without_site_specific_causes(found, site)}
    runs = {(name, start): _simulate_trials(found, one, series, known)
            for name, one in models.items()
            for start, known in ((START_FITTED, np.inf), (START_ESTIMATED, known_s))}  # fmt: skip
    messages = [f"{c} belongs to the site of the fitted recordings and is not applied here."
                for c in site]  # fmt: skip
    if found.verdict == UNLISTED_FORCE_LABEL:
        messages.append(
            "The verdict is unexplained: forces without a name were fitted to other "
            "recordings, and predictions with them may be worse than the baseline's."
        )
    messages += [*_unfitted_group_sentences(found, series), *runaway_sentences(runs)]
    measured = [_measures_of_observations(model, s, s.seen) for s in series]
    return PredictedTrials(runs, measured, known_s, site, tuple(messages))


def without_site_specific_causes(found: CauseSearchResult, site: Sequence[str]) -> CriterionFit:
    """The extended model with the strengths of site-specific causes at 0."""
    one = found.extended
    off = {f.label for c in site for f in found.prepared.problem.candidate_by_name[c].strengths}
    values = np.array([0.0 if f.label in off else v
                       for f, v in zip(one.fit.free, one.fit.values, strict=True)])  # fmt: skip
    return replace(one, fit=replace(one.fit, values=values))


def _unfitted_group_sentences(found: CauseSearchResult, series: Sequence[TrialSeries]) -> list[str]:
    known = {f.group for f in found.extended.fit.free if f.group is not None}
    new = sorted({s.group for s in series} - known) if known else []
    return [f"Group '{g}' was not fitted: its coefficients are at their start values." for g in new]


def predict_left_out(
    found: CauseSearchResult, *, known_s: float = DEFAULT_KNOWN_S
) -> PredictedTrials:
    """`PredictedTrials` for the fitted trials, each condition by models fitted to the others."""
    problem, model = found.prepared.problem, found.model
    series = list(problem.series)
    runs: dict[tuple[str, str], dict[str, FreeSimulation]] = {}
    for fold in conditions_by_fold(series):
        rest = replace(problem, series=tuple(s for s in series if s.condition not in fold))
        own = [s for s in series if s.condition in fold]
        for name, one in (("baseline", found.baseline), ("extended", found.extended)):
            again = one
            if rest.series:
                again = fit_by_criterion(rest, refit_to_trials(rest, one.model), one.criterion)
            for start, known in ((START_FITTED, np.inf), (START_ESTIMATED, known_s)):
                every = runs.setdefault((name, start), {})
                every |= {r.trial: r for r in _simulate_trials(found, again, own, known)}
    ordered = {key: [rows[s.name] for s in series] for key, rows in runs.items()}
    measured = [_measures_of_observations(model, s, s.seen) for s in series]
    return PredictedTrials(ordered, measured, known_s, (), tuple(runaway_sentences(ordered)))


def runaway_sentences(runs: Mapping[tuple[str, str], Sequence[FreeSimulation]]) -> list[str]:
    """A sentence for each model that runs away from trials, whatever the start."""
    away: dict[str, list[str]] = {}
    for (name, _), rows in runs.items():
        own = away.setdefault(name, [])
        own += [r.trial for r in rows if r.trial not in own and _has_diverged(r)]
    return [f"Free runs of the {name} model leave {', '.join(trials)} by more than "
            f"{RUNAWAY_OVER_OBSERVED_RANGE:g} times their range: small errors grow without limit "
            "there, or the model does not hold."
            for name, trials in away.items() if trials]  # fmt: skip


def _has_diverged(run: FreeSimulation) -> bool:
    known = np.isfinite(run.seen)
    error = np.where(known, np.abs(run.simulated - run.seen), 0.0)
    extent = np.nanmax(run.seen, axis=0) - np.nanmin(run.seen, axis=0)
    return not (error <= RUNAWAY_OVER_OBSERVED_RANGE * np.where(extent > 0.0, extent, np.inf)).all()


@np.errstate(all="ignore")
def _simulate_trials(
    found: CauseSearchResult, one: CriterionFit, series: Sequence[TrialSeries], known_s: float
) -> list[FreeSimulation]:
    problem, model = found.prepared.problem, found.model
    values = one.parameter_vectors(problem, series)
    if np.isfinite(known_s):  # the filter goes with the fit by its prediction errors
        values = CriterionFit(one.model, one.model.fit, PREDICTION_ERRORS).parameter_vectors(
            problem, series
        )
        observed = [forecast(problem.kernel, s, v, one.model.noise, known_s)
                    for s, v in zip(series, values, strict=True)]  # fmt: skip
    else:
        runs = free_runs(problem.kernel, series, values, open_states=len(model.states))
        observed = [run.observed for run in runs]
    out = []
    for s, y in zip(series, observed, strict=True):
        later = (
            ~in_first_seconds(s, known_s) if np.isfinite(known_s) else np.ones(len(y), dtype=bool)
        )
        errors = rms_errors(model, [(y - s.seen)[later]])
        out.append(
            FreeSimulation(
                s.name, s.times, y, s.seen, errors, _measures_of_observations(model, s, y)
            )
        )
    return out


def in_first_seconds(one: TrialSeries, known_s: float) -> np.ndarray:
    """Frames (n,) in the first seconds of a trial, by its clock; after its first sample where it
    begins later.
    """
    first = one.times[0] if one.times[0] >= known_s else min(one.times[0], 0.0)
    return np.asarray(one.times <= first + known_s)


def forecast(
    kernel: CompiledSystem, one: TrialSeries, values: Float, noise: Noise, known_s: float
) -> Float:
    """Observations (n, observations) predicted from the first `known_s` seconds of a trial by the
    filter, lasting errors and all.
    """
    known = in_first_seconds(one, known_s)
    beginning = replace(one, seen=np.where(known[:, None], one.seen, np.nan))
    states = filter_series(kernel, beginning, values, noise).predicted
    count, full = len(one.times), parameters_with_random_effects_on(kernel, values, noise)
    rows = (states, np.tile(full, (count, 1)), np.tile(one.constants, (count, 1)))
    lanes = [repeat_over_lanes(row) for row in rows]
    observed, _ = simulate_batch(
        kernel, *lanes, times=one.times[:, None], inputs=one.inputs[:, None]
    )
    return observed[:, 0, :, 0]


def _measures_of_observations(
    model: Model, series: TrialSeries, observed: Float
) -> dict[str, float]:
    if model.measures is None:
        return {}
    known = np.isfinite(observed).all(axis=1)
    if known.sum() < MIN_KNOWN_SAMPLES:
        return {}
    given = (series.times[known], observed[known], series.inputs[known])
    return {str(k): float(v) for k, v in model.measures(*given).items()}
