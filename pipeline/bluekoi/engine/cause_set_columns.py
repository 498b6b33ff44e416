"""Columns of an expansion that make up a set of causes, with the priors of their numbers.

The discrepancy of a set consists of residual terms in the channels of its causes
(`CauseSearchProblem.covers`). In each channel it is as strong as one of
`PRIOR_RELATIVE_DISCREPANCY_STDS` of the cause's force (Kennedy and O'Hagan, J. R. Statist. Soc. B
63 (2001), 425).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from ..data import Float
from ..fitting import FreeParameter
from ..fitting.joint_fit import parameter_definition
from .candidates import CandidateCause, form_prior_precision, has_single_sign
from .expansion import LikelihoodExpansion
from .problem import CauseSearchProblem

PRIOR_RELATIVE_DISCREPANCY_STDS = (0.006, 0.02, 0.06, 0.2)
"""Prior of the standard deviation of a cause's discrepancy, relative to its force in each channel:
four values of equal probability, in place of a continuous distribution. `python -m validation
discrepancy DIR` estimates that distribution from how far the formulas in the literature differ from
each other. Its quantiles 1/8, 3/8 and 5/8, the middles of three of its four quarters, are 0.6, 2.2
and 5.2 % (`harbour_dock` 9201-002, 003, 007, 010, 014 and 017). The quantile 7/8, 142 %, belongs to
causes whose leading formulas exert no force at the start values, so that a share of it has no
meaning, and to formulas of the fin; the largest share is that of decision 035 (docs/decisions).
"""
MIN_RELATIVE_DISCREPANCY_STD = min(PRIOR_RELATIVE_DISCREPANCY_STDS)
"""The share under which a discrepancy is fitted first."""
MAX_RELATIVE_DISCREPANCY_STD = max(PRIOR_RELATIVE_DISCREPANCY_STDS)
"""The share of the columns' own precision, in place of which fits and evidence take others."""
MIN_INFORMATION = 1e-12
"""Below any information that trials have; keeps quotients of zeros finite."""


@dataclass(frozen=True)
class CauseSetColumns:
    """Columns (p,) of an expansion that make up a set, coefficients first, and their priors.

    count: of coefficients. blocks: cause -> positions of its strengths among the columns.
    precision (p,): 1 / magnitude^2 of strengths, 1 / variance of forms and discrepancy, 0 of
    coefficients. gaussian (p,): whether the prior is normal (forms, discrepancy). included (p,):
    whether the expansion's likelihood includes that prior. signed: cause -> whether its strength
    has one sign. at (p,): strengths and discrepancy at the expansion, 0 elsewhere. held (p,):
    columns at a bound that the gradient pushes against. sizes: cause -> plausible magnitudes.
    discrepancy: cause -> prior deviations (p,) of its discrepancy where that is as strong as the
    cause, 0 elsewhere.
    """

    columns: np.ndarray
    count: int
    blocks: dict[str, np.ndarray]
    precision: Float
    gaussian: np.ndarray
    included: np.ndarray
    signed: dict[str, bool]
    at: Float
    held: np.ndarray
    sizes: dict[str, Float]
    discrepancy: dict[str, Float] = field(default_factory=dict)


@dataclass(frozen=True)
class _SetParameter:
    """A parameter of a set: place and value in the expansion, prior precision, and whether the fit
    has the prior already.
    """

    index: int
    precision: float
    gaussian: bool
    at: float = 0.0
    included: bool = False


def columns_of_cause_set(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, causes: Sequence[str]
) -> CauseSetColumns:
    """`CauseSetColumns` of a set of causes in an expansion about any set."""
    values, count = expansion.model.fit.values, len(problem.coefficients)
    columns = [_SetParameter(i, 0.0, gaussian=False, at=float(values[i])) for i in range(count)]
    blocks: dict[str, np.ndarray] = {}
    for cause in causes:
        inside = cause in expansion.model.causes
        strengths, forms = (_columns_of_fitted_cause if inside else _columns_of_unfitted_cause)(
            problem, expansion, problem.candidate_by_name[cause]
        )
        blocks[cause] = np.arange(len(columns), len(columns) + len(strengths))
        columns += [*strengths, *forms]
    relative = _discrepancy_strength_scales(problem, expansion, causes)
    columns += _discrepancy_columns(problem, expansion, relative)
    columns += _columns_of_tolerated_offsets(problem, expansion, causes)
    system = problem.kernel.system
    return CauseSetColumns(
        columns=np.array([c.index for c in columns]),
        count=count,
        blocks=blocks,
        precision=np.array([c.precision for c in columns]),
        gaussian=np.array([c.gaussian for c in columns]),
        included=np.array([c.included for c in columns]),
        signed={c: has_single_sign(system, problem.candidate_by_name[c]) for c in causes},
        at=np.array([c.at for c in columns]),
        held=np.array([_is_held_at_bound(problem, expansion, c.index) for c in columns]),
        sizes={c: plausible_strengths(problem, c)[: len(blocks[c])] for c in causes},
        discrepancy={c: np.array([own.get(k.index, 0.0) for k in columns])
                     for c, own in relative.items() if own},
    )  # fmt: skip


