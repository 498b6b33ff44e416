"""Second-order expansion of the likelihood about a fitted set, in the numbers of all candidates.

One batch of simulations gives, for every trial, the log likelihood, its gradient and its Fisher
information in the set's own numbers, in the strengths of all other candidates (differenced at
zero), in their functional forms, and in the residual terms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Free
from ..fitting.normal import (
    evidence_terms,
    fit_step,
    marginal_products,
    prior_terms,
    trial_effect_changes,
    trial_effect_stds,
)
from ..fitting.predictions import Change, whitened_products
from ..integrate import System
from .candidates import Candidate, parameter
from .problem import Problem
from .refit import FittedSet, start_of

FORM_STEP = 1.0
"""A form is differenced by this many prior standard deviations (towards the farther bound)."""


@dataclass(frozen=True)
class Expansion:
    """hessian (t, p, p), gradient (t, p), log_likelihood (t,) about a fitted set.

    own: columns of the set's free numbers, in order. strengths: other candidate -> columns. forms:
    other candidate -> columns of strength times (another form less the leading one).
    """

    model: FittedSet
    hessian: Float
    gradient: Float
    log_likelihood: Float
    own: tuple[int, ...]
    strengths: dict[str, tuple[int, ...]]
    forms: dict[str, tuple[int, ...]]

    @property
    def usable(self) -> bool:
        """Whether all of it is finite."""
        return bool(np.isfinite(self.hessian).all() and np.isfinite(self.gradient).all())


def expanded(
    problem: Problem, model: FittedSet, candidates: Sequence[Candidate] | None = None
) -> Expansion:
    """`Expansion` about a fitted set, in its own numbers and those of `candidates` (all others)."""
    kernel, system = problem.kernel, problem.kernel.system
    base = start_of(problem, model.causes, model.fit.by_label(), model.discrepancy)
    local = replace(problem, base=base)
    points = local.points(model.fit.free, model.fit.values)
    every = np.ones(len(points), dtype=bool)
    changes: list[Change] = []
    for free, value in zip(model.fit.free, model.fit.values, strict=True):
        own = np.array([free.group in {None, s.group} for s in problem.series])
        changes.append(Change(fit_step(kernel, free, float(value)), own,
                              {system.slot[free.name]: 1.0}))  # fmt: skip
    own_columns = tuple(range(len(changes)))
    strengths: dict[str, tuple[int, ...]] = {}
    forms: dict[str, tuple[int, ...]] = {}
    frees: list[Free] = list(model.fit.free)
    for candidate in problem.candidates if candidates is None else candidates:
        if candidate.name in model.causes:
            continue
        first = len(changes)
        for free in candidate.strengths:
            changes.append(_strength_change(system, free, every, {}))
            frees.append(free)
        strengths[candidate.name] = tuple(range(first, len(changes)))
        forms[candidate.name] = ()
        if len(candidate.strengths) == 1:
            first = len(changes)
            for form in candidate.forms:
                offset = _form_offset(system, form)
                changes.append(_strength_change(system, candidate.strengths[0], every,
                                                {system.slot[form.name]: offset}))  # fmt: skip
                frees.append(candidate.strengths[0])
            forms[candidate.name] = tuple(range(first, len(changes)))
    count = len(changes)
    changes += trial_effect_changes(kernel, points, model.noise)
    products, constant = marginal_products(
        whitened_products(kernel, model.passes, points, changes, model.noise),
        trial_effect_stds(kernel, points, model.noise),
    )
    side = evidence_terms(kernel, problem.series, frees, points)
    p = len(model.fit.free)
    known = prior_terms(kernel, model.fit.free, model.fit.values, len(points))
    hessian, gradient = products[:, 1:, 1:] + side.hessian, products[:, 1:, 0] + side.gradient
    hessian[:, :p, :p] += known.hessian
    gradient[:, :p] += known.gradient
    likelihood = (model.passes.log_lik_const - 0.5 * products[:, 0, 0] + constant
                  + side.log_likelihood + known.log_likelihood)  # fmt: skip
    turn = _form_differences(strengths, forms, count)
    return Expansion(model, turn.T @ hessian @ turn, gradient @ turn, likelihood, own_columns,
                     strengths, forms)  # fmt: skip


def _strength_change(
    system: System, free: Free, every: np.ndarray, offsets: Mapping[int, float]
) -> Change:
    """Difference of a strength at 0, at the leading form or, with `offsets`, at another one."""
    slot = system.slot[free.name]
    p = system.parameters[slot]
    return Change(1e-3 * max(abs(p.start), 0.01 * (p.upper - p.lower)), every, {slot: 1.0}, offsets)


def _form_offset(system: System, form: Free) -> float:
    """One prior standard deviation of a form, towards the farther bound and within it."""
    p = parameter(system, form)
    size = min(p.spread, (p.upper - p.lower) / np.sqrt(12.0)) * FORM_STEP
    up = p.upper - p.start >= p.start - p.lower
    return float(min(size, p.upper - p.start) if up else -min(size, p.start - p.lower))


def _form_differences(
    strengths: Mapping[str, tuple[int, ...]], forms: Mapping[str, tuple[int, ...]], count: int
) -> Float:
    """Matrix (count, count) that turns columns at another form into differences of forms."""
    turn = np.eye(count)
    for name, columns in forms.items():
        for column in columns:
            turn[strengths[name][0], column] = -1.0
    return turn


def sub(hessian: Float, columns: Sequence[int]) -> Float:
    """Rows and columns (..., k, k) of a matrix."""
    index = np.asarray(columns)
    return hessian[..., index[:, None], index]
