"""Second-order expansion of the likelihood about a fitted set, in the numbers of all candidates.

One batch of simulations gives, for every trial, the log likelihood, its gradient and its Fisher
information in the set's own numbers, in the strengths of all other candidates (differenced at
zero), in their functional forms, and in the residual terms.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..data import Float
from ..fitting import FreeParameter
from ..fitting.joint_fit import parameter_definition
from ..fitting.normal import (
    NormalEquationsByTrial,
    prior_terms,
)
from ..fitting.predictions import ParameterChange, finite_difference_step
from ..fitting.side_measurements import side_measurement_terms
from ..fitting.trial_effects import marginal_gram_matrices_at_effects
from ..integrate import System
from .candidates import CandidateCause, has_single_sign, strength_difference_step
from .cause_set_fit import FittedCauseSet, start_values
from .forces import rms_force_by_cause
from .problem import CauseSearchProblem

TriedForms = dict[str, list[tuple[dict[str, float], tuple[int, ...]]]]
"""Candidate -> form (label -> value) and the columns of its strengths in it."""


@dataclass(frozen=True)
class LikelihoodExpansion:
    """hessian (t, p, p), gradient (t, p), log_likelihood (t,) about a fitted set.

    own: columns of the set's free numbers, in order. strengths: other candidate -> columns. forms:
    other candidate -> columns of strength times (another form less the leading one). starts: other
    candidate with forms to try -> the form (label -> value) that its columns have, the likeliest.
    forces: those of the set's causes and of residual terms (`rms_force_by_cause`).
    """

    model: FittedCauseSet
    hessian: Float
    gradient: Float
    log_likelihood: Float
    own: tuple[int, ...]
    strengths: dict[str, tuple[int, ...]]
    forms: dict[str, tuple[int, ...]]
    starts: dict[str, dict[str, float]] = field(default_factory=dict)
    forces: dict[str, Float] = field(default_factory=dict)

    @property
    def is_finite(self) -> bool:
        """Whether all of it is finite."""
        return bool(np.isfinite(self.hessian).all() and np.isfinite(self.gradient).all())


def expand_likelihood(
    problem: CauseSearchProblem,
    model: FittedCauseSet,
    candidates: Sequence[CandidateCause] | None = None,
) -> LikelihoodExpansion:
    """`LikelihoodExpansion` about a fitted set, in its own numbers and those of `candidates` (all
    others), each in its likeliest form.
    """
    return restricted_to_likeliest_forms(
        problem, *expand_likelihood_in_all_forms(problem, model, candidates)
    )


def expand_likelihood_in_all_forms(
    problem: CauseSearchProblem,
    model: FittedCauseSet,
    candidates: Sequence[CandidateCause] | None = None,
) -> tuple[LikelihoodExpansion, TriedForms]:
    """Expansion about a fitted set with the columns of all forms that are tried of each candidate,
    and which those are.
    """
    kernel, system = problem.kernel, problem.kernel.system
    base = start_values(problem, model.causes, model.fit.values_by_label(), model.discrepancy)
    local = replace(problem, base=base)
    points = local.trial_parameter_vectors(model.fit.free, model.fit.values)
    every = np.ones(len(points), dtype=bool)
    changes: list[ParameterChange] = []
    for free, value in zip(model.fit.free, model.fit.values, strict=True):
        own = np.array([free.group in {None, s.group} for s in problem.series])
        changes.append(ParameterChange(finite_difference_step(kernel, free, float(value)), own,
                              {system.parameter_index[free.name]: 1.0}))  # fmt: skip
    own_columns = tuple(range(len(changes)))
    strengths: dict[str, tuple[int, ...]] = {}
    forms: dict[str, tuple[int, ...]] = {}
    tried: TriedForms = {}
    frees: list[FreeParameter] = list(model.fit.free)
    for candidate in problem.candidates if candidates is None else candidates:
        if candidate.name in model.causes:
            continue
        for values in _forms_to_try(problem, candidate, model.deviations):
            starts = {n: parameter_definition(system, FreeParameter(n)).start for n in values}
            offsets = {system.parameter_index[n]: v - starts[n] for n, v in values.items()}
            first = len(changes)
            for free in candidate.strengths:
                changes.append(_strength_perturbation(system, free, every, offsets))
                frees.append(free)
            columns = tuple(range(first, len(changes)))
            tried.setdefault(candidate.name, []).append((values, columns))
        strengths[candidate.name] = tried[candidate.name][0][1]
        forms[candidate.name] = ()
        if len(candidate.strengths) == 1 and not candidate.is_residual:
            first = len(changes)
            for form in candidate.forms:
                size, strength = _form_perturbation_size(system, form), candidate.strengths[0]
                offset = {system.parameter_index[form.name]: size}
                changes.append(_strength_perturbation(system, strength, every, offset))
                frees.append(candidate.strengths[0])
            forms[candidate.name] = tuple(range(first, len(changes)))
    normal = _trial_information_and_gradients(problem, model, points, changes, frees)
    runaway = np.flatnonzero(~np.isfinite(np.einsum("tpp->tp", normal.hessian)).all(axis=0))
    if runaway.size and runaway[0] >= len(own_columns):  # of a candidate, not of the set itself
        for k in runaway:
            changes[k] = replace(changes[k], step=finite_difference_step(kernel, frees[k], 0.0))
        normal = _trial_information_and_gradients(problem, model, points, changes, frees)
    derivatives = normal.hessian, normal.gradient
    hessian, gradient = _subtract_leading_form_columns(*derivatives, strengths, forms)
    whole = LikelihoodExpansion(
        model,
        hessian,
        gradient,
        normal.log_likelihood,
        own_columns,
        strengths,
        forms,
        forces=rms_force_by_cause(problem, model),
    )
    return whole, tried


def _trial_information_and_gradients(
    problem: CauseSearchProblem,
    model: FittedCauseSet,
    points: Sequence[Float],
    changes: Sequence[ParameterChange],
    frees: Sequence[FreeParameter],
) -> NormalEquationsByTrial:
    """Information, gradient and log likelihood of each trial in the changes, what each trial keeps
    for itself integrated out; side measurements and priors of the set's own numbers included.
    """
    kernel = problem.kernel
    products, constant, _ = marginal_gram_matrices_at_effects(
        kernel, model.passes, points, changes, noise=model.noise,
        effects=model.fitted_trial_effects(problem),
    )  # fmt: skip
    information, score, side = side_measurement_terms(kernel, problem.series, frees, points)
    p = len(model.fit.free)
    known = prior_terms(kernel, model.fit.free, model.fit.values, len(points))
    hessian, gradient = products[:, 1:, 1:] + information, products[:, 1:, 0] + score
    hessian[:, :p, :p] += known.hessian
    gradient[:, :p] += known.gradient
    likelihood = (model.passes.log_lik_const - 0.5 * products[:, 0, 0] + constant
                  + side + known.log_likelihood)  # fmt: skip
    return NormalEquationsByTrial(hessian, gradient, likelihood)


def _forms_to_try(
    problem: CauseSearchProblem, candidate: CandidateCause, fitted: Collection[str]
) -> list[dict[str, float]]:
    """Forms (label -> value) from which a candidate may begin, the leading one first: the tries of
    a residual term, the named forms of a cause that its shape parameters can give. A cause whose
    strength is 0 only within a tolerance keeps its leading form, which the tolerance is stated for.
    A residual term with a fitted weight in the discrepancy also keeps it: with other shape
    parameters, the same weight would be another force.
    """
    system = problem.kernel.system
    rows = [(f.label, parameter_definition(system, f)) for f in candidate.forms]
    if not candidate.is_residual:
        if any(f.name in problem.tolerances for f in candidate.strengths):
            return [{}]
        labels = {label for label, _ in rows}
        named = [{f"{candidate.name}.{k}": v for k, v in form.items()}
                 for form in system.effect(candidate.name).forms.values()]  # fmt: skip
        return [{}, *(form for form in named if form and form.keys() <= labels)]
    tries = [(label, p.tries) for label, p in rows if p.tries]
    leading = {label: p.start for label, p in rows if p.tries}
    if not tries or any(f.label in fitted for f in candidate.strengths):
        return [leading]
    further = [dict(zip(leading, values, strict=True))
               for values in zip(*(t for _, t in tries), strict=True)]  # fmt: skip
    return [leading, *(form for form in further if form != leading)]


def restricted_to_likeliest_forms(
    problem: CauseSearchProblem, whole: LikelihoodExpansion, tried: TriedForms
) -> LikelihoodExpansion:
    """The expansion with the columns of the likeliest form alone of what has several; a form that
    asks for an impossible sign of the strength is unlikely.
    """
    if not whole.is_finite:
        return whole
    H, g, own = whole.hessian.sum(axis=0), whole.gradient.sum(axis=0), list(whole.own)
    strengths, starts = dict(whole.strengths), {}
    unused: set[int] = set()
    for name, forms in tried.items():
        if len(forms) > 1:
            signed = has_single_sign(problem.kernel.system, problem.candidate_by_name[name])
            gains = [_misfit_reduction(H, g, own, list(columns), signed=signed)
                     for _, columns in forms]  # fmt: skip
            form, best = forms[int(np.argmax(gains))]
            strengths[name], starts[name] = best, form
            unused |= {i for _, columns in forms for i in columns} - set(best)
    keep = [i for i in range(len(g)) if i not in unused]
    place = {column: k for k, column in enumerate(keep)}

    def moved(columns: Mapping[str, tuple[int, ...]]) -> dict[str, tuple[int, ...]]:
        return {name: tuple(place[i] for i in own) for name, own in columns.items()}

    return replace(whole, hessian=submatrix(whole.hessian, keep), gradient=whole.gradient[:, keep],
                   strengths=moved(strengths), forms=moved(whole.forms), starts=starts)  # fmt: skip


def one_step_strength_estimates(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, cause: str
) -> dict[str, float]:
    """Label -> strength of a further cause by one Newton step of it and the set's own numbers,
    where that is possible: a fit that begins with the wrong sign loses the cause's form.
    """
    strengths = problem.candidate_by_name[cause].strengths
    columns = [*expansion.own, *expansion.strengths[cause]]
    step = _newton_step(expansion.hessian.sum(axis=0), expansion.gradient.sum(axis=0), columns)
    rows = [parameter_definition(problem.kernel.system, f) for f in strengths]
    known = [expansion.model.discrepancy.get(f.label, 0.0) for f in strengths]
    found = np.array(known) + step[len(expansion.own) :]
    return {f.label: float(value)
            for f, p, value in zip(strengths, rows, found, strict=True)
            if p.lower < value < p.upper and value != 0}  # fmt: skip


def _misfit_reduction(
    H: Float, g: Float, own: list[int], columns: list[int], *, signed: bool
) -> float:
    """Fall of the misfit by the columns when the set's own numbers are fitted with them; signed: 0
    where a column's best value is negative.
    """
    both = [*own, *columns]
    if signed and _newton_step(H, g, both)[-1] < 0:
        return 0.0
    return float(_quadratic_misfit_reduction(H, g, both) - _quadratic_misfit_reduction(H, g, own))


def _quadratic_misfit_reduction(H: Float, g: Float, columns: list[int]) -> float:
    return 0.5 * float(g[columns] @ _newton_step(H, g, columns))


def _newton_step(H: Float, g: Float, columns: list[int]) -> Float:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(H)[columns], 1e-30))
    A = H[np.ix_(columns, columns)] * np.outer(scale, scale)
    step: Float = scale * np.linalg.lstsq(A, scale * g[columns], rcond=1e-10)[0]
    return step


def _strength_perturbation(
    system: System, free: FreeParameter, every: np.ndarray, offsets: Mapping[int, float]
) -> ParameterChange:
    """Difference of a strength at 0, at the leading form or, with `offsets`, at another one."""
    direction = {system.parameter_index[free.name]: 1.0}
    return ParameterChange(strength_difference_step(system, free), every, direction, offsets)


def _form_perturbation_size(system: System, form: FreeParameter) -> float:
    """One prior standard deviation of a form, towards the farther bound and within it."""
    p = parameter_definition(system, form)
    size = min(p.spread, (p.upper - p.lower) / np.sqrt(12.0))
    up = p.upper - p.start >= p.start - p.lower
    return float(min(size, p.upper - p.start) if up else -min(size, p.start - p.lower))


def _subtract_leading_form_columns(
    hessian: Float, gradient: Float, strengths: Mapping[str, tuple[int, ...]],
    forms: Mapping[str, tuple[int, ...]],
) -> tuple[Float, Float]:  # fmt: skip
    """Information (t, p, p) and gradient (t, p) whose columns at another form are turned into
    differences from the leading one.
    """
    others = [c for columns in forms.values() for c in columns]
    leading = [strengths[name][0] for name, columns in forms.items() for _ in columns]
    hessian, gradient = hessian.copy(), gradient.copy()
    hessian[:, :, others] -= hessian[:, :, leading]
    hessian[:, others, :] -= hessian[:, leading, :]
    gradient[:, others] -= gradient[:, leading]
    return hessian, gradient


def submatrix(hessian: Float, columns: Sequence[int]) -> Float:
    """Rows and columns (..., k, k) of a matrix."""
    index = np.asarray(columns)
    return hessian[..., index[:, None], index]