def discrepancy_std_combinations(lay: CauseSetColumns) -> list[dict[str, float]]:
    """Cause -> share, for every combination of `PRIOR_RELATIVE_DISCREPANCY_STDS` of the causes."""
    causes = list(lay.discrepancy)
    return [dict(zip(causes, shares, strict=True))
            for shares in product(PRIOR_RELATIVE_DISCREPANCY_STDS, repeat=len(causes))]  # fmt: skip


def prior_precisions_given_stds(
    lay: CauseSetColumns, combinations: Sequence[Mapping[str, float]]
) -> Float:
    """Prior precisions (n, p) of the columns with each of n combinations of the shares of the
    discrepancies of the causes.
    """
    if not lay.discrepancy:
        return np.repeat(lay.precision[None], len(combinations), axis=0)
    shares = np.array([[one[c] for c in lay.discrepancy] for one in combinations])
    deviation = np.max(shares[:, :, None] * np.array(list(lay.discrepancy.values())), axis=1)
    own = np.maximum(deviation, MIN_INFORMATION) ** -2.0
    return np.asarray(np.where(deviation > 0, own, lay.precision))


def _columns_of_fitted_cause(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, candidate: CandidateCause
) -> tuple[list[_SetParameter], list[_SetParameter]]:
    """Strengths and forms of a cause that is in the expanded set.

    The likelihood of a fit includes normal priors of forms; one that is uniform between bounds
    counts by its width alone.
    """
    model, system = expansion.model, problem.kernel.system
    place = {f.label: i for i, f in enumerate(model.fit.free)}
    own = [f for f in candidate.strengths if f.label in place]
    sizes = plausible_strengths(problem, candidate.name)[: len(own)]
    values = [float(model.fit.values[place[f.label]]) for f in own]
    strengths = [_SetParameter(place[f.label], size**-2.0, gaussian=False, at=value)
                 for f, size, value in zip(own, sizes, values, strict=True)]  # fmt: skip
    free = [f for f in candidate.forms if f.label in place]
    included = [bool(np.isfinite(parameter_definition(system, f).spread)) for f in free]
    precisions = form_prior_precision(system, free)
    forms = [_SetParameter(place[f.label], float(precision), True, included=one)
             for f, precision, one in zip(free, precisions, included, strict=True)]  # fmt: skip
    return strengths, forms


def _columns_of_unfitted_cause(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, candidate: CandidateCause
) -> tuple[list[_SetParameter], list[_SetParameter]]:
    """Strengths of a cause that is not in the expanded set, and the differences of its forms, which
    are as large as the strength.
    """
    columns = expansion.strengths[candidate.name]
    sizes = plausible_strengths(problem, candidate.name)
    known = expansion.model.discrepancy
    strengths = [
        _SetParameter(i, float(size**-2.0), gaussian=False, at=known.get(f.label, 0.0))
        for f, i, size in zip(candidate.strengths, columns, sizes, strict=True)
    ]
    forms = expansion.forms[candidate.name]
    if not forms:
        return strengths, []
    size = _expected_strength(problem, expansion, candidate)
    return strengths, [_SetParameter(i, size**-2.0, gaussian=True) for i in forms]


def _expected_strength(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, candidate: CandidateCause
) -> float:
    """Size of the strength of a cause that is not in the expanded set: one Newton step, within once
    and ten times its plausible magnitude. A law of another form than the leading one may have no
    strength at the leading one; its forms must not be scaled to nothing with it.
    """
    columns = [*range(len(expansion.own)), expansion.strengths[candidate.name][0]]
    H = expansion.hessian.sum(axis=0)[np.ix_(columns, columns)]
    g = expansion.gradient.sum(axis=0)[columns]
    step = np.linalg.lstsq(H + 1e-9 * np.diag(np.diag(H)), g, rcond=1e-12)[0][-1]
    size = float(plausible_strengths(problem, candidate.name)[0])
    return float(np.clip(abs(step), size, 10.0 * size))


