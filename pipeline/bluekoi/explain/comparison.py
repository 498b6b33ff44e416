"""How well models predict recordings that they were not fitted to, by free simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..data import Float
from ..engine import CauseSearchProblem, FittedCauseSet, fit_cause_set
from ..engine.cause_set_fit import start_values
from ..fitting import (
    ParameterFit,
    TrialSeries,
    filter_all,
    fit_trajectories,
    free_runs,
    parametric_bootstrap,
    rts_smooth,
    trial_parameter_vector,
)
from ..fitting.paths import MAX_TRAJECTORY_PARAMETERS, PREDICTION_ERRORS, TRAJECTORIES
from ..fitting.trial_effects import parameter_vectors_with_trial_effects, sample_trial_effects
from .model import Model

MAX_LOG_PERTURBATION_GROWTH = 6.0
"""Small differences may grow by e^6 over a compared segment."""
MAX_FOLDS, MIN_SEGMENT_FRAMES = 6, 8
"""Groups of conditions left out in turn, and observations of a compared segment."""
NOISE_FLOOR_DRAWS, NOISE_FLOOR_SEED = 2, 20240517


@dataclass(frozen=True)
class CriterionFit:
    """A set of causes with its numbers fitted by one criterion."""

    model: FittedCauseSet
    fit: ParameterFit
    criterion: str

    def parameter_vectors(
        self, problem: CauseSearchProblem, series: Sequence[TrialSeries]
    ) -> list[Float]:
        """Full parameter vectors, one a trial."""
        base = start_values(problem, self.model.causes, self.fit.values_by_label())
        return [
            trial_parameter_vector(problem.kernel, base, self.fit.free, self.fit.values, s.group)
            for s in series
        ]


@dataclass(frozen=True)
class HeldOutErrors:
    """Errors on conditions that were left out of the fit, each in its unit.

    baseline, extended, noise_floor: name -> root mean square error; the floor is the error of the
    extended model on data simulated by itself. fitted_to: criterion of the baseline, the better of
    two, and of the extended model. trials; stretch_s: longest compared stretch.
    """

    trials: tuple[str, ...]
    baseline: dict[str, float]
    extended: dict[str, float]
    noise_floor: dict[str, float]
    fitted_to: tuple[str, str]
    stretch_s: float


def unconfirmed_causes_sentence(held: HeldOutErrors) -> str:
    """A sentence where the named causes make no error smaller, or no text.

    The error of the path counts, where the model has one, else that of every observation.
    """
    names = [n for n in held.baseline if n == "path_rmse"] or list(held.baseline)
    if not names or not all(held.extended[n] >= held.baseline[n] for n in names):
        return ""
    errors = ", ".join(
        f"{n} {held.extended[n]:.3g} with them and {held.baseline[n]:.3g} without" for n in names
    )
    return f"Conditions left out of the fit do not confirm the named causes: {errors}."


def fit_by_both_criteria(problem: CauseSearchProblem, model: FittedCauseSet) -> list[CriterionFit]:
    """A set fitted by prediction errors, and to whole trajectories where that fit ends well."""
    out = [CriterionFit(model, model.fit, PREDICTION_ERRORS)]
    kernel, base = problem.kernel, start_values(problem, model.causes, model.fit.values_by_label())
    states = len(kernel.system.states)
    own = any(kernel.system.effect(c.partition(".")[0]).states for c in model.causes)
    # States of causes have no free start.
    if own or len(model.fit.free) + states > MAX_TRAJECTORY_PARAMETERS:
        return out
    with np.errstate(all="ignore"):
        found = fit_trajectories(kernel, problem.series, base, model.fit.free, open_states=states,
                                 start=model.fit.values_by_label(), iterations=20).fit  # fmt: skip
    if np.isfinite(found.values).all() and np.isfinite(found.normal.log_likelihood).all():
        out.append(CriterionFit(model, found, TRAJECTORIES))
    return out


def fit_by_criterion(
    problem: CauseSearchProblem, model: FittedCauseSet, criterion: str
) -> CriterionFit:
    """A set with its numbers fitted to all trials by one criterion."""
    if criterion == PREDICTION_ERRORS:
        return CriterionFit(model, model.fit, criterion)
    found = fit_by_both_criteria(problem, model)
    return next((f for f in found if f.criterion == criterion), found[0])


def conditions_by_fold(series: Sequence[TrialSeries]) -> list[list[str]]:
    """Conditions in up to six folds."""
    conditions = sorted({s.condition for s in series})
    count = min(MAX_FOLDS, len(conditions))
    return [conditions[k::count] for k in range(count)]


def compare_held_out(
    model: Model, problem: CauseSearchProblem, baseline: FittedCauseSet, extended: FittedCauseSet,
    test: Sequence[TrialSeries],
) -> HeldOutErrors:  # fmt: skip
    """Errors on `test` where there are such trials, else by leaving conditions out in turn."""
    horizon = predictability_horizon_s(problem, extended, test or problem.series)
    found = held_out_errors_of_better_criterion(model, problem, (baseline, extended), test, horizon)
    floor = noise_floor_errors(model, problem, extended, test or problem.series, horizon)
    trials = tuple(s.name for s in (test or problem.series))
    (first, before), (second, after) = found
    return HeldOutErrors(trials, before, after, floor, (first, second), horizon)


@np.errstate(all="ignore")
def held_out_errors_of_better_criterion(
    model: Model,
    problem: CauseSearchProblem,
    sets: Sequence[FittedCauseSet],
    test: Sequence[TrialSeries],
    horizon_s: float,
) -> list[tuple[str, dict[str, float]]]:
    """Of each set the better criterion of its fit, and its errors on trials not fitted to."""
    parts = [(list(problem.series), list(test))] if test else [
        ([s for s in problem.series if s.condition not in fold],
         [s for s in problem.series if s.condition in fold])
        for fold in conditions_by_fold(problem.series)]  # fmt: skip
    parts = [p for p in parts if p[0] and p[1]] or [(list(problem.series), list(problem.series))]
    out = []
    for one in sets:
        errors: dict[str, list[Float]] = {}
        for train, own in parts:
            local = replace(problem, series=tuple(train))
            again = one if len(train) == len(problem.series) else refit_to_trials(local, one)
            for found in fit_by_both_criteria(local, again):
                rows = errors.setdefault(found.criterion, [])
                rows += segment_errors(model, local, found, own, horizon_s)
        best = min(errors, key=lambda k: _mean_square(errors[k]))
        out.append((best, rms_errors(model, errors[best])))
    return out


def refit_to_trials(problem: CauseSearchProblem, model: FittedCauseSet) -> FittedCauseSet:
    """The same set under the same noise, fitted to other trials; itself where that runs away."""
    found = fit_cause_set(problem, model.causes, model.noise, model.fit.values_by_label(),
                   free=[f for f in model.fit.free if f.group is None
                         or f.group in {s.group for s in problem.series}])  # fmt: skip
    if not found.is_finite:
        return model
    rest = {f.label: v for f, v in zip(model.fit.free, model.fit.values, strict=True)}
    both = rest | found.fit.values_by_label()
    values = np.array([both[f.label] for f in model.fit.free])
    if len(found.fit.free) == len(values):
        return found
    return replace(model, fit=replace(model.fit, values=values))


def predictability_horizon_s(
    problem: CauseSearchProblem, model: FittedCauseSet, series: Sequence[TrialSeries]
) -> float:
    """Time in which small differences grow by e^6, s: the median over trials."""
    kernel, own = problem.kernel, len(problem.kernel.system.states)
    values = CriterionFit(model, model.fit, "").parameter_vectors(problem, series)
    longest = [float(np.ptp(s.times)) for s in series]
    scale = np.sqrt(np.diag(series[0].cov))[:own]
    for k, (one, result) in enumerate(zip(series, filter_all(kernel, series, values, model.noise),
                                          strict=True)):  # fmt: skip
        growth = np.eye(own)
        for frame in range(1, len(one.times)):
            growth = result.transitions[frame, :own, :own] @ growth
            size = np.linalg.norm(growth * scale / scale[:, None], 2)
            if not np.isfinite(size) or size > np.exp(MAX_LOG_PERTURBATION_GROWTH):
                longest[k] = float(one.times[frame] - one.times[0])
                break
    return float(np.median(longest))


def cut_trials_into_segments(
    problem: CauseSearchProblem,
    found: CriterionFit,
    series: Sequence[TrialSeries],
    horizon_s: float,
) -> list[TrialSeries]:
    """Trials cut into segments not longer than the horizon, started at the smoothed states."""
    kernel, own = problem.kernel, len(problem.kernel.system.states)
    passes = filter_all(kernel, series, found.parameter_vectors(problem, series), found.model.noise)
    out = []
    for one, result in zip(series, passes, strict=True):
        count = max(1, int(np.ceil(np.ptp(one.times) / horizon_s - 1e-6)))
        edges = np.linspace(0, len(one.times), count + 1).astype(int)
        states = rts_smooth(result)[0] if count > 1 else result.filtered
        for a, b in pairwise(edges):
            if b - a < MIN_SEGMENT_FRAMES and count > 1:
                continue
            part = one.slice_frames(a, b)
            if a:
                mean = one.mean.copy()
                mean[:own] = np.where(np.isfinite(states[a, :own]), states[a, :own], mean[:own])
                part = replace(part, mean=mean)
            out.append(part)
    return out


def segment_errors(
    model: Model,
    problem: CauseSearchProblem,
    found: CriterionFit,
    series: Sequence[TrialSeries],
    horizon_s: float,
) -> list[Float]:
    """Simulated minus seen (frames, observations) of every segment, starts fitted."""
    parts = cut_trials_into_segments(problem, found, series, horizon_s)
    if not parts:
        return []
    runs = free_runs(problem.kernel, parts, found.parameter_vectors(problem, parts),
                  open_states=len(model.states))  # fmt: skip
    return [run.observed - part.seen for run, part in zip(runs, parts, strict=True)]


def rms_errors(model: Model, errors: Sequence[Float]) -> dict[str, float]:
    """Root mean squares of errors (frames, observations) by name, and of a place in the plane."""
    names = [o.name for o in model.observations]
    columns = np.concatenate([np.empty((0, len(names))), *errors]).T
    known = [column[~np.isnan(column)] for column in columns]
    mean = [float(np.mean(column**2)) if len(column) else np.nan for column in known]
    out = {f"{n}_rmse": float(np.sqrt(m)) for n, m in zip(names, mean, strict=True)}
    if model.path:
        out["path_rmse"] = float(np.sqrt(sum(mean[names.index(n)] for n in model.path)))
    return out


def _mean_square(errors: Sequence[Float]) -> float:
    rows = np.concatenate(errors) if errors else np.full((1, 1), np.inf)
    known = rows[~np.isnan(rows).any(axis=1)]
    return float(np.mean(known**2)) if len(known) and np.isfinite(known).all() else np.inf


@np.errstate(all="ignore")
def noise_floor_errors(
    model: Model,
    problem: CauseSearchProblem,
    found: FittedCauseSet,
    series: Sequence[TrialSeries],
    horizon_s: float,
) -> dict[str, float]:
    """Errors of a model on data made by itself, with random forces, trial effects and noise."""
    whole, rng = CriterionFit(found, found.fit, ""), np.random.default_rng(NOISE_FLOOR_SEED)
    values = whole.parameter_vectors(problem, series)
    filtered = filter_all(problem.kernel, series, values, found.noise)
    starts = np.array([rts_smooth(one)[0][0] for one in filtered])
    rows: list[Float] = []
    names, known = [one.name for one in series], found.fit.normal.effects.values
    for _ in range(NOISE_FLOOR_DRAWS):
        effects = sample_trial_effects(known, names, rng)
        at = parameter_vectors_with_trial_effects(problem.kernel, values, effects, found.noise)
        made = parametric_bootstrap(problem.kernel, series, at, [found.noise] * len(series),
                                    starts, rng)  # fmt: skip
        rows += segment_errors(model, problem, whole, made, horizon_s)
    return rms_errors(model, rows)
