"""From a model and its trials to the problem that the engine is given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..data import Float
from ..engine import CauseSearchProblem, candidates_from_effects
from ..engine.candidates import RESIDUAL_EFFECT_KIND
from ..errors import InputError
from ..fitting import FreeParameter, Noise, TrialSeries, filter_all, trial_parameter_vector
from ..fitting.filtering import random_state_indices
from ..integrate import CompiledSystem, compile_system
from .diagnosis import divergence_error
from .model import Model
from .recording_faults import median_interval_s, motionless_findings
from .recording_warnings import time_unit_warnings
from .sampling import MIN_SAMPLES_PER_BLOCK, block_averaging_rate_hz
from .stepping import (
    MAX_LOG_LIKELIHOOD_CHANGE,
    fastest_rates_per_s,
    log_likelihood_change_by_finer_step,
    longest_step_at_start_s,
    longest_step_s,
)
from .system_assembly import AssembledSystem, assemble_system, residual_term_variables
from .trials import Trial, series_of_trials, split_trials_into_parts

MIN_TRIALS, MIN_SEGMENTS, MIN_SEGMENT_FRAMES = 4, 4, 50
"""Fewer trials are cut into stretches, so many in all or more, of so many frames at least. Each cut
loses the information of the state before it: no more cuts than resampling needs."""
MAX_CAUSES_PER_SET, MAX_SAMPLES = 6, 6000
"""Causes of a set, and samples of all trials beyond which they are averaged in blocks."""
RANDOM_FORCE_START_GRID = tuple(10.0**k for k in np.arange(-4.0, 4.1, 1.0))
"""Random forces, in units of the channel, among which the first guess is chosen."""


@dataclass(frozen=True)
class PreparedCauseSearch:
    """What the search needs and what is reported of it: problem, trials as cut, all series at the
    rate of the fit, steps and rates, sentences on the preparation.
    """

    model: Model
    assembly: AssembledSystem
    problem: CauseSearchProblem
    trials: tuple[Trial, ...]
    series: tuple[TrialSeries, ...]
    scales: dict[str, float]
    rate_hz: float
    step_s: float
    warnings: tuple[str, ...]


def prepare_cause_search(
    model: Model, trials: Sequence[Trial], names: Sequence[str], progress: Callable[[str], None]
) -> PreparedCauseSearch:
    """`PreparedCauseSearch` with the candidates of these names and all residual terms.

    Raises: InputError where nothing moves in the trials.
    """
    if motionless := motionless_findings(trials):
        raise InputError(motionless)
    progress("time constants")
    warnings: list[str] = []
    trials, cut = _split_trials_where_few(trials)
    if cut:
        one = "1 recording gives" if cut == 1 else f"{cut} recordings give"
        warnings.append(f"{one} {len(trials)} stretches that serve as trials; what differs from "
                        "one recording to another cannot be judged.")  # fmt: skip
    scales = variable_scales(model, trials)
    rate = fit_sampling_rate_hz(model, trials)
    model = with_correlation_times_above_frame(model, max(1.0 / rate, median_interval_s(trials)))
    assembly = assemble_system(model, hold=not np.isfinite(rate))
    base, free = assembly.system.parameter_vector({}), free_coefficients(model, trials)
    series = series_of_trials(model, assembly, trials, scales, rate)
    step = longest_step_at_start_s(compile_system(assembly.system), series, base)
    assembly = assemble_system(model, step_s=step, hold=not np.isfinite(rate))
    kernel = compile_system(assembly.system)
    noise = initial_noise(kernel, series, base)
    if noise is None:
        raise divergence_error(model, trials)
    fastest = partial(fastest_dynamics_rate_per_s, kernel, series, base, noise=noise)
    warnings += time_unit_warnings(trials, fastest(names=()))
    step = longest_step_s(fastest(names=names))
    force = {c: float(np.median(noise.disturbance[k])) for k, c in enumerate(model.channels)}
    assembly = assemble_system(model, force_scale=force, step_s=step, hold=not np.isfinite(rate))
    kernel = compile_system(assembly.system)
    series = series_of_trials(model, assembly, trials, scales, rate)
    named = [*names, *([RESIDUAL_EFFECT_KIND] if assembly.residual_sources else [])]
    problem = CauseSearchProblem(
        kernel=kernel, series=tuple(series), base=base, coefficients=free,
        candidates=candidates_from_effects(assembly.system, named, assembly.priors,
                                 assembly.residual_sources),
        noise=replace(noise, trial_effects=tuple(model.varies)), progress=progress,
        most_causes=MAX_CAUSES_PER_SET,
    )  # fmt: skip
    return PreparedCauseSearch(
        model, assembly, problem, tuple(trials), tuple(series), scales, rate, step, tuple(warnings)
    )


def with_correlation_times_above_frame(model: Model, frame_s: float) -> Model:
    """The model whose random parts stay correlated over a frame or longer: those that forget
    faster are white noise, and no integration step from frame to frame follows them.
    """
    force, error = (
        (max(start, frame_s), max(lower, frame_s), max(upper, frame_s))
        for start, lower, upper in (model.random_force_s, model.error_s)
    )
    return replace(model, random_force_s=force, error_s=error)


def _split_trials_where_few(trials: Sequence[Trial]) -> tuple[Sequence[Trial], int]:
    """Trials, cut into stretches where they are few, and how many were cut."""
    if len(trials) >= MIN_TRIALS:
        return trials, 0
    shortest = min(len(t.times) for t in trials)
    count = min(-(-MIN_SEGMENTS // len(trials)), shortest // MIN_SEGMENT_FRAMES)
    return (split_trials_into_parts(trials, count), len(trials)) if count > 1 else (trials, 0)


def free_coefficients(model: Model, trials: Sequence[Trial]) -> tuple[FreeParameter, ...]:
    """The model's own numbers; of those per group, one for each."""
    groups = sorted({t.group for t in trials})
    out: list[FreeParameter] = []
    for p in model.coefficients:
        own = (
            [FreeParameter(p.name, g) for g in groups]
            if p.name in model.per_group
            else [FreeParameter(p.name)]
        )
        out += own
    return tuple(out)


