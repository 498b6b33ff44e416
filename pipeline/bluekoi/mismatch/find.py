"""The steps from a fitted model to a verdict (docs/finder.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..data import SteadyState
from ..engine import (
    FittedCauseSet,
    NamedCause,
    Posterior,
    ScoredCauseSet,
    choose_causes,
    insignificance_sentence,
    posterior_over_sets,
    search_cause_sets,
)
from ..engine.cause_selection import MIN_NAMED_PROBABILITY, UNLISTED_FORCE_LABEL, log_evidence_gain
from ..fitting import (
    MAX_OVERDISPERSION,
    MissingForce,
    TrialSeries,
    force_of_added_effects,
    missing_force,
)
from ..integrate import CompiledSystem
from ..integrate.batch import threaded_map
from ..model import is_residual
from ..study import Study
from ..study.data_split import has_trial_roles, held_out_trials
from ..tuning import (
    JointFit,
    compiled_trial_system,
    downsampled,
    downsampled_with_head_angle_changes,
    fit_all_trials,
    steady_errors,
)
from .camera_displacement import (
    CameraDisplacement,
    detect_displacements,
    with_displacement_constants,
)
from .compared_models import compare_models, is_strength_parameter
from .drift import CameraDrift, trial_with_camera_drift
from .extended_model import fit_extended
from .missing_force_dependence import ExplainedForceShare, covariates, force_dependences
from .robot_problem import robot_cause_search_problem, undetermined_cause_warnings

MIN_RANDOM_FORCE_OVER_BASELINE = 0.1
"""The missing force is compared with the random forces of the final model, but with no less than
this share of the baseline's: a random force that a fit estimates as 0 is no unit. Only for the
choice of what the figures show."""
SEARCH_SAMPLING_RATE_HZ = 5.0
"""Observations a second in the search, for the published robot: what acts for a second or longer
loses nothing, and the time is half that of ten. The chosen set is fitted to ten."""


@dataclass(frozen=True)
class MismatchResult:
    """Everything the finder found; `results_json.mismatch_json` writes it.

    posterior: over sets of causes, on the trials to fit. named: causes, the one that explains most
    first. unexplained: probability that a force acts which no candidate describes. model: the most
    probable set of the named causes. baseline and extended: tuned models on the trials to fit;
    fitted_to: criterion of the fits of `errors`, by model. forces, dependences: what the
    baseline lacks, on all trials. errors: of both models on the held-out trials; floor_m: path
    error that a true model would have there; stretch_s: length of the compared
    segments.
    displacements: where the camera was, or seemed to be, moved during a trial. misfit_warnings:
    those of the warnings that say that the most probable set does not describe the trials.
    """

    verdict: str
    posterior: Posterior
    named: Sequence[NamedCause]
    unexplained: float
    model: FittedCauseSet
    gains: Mapping[str, float]
    baseline: JointFit
    extended: JointFit
    fitted_to: Mapping[str, str]
    forces: Sequence[MissingForce]
    dependences: Sequence[ExplainedForceShare]
    held_out: Sequence[str]
    errors: Mapping[str, Mapping[str, float]]
    floor_m: float
    stretch_s: float
    displacements: Sequence[CameraDisplacement] = ()
    warnings: Sequence[str] = ()
    misfit_warnings: Sequence[str] = ()


def find_mismatch(
    study: Study,
    series: Sequence[TrialSeries],
    steady: Mapping[str, SteadyState],
    *,
    smoothed_keypoints: bool = False,
    progress: Callable[[str], None],
) -> MismatchResult:
    """`MismatchResult` for the measured trials of a study.

    smoothed_keypoints: of `robot_cause_search_problem`.
    """
    kernel = compiled_trial_system(series)
    held_out = held_out_trials(study, [s.name for s in series])
    progress("baseline")
    averaged = downsampled(series)
    baseline = fit_all_trials([s for s in averaged if s.name not in held_out])
    displaced, drifting = _camera_displacements_and_drift(kernel, averaged, baseline)
    series, averaged = (
        with_displacement_constants(kernel, s, displaced) for s in (series, averaged)
    )
    if not has_trial_roles(study):
        # only the trial itself determines the size of its displacement
        held_out = [name for name in held_out if name not in {d.trial for d in displaced}]
    train = [s for s in averaged if s.name not in held_out]
    test = [s for s in series if s.name in held_out] or list(series)
    baseline = fit_all_trials(train) if displaced else baseline
    train_frames = [s for s in series if s.name not in held_out]
    searched = downsampled_with_head_angle_changes(train_frames, SEARCH_SAMPLING_RATE_HZ)
    camera = study.setup.camera
    problem = robot_cause_search_problem(
        kernel,
        searched,
        baseline,
        displaced=displaced,
        progress=progress,
        by_homography=camera is not None and camera.matrix is None,
        smoothed_keypoints=smoothed_keypoints,
    )
    visited = search_cause_sets(problem, baseline.fit.values_by_label())
    problem = visited.problem
    fitted = list(visited.sets.values())
    found = posterior_over_sets(problem, fitted)
    train_blocks = downsampled_with_head_angle_changes(train_frames)
    chosen = choose_causes(
        found, problem.candidate_by_name, partial(fit_extended, problem, train_blocks, baseline)
    )
    named, best, (final, extended) = chosen.named, chosen.best, chosen.model
    progress("missing force")
    with_causes = extended if best.causes else None
    (forces, depends), (compared, paths) = threaded_map(lambda task: task(), (
        partial(_missing_force_and_dependences, study, kernel, averaged, baseline, extended),
        partial(compare_models, study, kernel, baseline, with_causes, train=train, test=test),
    ))  # fmt: skip
    compared.setdefault("extended", compared["baseline"])
    errors = {
        name: {"path_rmse_m": one.path_rmse_m,
               **steady_errors(study, kernel, one.model, test, steady)}
        for name, one in compared.items()
    }  # fmt: skip
    gains = {c.name: log_evidence_gain(fitted, best, c.name) for c in named}
    ordered = sorted(named, key=lambda c: -gains[c.name])
    misfits = model_warnings(kernel, train, best)
    return MismatchResult(
        verdict=verdict_of(kernel, ordered, chosen.unexplained), posterior=found, named=ordered,
        unexplained=chosen.unexplained, model=final, gains=gains, baseline=baseline,
        extended=extended, forces=forces, dependences=depends,
        fitted_to={name: one.fitted_to for name, one in compared.items()},
        held_out=[s.name for s in test], errors=errors, floor_m=paths.floor_m,
        stretch_s=paths.horizon_s, displacements=displaced,
        misfit_warnings=misfits,
        warnings=[*map(insignificance_sentence, chosen.insignificant),
                  *misfits,
                  *_unconfirmed_warnings(named, held_out),
                  *undetermined_cause_warnings(kernel.system, train),
                  *([drifting.sentence] if drifting else [])],
    )  # fmt: skip


def _camera_displacements_and_drift(
    kernel: CompiledSystem, series: Sequence[TrialSeries], model: JointFit
) -> tuple[list[CameraDisplacement], CameraDrift | None]:
    """Displacements of the camera during a trial, and the trial whose positions drift, if any."""
    fitted = kernel, series, model.parameter_vectors_by_trial(kernel, series), model.noise
    return detect_displacements(*fitted), trial_with_camera_drift(*fitted)


def _missing_force_and_dependences(
    study: Study,
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    baseline: JointFit,
    extended: JointFit,
) -> tuple[list[MissingForce], list[ExplainedForceShare]]:
    """What the model lacks without its additions, and what that depends on.

    The coefficients are those found with the additions, since the baseline's own have absorbed
    part of what is missing; beside a residual force the named additions stay. The dependence is
    that of the additions' force; of a measurement error, that of the random forces in its stead.
    """
    free = extended.fit.free
    residual = any(is_residual(f.name) for f in free)
    full = extended.parameter_vectors_by_trial(kernel, series)
    values = [v.copy() for v in full]
    for f in free:
        if is_residual(f.name) or (
            "." in f.name and not residual and is_strength_parameter(kernel, f.name)
        ):
            for v in values:
                v[kernel.system.parameter_index[f.name]] = 0.0
    forces = missing_force(kernel, series, values, baseline.noise)
    trials = {t.trial_id: t for t in study.trials}
    count = forces[0].force.shape[1]
    units = np.maximum(
        extended.noise.disturbance[:count],
        MIN_RANDOM_FORCE_OVER_BASELINE * baseline.noise.disturbance[:count],
    )
    pushes = force_of_added_effects(kernel, series, full, values, extended.noise)
    shown = pushes if max(np.abs(p).max() for p in pushes) > 0 else [f.force for f in forces]
    return forces, force_dependences(series, shown, covariates(series, forces, trials), units)


def verdict_of(kernel: CompiledSystem, named: Sequence[NamedCause], unexplained: float) -> str:
    """none, physics, measurement or unexplained: the kind of the cause that explains most."""
    if unexplained > MIN_NAMED_PROBABILITY:
        return UNLISTED_FORCE_LABEL
    return kernel.system.effect(named[0].name).kind if named else "none"


MAX_RANDOM_OVER_TYPICAL_FORCE = 0.5
"""Share of the thrust above which random forces are called comparable to it."""


def _unconfirmed_warnings(named: Sequence[NamedCause], held_out: Sequence[str]) -> list[str]:
    """A sentence where causes are named and no trial is left out of the fit."""
    if not named or held_out:
        return []
    return ["No trial could be held out, so none confirms the named causes. Film each condition to "
            "both sides, and more powers and head angles."]  # fmt: skip


def model_warnings(
    kernel: CompiledSystem, train: Sequence[TrialSeries], best: ScoredCauseSet
) -> list[str]:
    """Sentences on signs that the model does not describe its trials."""
    out = []
    if (c := best.overdispersion) > MAX_OVERDISPERSION:
        out.append(
            f"The parameters differ between trials {c:.1f} times more (in variance) than their "
            "standard errors allow: something is missing that this model does not describe, or a "
            "few trials differ from the others. Look at the trials with the largest path errors."
        )
    tau = best.model.noise.tau[: len(best.model.noise.disturbance)]
    upper = [p.upper for e in kernel.system.effects if e.kind == "disturbance"
             for p in e.parameters[1:]]  # fmt: skip
    forces = best.model.noise.disturbance[:3]
    names = ("surge", "sway", "yaw")
    mean = _typical_thrust_and_moment(kernel, train, best)
    for name, force, main, t, bound in zip(names, forces, mean, tau, upper, strict=False):
        if force > MAX_RANDOM_OVER_TYPICAL_FORCE * main:
            at = " with a correlation time at its bound" if t >= 0.99 * bound else ""
            out.append(f"The estimated random {name} force is comparable to the main force{at}: "
                       "it may contain missing physics.")  # fmt: skip
    return out


def _typical_thrust_and_moment(
    kernel: CompiledSystem, train: Sequence[TrialSeries], best: ScoredCauseSet
) -> tuple[float, float, float]:
    """Typical thrust (N), used for surge and sway, and thrust times the head's arm (N m)."""
    names = kernel.system.constants
    values = best.model.fit.values_by_label()
    thrust = [values["C_T"] * 0.5 * s.constants[names.index("rho")] * s.constants[names.index("A")]
              * float(np.median(s.inputs[:, 1])) ** 2 for s in train]  # fmt: skip
    arm = float(np.median([abs(s.constants[names.index("l")]) for s in train]))
    typical = float(np.median(thrust))
    return typical, typical, typical * arm
