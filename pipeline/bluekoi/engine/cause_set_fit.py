"""Nonlinear fits of a set of causes, with all their functional forms and their own noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..data import Float
from ..fitting import (
    FilterResults,
    FreeParameter,
    Noise,
    ParameterFit,
    filter_all,
    fit_parameters_jointly,
    log_likelihood_by_trial,
    trial_normal_equations,
)
from ..fitting.joint_fit import parameter_definition
from .candidates import CandidateCause
from .problem import CauseSearchProblem

STEP_TOLERANCE_STDS = 0.2
"""A fit ends with a step of this many standard deviations in the mean square. The step is taken; by
the quadratic model it gains at most 0.02 of log likelihood for each number."""


@dataclass(frozen=True)
class FittedCauseSet:
    """A set of causes, fitted: names, fit, noise, the filter's pass at the fit, which numbers stand
    at a bound (p,).

    discrepancy: label -> value of what is fitted with its numbers and integrated out: residual
    terms, for what the formulas of its causes leave, and offsets within the tolerance of careful
    work. deviations: label -> prior standard deviation of that. noise_is_final: another estimate
    of the noise at these numbers would not gain.
    """

    causes: tuple[str, ...]
    fit: ParameterFit
    noise: Noise
    passes: FilterResults
    at_bound: np.ndarray
    discrepancy: Mapping[str, float] = field(default_factory=dict)
    deviations: Mapping[str, float] = field(default_factory=dict)
    noise_is_final: bool = False

    @property
    def is_finite(self) -> bool:
        """Whether the fit is finite."""
        return self.fit.normal.all_finite

    @property
    def log_likelihood(self) -> float:
        """Of all trials; forms' priors included."""
        return self.fit.log_likelihood if self.is_finite else -np.inf

    @property
    def log_joint(self) -> float:
        """Log likelihood with the prior of the discrepancy, less its constant."""
        prior = sum((self.discrepancy.get(k, 0.0) / std) ** 2 for k, std in self.deviations.items())
        return self.log_likelihood - 0.5 * prior

    def fitted_trial_effects(self, problem: CauseSearchProblem) -> Float | None:
        """Most probable trial effects (t, q) at the fit, where it is to the trials of a problem."""
        same = [t.name for t in self.passes.series] == [t.name for t in problem.series]
        return self.fit.normal.effects.values if same else None

    @property
    def key(self) -> frozenset[str]:
        """The set of causes."""
        return frozenset(self.causes)


def free_parameters(
    problem: CauseSearchProblem, causes: Sequence[str]
) -> tuple[FreeParameter, ...]:
    """The numbers of a set: coefficients, then each cause's strengths and forms."""
    have = {name for s in problem.series for name in s.evidence}
    out: list[FreeParameter] = list(problem.coefficients)
    for cause in causes:
        candidate = problem.candidate_by_name[cause]
        effect = problem.kernel.system.effect(cause.partition(".")[0])
        blind = {
            f"{effect.name}.{p}"
            for p, by in effect.measurements_by_nuisance_parameter.items()
            if not by & have
        }
        out += [
            f
            for f in candidate.strength_and_form_parameters
            if f.name not in blind and f not in out
        ]
    return tuple(out)


def start_values(
    problem: CauseSearchProblem,
    causes: Sequence[str],
    known: Mapping[str, float],
    discrepancy: Mapping[str, float] | None = None,
) -> Float:
    """Base point with the forms of the causes at their leading form, or where they are known."""
    out, system = problem.base.copy(), problem.kernel.system
    for label, value in (discrepancy or {}).items():
        out[system.parameter_index[label]] = value
    for cause in causes:
        for free in problem.candidate_by_name[cause].strength_and_form_parameters:
            slot = system.parameter_index[free.name]
            out[slot] = known.get(free.label, 0.3 * system.parameters[slot].start
                                  if free in problem.candidate_by_name[cause].strengths
                                  else system.parameters[slot].start)  # fmt: skip
    return out