def variable_scales(model: Model, trials: Sequence[Trial]) -> dict[str, float]:
    """Typical size of each variable of residual terms: root mean square of an input or of the
    observation that a state is, or of its slope.
    """
    observed = {s.name: s.observed for s in model.states if s.observed}
    slopes = {s.name: s.rate_of for s in model.states if s.rate_of}
    out = {}
    for v in residual_term_variables(model):
        if v in observed:
            rows = [t.observed[observed[v]] for t in trials]
        elif v in slopes:
            rows = [_mean_slopes(t.times, t.observed[slopes[v]]) for t in trials]
        else:
            rows = [t.inputs.get(v, np.ones(1)) for t in trials]
        size = float(np.sqrt(np.nanmean(np.concatenate(rows) ** 2)))
        out[f"scale_{v}"] = size if np.isfinite(size) and size > 1e-12 else 1.0
    return out


def _mean_slopes(times: Float, values: Float) -> Float:
    """Mean slopes over fortieths of a trial."""
    known = np.isfinite(values)
    grid = np.linspace(times[0], times[-1], 41)
    return np.diff(np.interp(grid, times[known], values[known])) / np.diff(grid)


def fit_sampling_rate_hz(model: Model, trials: Sequence[Trial]) -> float:
    """Rate at which all trials together have `MAX_SAMPLES` samples, or the model's own; infinite
    where they have fewer, and where blocks would hold fewer samples than an average needs.
    """
    samples = sum(len(t.times) for t in trials)
    seconds = sum(float(np.ptp(t.times)) for t in trials)
    step = median_interval_s(trials)
    rate = np.inf
    if model.most_hz is not None and model.most_hz * step < 1.0:
        rate = model.most_hz
    elif samples > MAX_SAMPLES:
        rate = min(MAX_SAMPLES / seconds, 1.0 / (MIN_SAMPLES_PER_BLOCK * step))
    return block_averaging_rate_hz([t.times for t in trials], rate)


def stated_std(series: Sequence[TrialSeries]) -> Float:
    """Stated standard deviation (observations,) of trials: the median over them."""
    variances = [np.diagonal(s.noise, axis1=1, axis2=2).mean(axis=0) for s in series]
    return np.asarray(np.sqrt(np.median(variances, axis=0)))


def initial_noise(
    kernel: CompiledSystem, series: Sequence[TrialSeries], base: Float
) -> Noise | None:
    """Initial estimate of the random part: the likeliest of `RANDOM_FORCE_START_GRID`,
    errors that last as large as the stated ones. None where the model runs away with all of them.
    """
    forces = [e for e in kernel.system.effects if e.kind == "disturbance" and e.channels]
    pushed = len(forces[0].states) if forces else 0
    every = [e for e in kernel.system.effects if e.kind == "disturbance"]
    tau = np.array([p.start for e in every for p in e.parameters[1:]])
    slots = random_state_indices(kernel)
    std = stated_std(series)
    points = [trial_parameter_vector(kernel, base, (), np.zeros(0), s.group) for s in series]

    def noise(size: float) -> Noise:
        errors = std[: len(slots) - pushed]
        return Noise(np.concatenate([np.full(pushed, size), errors]), tau, np.ones(len(std)),
                     least_scale=1.0)  # fmt: skip

    def likelihood(size: float) -> float:
        passed = filter_all(kernel, series, points, noise(size))
        total = sum(f.log_likelihood for f in passed)
        return float(total) if np.isfinite(total) else -np.inf

    found = {size: likelihood(size) for size in (RANDOM_FORCE_START_GRID if pushed else (0.0,))}
    best = max(found, key=lambda size: found[size])
    return noise(best) if np.isfinite(found[best]) else None


def fastest_dynamics_rate_per_s(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    base: Float,
    *,
    noise: Noise,
    names: Sequence[str],
) -> float:
    """Rate (1/s) of the fastest model, bare or with one of the candidates at its plausible size."""
    system = kernel.system
    points = [base] * len(series)
    passes = filter_all(kernel, series, points, noise)
    fast = float(fastest_rates_per_s(kernel, passes, points).max())
    for name in names:
        effect = system.effect(name)
        own = base.copy()
        for p in effect.parameters[: effect.strengths]:
            own[system.parameter_index[f"{name}.{p.name}"]] = p.typical_magnitude
        fast = max(fast, float(fastest_rates_per_s(kernel, passes, [own] * len(series)).max()))
    return fast


def integration_step_error_and_warning(
    given: PreparedCauseSearch, values: Sequence[Float], noise: Noise
) -> tuple[float, str]:
    """Effect of half the integration step on the log likelihood, and a warning where it matters."""
    finer = assemble_system(
        given.model, step_s=0.5 * given.step_s, hold=not np.isfinite(given.rate_hz)
    )
    change = log_likelihood_change_by_finer_step(
        given.problem.kernel, compile_system(finer.system), given.problem.series, values, noise
    )
    if change <= MAX_LOG_LIKELIHOOD_CHANGE:
        return change, ""
    return change, (f"Half the integration step ({given.step_s:.3g} s) changes the log likelihood "
                    f"by {change:.2g}: the step is too long for this model.")  # fmt: skip