def plausible_strengths(problem: CauseSearchProblem, cause: str) -> Float:
    """Plausible magnitudes (strengths,) of a cause; those of residual terms are the problem's."""
    system, candidate = problem.kernel.system, problem.candidate_by_name[cause]
    if cause in problem.residual_sizes:
        return np.array(problem.residual_sizes[cause])
    strengths = [parameter_definition(system, f) for f in candidate.strengths]
    return np.array([one.typical_magnitude for one in strengths])


def _discrepancy_strength_scales(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, causes: Sequence[str]
) -> dict[str, dict[int, float]]:
    """Cause -> column of a residual term that may stem from its formula -> strength at which the
    term is as strong as the cause.
    """
    found: dict[str, dict[int, float]] = {}
    for cause in (
        c
        for c in causes
        if c in expansion.model.causes and not problem.candidate_by_name[c].is_residual
    ):
        candidate = problem.candidate_by_name[cause]
        found[cause] = {
            column: float(np.fmax(  # NaN where the model diverges
                _residual_strength_equal_to_cause(expansion, candidate, free, column),
                MIN_INFORMATION,
            ))
            for other in problem.candidates
            if other.name not in causes and other.name in expansion.strengths
            and problem.cause_covers_residual_term(candidate, other)
            for free, column in zip(other.strengths, expansion.strengths[other.name], strict=True)
        }  # fmt: skip
    return found


def _discrepancy_columns(
    problem: CauseSearchProblem,
    expansion: LikelihoodExpansion,
    relative: Mapping[str, Mapping[int, float]],
) -> list[_SetParameter]:
    """Residual terms that may stem from the formula of one of the causes: their prior deviation
    makes their force `MAX_RELATIVE_DISCREPANCY_STD` times that of the cause in the same channel.
    """
    largest: dict[int, float] = {}
    for own in relative.values():
        for column, size in own.items():
            largest[column] = max(largest.get(column, 0.0), size)
    fitted = {
        column: expansion.model.discrepancy.get(free.label, 0.0)
        for name, own in expansion.strengths.items()
        for free, column in zip(problem.candidate_by_name[name].strengths, own, strict=True)
    }
    return [
        _SetParameter(i, (MAX_RELATIVE_DISCREPANCY_STD * size) ** -2.0, gaussian=True, at=fitted[i])
        for i, size in largest.items()
    ]


def _residual_strength_equal_to_cause(
    expansion: LikelihoodExpansion, cause: CandidateCause, term: FreeParameter, column: int
) -> float:
    """Strength at which a residual term has the force of a cause in the term's channel; of a cause
    without force (an error of the camera), at which it is as visible as the cause.
    """
    own, unit = expansion.forces[cause.name], expansion.forces[term.label]
    if own.any():
        channel = int(np.argmax(unit))
        return float(own[channel] / max(unit[channel], MIN_INFORMATION))
    information = np.einsum("tpp->p", expansion.hessian)
    model = expansion.model
    place = {f.label: i for i, f in enumerate(model.fit.free)}
    columns = [place[f.label] for f in cause.strengths if f.label in place]
    visible = float(np.sum(information[columns] * model.fit.values[columns] ** 2))
    return float(np.sqrt(visible / max(information[column], MIN_INFORMATION)))


def _columns_of_tolerated_offsets(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, causes: Sequence[str]
) -> list[_SetParameter]:
    """Strengths that are 0 only within the tolerance of careful work, of causes not in the set."""
    return [
        _SetParameter(
            column,
            problem.tolerances[free.name] ** -2.0,
            gaussian=True,
            at=expansion.model.discrepancy.get(free.label, 0.0),
        )
        for name, columns in expansion.strengths.items()
        if name not in causes
        for free, column in zip(problem.candidate_by_name[name].strengths, columns, strict=True)
        if free.name in problem.tolerances
    ]


def _is_held_at_bound(
    problem: CauseSearchProblem, expansion: LikelihoodExpansion, column: int
) -> bool:
    """Whether a fitted number stands at a bound that the gradient pushes against."""
    free = expansion.model.fit.free
    if column >= len(free):
        return False
    p, value = (
        parameter_definition(problem.kernel.system, free[column]),
        expansion.model.fit.values[column],
    )
    g = float(expansion.gradient[:, column].sum())
    return bool((value <= p.lower and g <= 0) or (value >= p.upper and g >= 0))