def fit_cause_set(
    problem: CauseSearchProblem,
    causes: Sequence[str],
    noise: Noise,
    known: Mapping[str, float],
    *,
    passes: int = 4,
    iterations: int = 12,
    free: Sequence[FreeParameter] | None = None,
    discrepancy: Mapping[str, float] | None = None,
    deviations: Mapping[str, float] | None = None,
    effects: Float | None = None,
    predictor: FilterResults | None = None,
) -> FittedCauseSet:
    """A set fitted under one noise; after the first fit the filter's gains are held, `passes` fits
    in all or until the numbers rest.

    deviations: those of the discrepancy, which is fitted with the numbers of the set; without, it
    is held. effects: trial effects (t, q) to begin with. predictor: the filter's passes at the
    start, where known.
    """
    own = free_parameters(problem, causes) if free is None else tuple(free)
    slot = problem.kernel.system.parameter_index
    left = dict.fromkeys(deviations or {}, 0.0) | dict(discrepancy or {})
    frees = (*own, *map(FreeParameter, deviations or {}))
    point = start_values(problem, causes, known, left)
    start = {f.label: left.get(f.label, known.get(f.label, float(point[slot[f.name]])))
             for f in frees}  # fmt: skip

    def filtered(values: Float) -> FilterResults:
        points = replace(problem, base=point).trial_parameter_vectors(frees, values)
        return filter_all(problem.kernel, problem.series, points, noise)

    def fitted(
        gains: FilterResults | None, begin: Mapping[str, float], near: Float | None
    ) -> ParameterFit:
        return fit_parameters_jointly(
            problem.kernel,
            problem.series,
            point,
            frees,
            noise,
            start=begin,
            iterations=iterations,
            tolerance=STEP_TOLERANCE_STDS,
            predictor=gains,
            spreads=deviations,
            effects=near,
        )

    first = start
    if predictor is None:
        predictor = filtered(np.array([start[f.label] for f in frees]))
    for _ in range(passes):
        found = fitted(predictor, start, effects)
        predictor = filtered(found.values)
        if not (found.normal.all_finite and np.isfinite(total_log_likelihood(predictor))):
            found = fitted(None, first, None)  # held gains do not serve that far from the start
            predictor = filtered(found.values)
        if _squared_distance_to_start(found, start) < 1.0:
            break
        start, effects = found.values_by_label(), found.normal.effects.values
    values = found.values[: len(own)]
    left |= {label: found.values_by_label()[label] for label in deviations or {}}
    point = start_values(problem, causes, known, left)
    normal = trial_normal_equations(problem.kernel, problem.series, point, own, values, noise=noise,
                                    predictor=predictor,
                                    effects=found.normal.effects.values)  # fmt: skip
    rows = [parameter_definition(problem.kernel.system, f) for f in own]
    bound = [not p.lower < v < p.upper for p, v in zip(rows, values, strict=True)]
    return FittedCauseSet(
        tuple(causes),
        replace(found, free=own, values=values, normal=normal),
        noise,
        predictor,
        np.array(bound, dtype=bool),
        left,
        deviations or {},
    )


def multi_start_strengths(
    problem: CauseSearchProblem, candidate: CandidateCause
) -> tuple[float, ...]:
    """Strengths from which fits of a candidate begin, where one start may mislead; else none."""
    if candidate.is_residual:
        return ()
    return problem.kernel.system.effect(candidate.name).starts


def likeliest_strength_start(
    problem: CauseSearchProblem, near: FittedCauseSet, cause: str
) -> dict[str, float]:
    """Label -> the start of a cause's first strength at which the trials are likeliest, all else as
    fitted; empty where one start serves.
    """
    candidate = problem.candidate_by_name[cause]
    starts, label = multi_start_strengths(problem, candidate), candidate.strengths[0].label
    if not starts:
        return {}
    base = start_values(problem, (*near.causes, cause), near.fit.values_by_label())
    slot = problem.kernel.system.parameter_index[candidate.strengths[0].name]

    def likelihood(start: float) -> float:
        point = base.copy()
        point[slot] = start
        points = replace(problem, base=point).trial_parameter_vectors(
            near.fit.free, near.fit.values
        )
        found = log_likelihood_by_trial(
            problem.kernel, points, noise=near.noise, predictor=near.passes
        )
        return float(np.nan_to_num(found, nan=-np.inf).sum())

    return {label: max(starts, key=likelihood)}


def _squared_distance_to_start(found: ParameterFit, start: Mapping[str, float]) -> float:
    change = found.values - np.array([start.get(f.label, np.inf) for f in found.free])
    if not np.isfinite(change).all() or not found.normal.all_finite:
        return np.inf
    return float(change @ found.normal.hessian.sum(axis=0) @ change / max(len(change), 1))


def refit_from_fitted_values(
    problem: CauseSearchProblem, model: FittedCauseSet, noise: Noise, *,
    discrepancy: Mapping[str, float] | None = None,
    deviations: Mapping[str, float] | None = None, predictor: FilterResults | None = None,
) -> FittedCauseSet:  # fmt: skip
    """A set fitted from where it is, with its own discrepancy and deviations or others; predictor:
    as in `fit_cause_set`.
    """
    return fit_cause_set(
        problem,
        model.causes,
        noise,
        model.fit.values_by_label(),
        free=model.fit.free,
        effects=model.fitted_trial_effects(problem),
        predictor=predictor,
        discrepancy=model.discrepancy if discrepancy is None else discrepancy,
        deviations=model.deviations if deviations is None else deviations,
    )


def off_bounds_mask(model: FittedCauseSet) -> np.ndarray:
    """Which fitted numbers are off their bounds, (p,)."""
    return ~model.at_bound


def total_log_likelihood(passes: FilterResults) -> float:
    """Log likelihood of all trials; -inf where the model diverges."""
    total = sum(f.log_likelihood for f in passes)
    return total if np.isfinite(total) else -np.inf
