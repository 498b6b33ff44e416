"""The search for what a model leaves out: a model and its trials in, named causes out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..data import Float
from ..engine import (
    CauseSearchProblem,
    FitRequest,
    FittedCauseSet,
    FittedCauseSets,
    NamedCause,
    Posterior,
    ScoredCauseSet,
    choose_causes,
    insignificance_sentence,
    posterior_over_sets,
    refit_without_discrepancy,
    search_cause_sets,
)
from ..engine.calibration import calibrated_probability
from ..engine.cause_selection import MIN_NAMED_PROBABILITY, UNLISTED_FORCE_LABEL, log_evidence_gain
from ..engine.problem import no_progress
from ..engine.set_score import refit_with_reestimated_noise
from ..errors import InputError, InputIssue, did_you_mean
from ..fitting import TrialSeries
from .checks import refuse_invalid_model
from .comparison import (
    PREDICTION_ERRORS,
    CriterionFit,
    HeldOutErrors,
    compare_held_out,
    fit_by_criterion,
    held_out_errors_of_better_criterion,
    unconfirmed_causes_sentence,
)
from .diagnosis import divergence_error, reporting_compiler_errors
from .feedback import feedback_sentences
from .fit_quality import (
    input_unit_warnings,
    misstated_error_warnings,
    refuse_far_larger_errors,
    trial_disagreement_sentences,
)
from .model import Model
from .numbers import FittedNumber, at_bound_sentences, fitted_numbers, undetermined_sentences
from .preparation import (
    PreparedCauseSearch,
    integration_step_error_and_warning,
    prepare_cause_search,
)
from .recording_warnings import unusual_recording_warnings
from .sampling import averaged_to_rate
from .trials import HELD_OUT_ROLE, Trial, as_trial_series, split_trials_at_gaps, validated_trials

MAX_REMAINING_RANDOM_FORCE_SHARE = 0.5
"""Random force with the named causes over that without, above which the report warns."""


@dataclass(frozen=True)
class ComparedCauseSet:
    """A set of causes that `explain(compare=...)` was asked to fit.

    log_posterior: less that of the most probable set. fitted_to: criterion of the fit. numbers:
    fitted parameters. errors: root mean squares on conditions left out of the fit.
    """

    causes: tuple[str, ...]
    log_posterior: float
    fitted_to: str
    numbers: tuple[FittedNumber, ...]
    errors: dict[str, float]


@dataclass(frozen=True)
class CauseSearchResult:
    """Causes that a model lacks to describe its trials.

    - verdict: none, physics, measurement or unexplained;
    - named: causes with a probability above 1/2, the one with the largest gain first;
    - gains: log evidence that each named cause adds;
    - probabilities: calibrated probability of every candidate cause;
    - unexplained: calibrated probability of a force that no candidate describes;
    - baseline, extended: the model fitted without and with the named causes;
    - baseline_numbers, numbers: fitted parameters of the baseline and of the extended model;
    - held_out: errors on conditions that were not used in the fit;
    - compared: results of the sets of causes in the argument `compare` of `explain`;
    - warnings: what limits the result, in sentences.
    """

    prepared: PreparedCauseSearch
    posterior: Posterior
    verdict: str
    named: tuple[NamedCause, ...]
    gains: dict[str, float]
    unexplained: float
    probabilities: dict[str, float]
    baseline: CriterionFit
    extended: CriterionFit
    numbers: tuple[FittedNumber, ...]
    baseline_numbers: tuple[FittedNumber, ...]
    best: ScoredCauseSet
    held_out: HeldOutErrors
    warnings: tuple[str, ...]
    compared: tuple[ComparedCauseSet, ...] = ()

    @property
    def model(self) -> Model:
        """The model as given."""
        return self.prepared.model


def explain(
    model: Model, trials: Sequence[Trial], *, candidates: Sequence[str] | None = None, without:
    Sequence[str] = (), compare: Sequence[Sequence[str]] = (), progress: Callable[[str], None] =
    no_progress,
) -> CauseSearchResult:  # fmt: skip
    """Which of the model's causes act in the trials.

    candidates: names of the causes to ask for, all by default; without: names to leave out;
    compare: further sets of causes to fit and compare, whatever their probability.

    Raises: InputError for a model, a trial or a name that cannot be used, naming it.
    """
    refuse_invalid_model(model)
    whole = validated_trials(model, trials)
    given = split_trials_at_gaps(model, whole)
    names = requested_causes(model, candidates, without)
    for one in compare:
        requested_causes(
            replace(model, causes=[c for c in model.causes if c.name in names]), one, ()
        )
    fit = [t for t in given if t.role != HELD_OUT_ROLE]
    with reporting_compiler_errors(model):
        ready = prepare_cause_search(model, fit, names, progress)
    checked = partial(refuse_far_larger_errors, ready)
    try:
        visited = search_cause_sets(replace(ready.problem, check_baseline=checked))
    except np.linalg.LinAlgError:
        raise divergence_error(model, fit) from None
    problem = visited.problem
    ready = replace(ready, problem=problem)
    if not np.isfinite(visited.best.log_posterior):
        raise divergence_error(model, fit)
    progress("probabilities")
    found = posterior_over_sets(problem, list(visited.sets.values()))
    chosen = choose_causes(found, problem.candidate_by_name, partial(_fit_named, problem))
    named, best, (final, own) = chosen.named, chosen.best, chosen.model
    bare = visited.sets[frozenset()]
    gains = {c.name: log_evidence_gain(list(visited.sets.values()), best, c.name) for c in named}
    named.sort(key=lambda c: -gains[c.name])
    progress("held-out errors")
    test = series_of_further_trials(ready, [t for t in given if t.role == HELD_OUT_ROLE])
    errors = compare_held_out(model, problem, bare.model, final, test)
    base = fitted_numbers(problem.kernel, bare.model)
    warnings = _cause_search_warnings(ready, whole, best, bare, own=own, base=base)
    if any(model.by_name[c.name].kind != "measurement" for c in named):
        warnings += filter(None, [unconfirmed_causes_sentence(errors)])
    return CauseSearchResult(
        ready, found, verdict_of(model, named, chosen.unexplained), tuple(named), gains,
        chosen.unexplained,
        {n: calibrated_probability(found.inclusion.get(n, 0.0)) for n in names},
        fit_by_criterion(problem, bare.model, errors.fitted_to[0]),
        fit_by_criterion(problem, final, errors.fitted_to[1]), tuple(own), tuple(base), best,
        errors, (*map(insignificance_sentence, chosen.insignificant), *warnings),
        tuple(_fit_compared_set(ready, visited, tuple(one), test, errors.stretch_s)
              for one in compare),
    )  # fmt: skip


def _fit_named(
    problem: CauseSearchProblem, best: ScoredCauseSet
) -> tuple[tuple[FittedCauseSet, list[FittedNumber]], FittedCauseSet]:
    """A set by its formulas alone with its numbers, and its fit."""
    final = fit_without_discrepancy(problem, best.model)
    own = fitted_numbers(problem.kernel, final)
    return (final, own), final


def fit_without_discrepancy(problem: CauseSearchProblem, model: FittedCauseSet) -> FittedCauseSet:
    """A set fitted by the formulas of its causes alone, as it is simulated and reported: in the
    search its numbers are estimated beside what these formulas leave.
    """
    if not model.discrepancy:
        return model
    plain = refit_without_discrepancy(problem, model)
    return plain if plain.is_finite else model


def _fit_compared_set(
    ready: PreparedCauseSearch,
    visited: FittedCauseSets,
    causes: tuple[str, ...],
    test: Sequence[TrialSeries],
    horizon_s: float,
) -> ComparedCauseSet:
    """A set of causes, fitted from the baseline on where the search had no use for it."""
    problem = ready.problem
    start = visited.sets[frozenset()].model
    if (scored := visited.fit_and_keep(FitRequest(causes, start))) is None:
        return ComparedCauseSet(causes, -np.inf, PREDICTION_ERRORS, (), {})
    scored = refit_with_reestimated_noise(problem, scored)
    final = fit_without_discrepancy(problem, scored.model)
    ((criterion, errors),) = held_out_errors_of_better_criterion(
        ready.model, problem, [final], test, horizon_s
    )
    return ComparedCauseSet(causes, scored.log_posterior - visited.best.log_posterior, criterion,
                    tuple(fitted_numbers(problem.kernel, final)), errors)  # fmt: skip


def requested_causes(
    model: Model, candidates: Sequence[str] | None, without: Sequence[str]
) -> tuple[str, ...]:
    """Names of the causes to ask for, in the model's order."""
    known = list(model.by_name)
    unknown = [n for n in (*(candidates or ()), *without) if n not in known]
    if unknown:
        raise InputError([
            InputIssue(model.name, "causes", f"'{n}'", "a cause of the model",
                       did_you_mean(n, known) if known else "The model has no causes.")
            for n in unknown
        ])  # fmt: skip
    chosen = known if candidates is None else candidates
    return tuple(n for n in known if n in chosen and n not in without)


def series_of_further_trials(
    ready: PreparedCauseSearch, trials: Sequence[Trial]
) -> list[TrialSeries]:
    """Further trials as the filter has them, at the rate of the fit."""
    held = [i.held for i in ready.model.inputs]
    series = [as_trial_series(ready.model, ready.assembly, t, ready.scales) for t in trials]
    return [averaged_to_rate(one, ready.rate_hz, held) for one in series]


def verdict_of(model: Model, named: Sequence[NamedCause], unexplained: float) -> str:
    """none, physics, measurement or unexplained: the kind of the cause that explains most."""
    if unexplained > MIN_NAMED_PROBABILITY:
        return UNLISTED_FORCE_LABEL
    return model.by_name[named[0].name].kind if named else "none"


def _cause_search_warnings(
    ready: PreparedCauseSearch,
    trials: Sequence[Trial],
    best: ScoredCauseSet,
    bare: ScoredCauseSet,
    *,
    own: list[FittedNumber],
    base: list[FittedNumber],
) -> list[str]:
    out = [*ready.warnings, *unusual_recording_warnings(ready.model, trials)]
    out += trial_disagreement_sentences(best)
    out += misstated_error_warnings(ready, best.model)
    out += input_unit_warnings(ready, best.causes)
    if len(best.causes) == ready.problem.most_causes:
        out.append(f"The search ends at {len(best.causes)} causes; more may act.")
    out += _random_force_warnings(ready, best, bare)
    passes = best.model.passes
    held = {i.name: i.held and not np.isfinite(ready.rate_hz) for i in ready.model.inputs}
    out += feedback_sentences(
        held, [s.inputs for s in passes.series], [f.innovations for f in passes]
    )
    labels = {n.label for n in own}
    out += at_bound_sentences(own) + [
        f"Baseline: {w}" for w in at_bound_sentences([n for n in base if n.label in labels])
    ]
    out += undetermined_sentences(own)
    if w := integration_step_error_and_warning(
        ready, _parameter_vectors(ready, best.model), best.model.noise
    )[1]:
        out.append(w)
    return out


def _parameter_vectors(ready: PreparedCauseSearch, model: FittedCauseSet) -> list[Float]:
    return CriterionFit(model, model.fit, "").parameter_vectors(ready.problem, ready.problem.series)


def _random_force_warnings(
    ready: PreparedCauseSearch, best: ScoredCauseSet, bare: ScoredCauseSet
) -> list[str]:
    """Random forces that the named causes hardly reduced, or that last as long as they may."""
    out = []
    for k, channel in enumerate(ready.model.channels):
        now, before = best.model.noise.disturbance[k], bare.model.noise.disturbance[k]
        if best.causes and now > MAX_REMAINING_RANDOM_FORCE_SHARE * before and now > 0:
            out.append(f"The random force on {channel} is {now:.3g} with the named causes and "
                       f"{before:.3g} without: it may contain missing physics.")  # fmt: skip
        if best.model.noise.tau[k] >= 0.99 * ready.model.random_force_s[2]:
            out.append(
                f"The random force on {channel} lasts as long as it may "
                f"({ready.model.random_force_s[2]:g} s): it may stand for a lasting one."
            )
    return out
