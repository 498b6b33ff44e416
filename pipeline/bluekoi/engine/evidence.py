"""Marginal likelihood of a set of causes, by Laplace's approximation at a fitted set.

The numbers of a set are its coefficients b (flat prior, profiled), the strengths s_k of its causes,
their functional forms f ~ N(leading form, spread^2), and a discrepancy d ~ N(0, tau^2): residual
terms in the channels of one of its causes (`Problem.covers`), as strong as the share `KAPPA` of
that cause (Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001), 425). With gradient g and
information H of the likelihood, prior precision P and G the Schur complement of H + P that is left
when b is profiled,

    log m(S) = log L + 1/2 g' (H + P)^-1 g + 1/2 log|P_fd| - 1/2 log|G| + k/2 log 2 pi
               + sum_k log p(s_k)

The strengths of each cause have a Cauchy prior (Jeffreys 1961, sec. 5.2) as wide as its plausible
magnitude, which its file states: an effect far smaller than plausible costs what its precision
costs, log(magnitude / standard error). Where one sign alone is possible, the half of it, and the
posterior's share on that side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln, log_ndtr

from ..data import Float
from .candidates import Candidate, form_precision, is_signed, parameter
from .expansion import Expansion
from .problem import Problem

KAPPA = 0.2
"""Prior standard deviation of a cause's discrepancy relative to its force (assumed)."""
LEAST = 1e-12
"""Below any information that trials have; keeps quotients of zeros finite."""
RIDGE = 1e-10  # beside ones on the diagonal, for columns that are nearly the same
ABSENT = -50.0  # log probability of what cannot be; finite, so that differences are defined


@dataclass(frozen=True)
class Layout:
    """Columns (p,) of an expansion that make up a set, coefficients first, and their priors.

    count: of coefficients. blocks: cause -> positions of its strengths among the columns.
    precision (p,): 1 / magnitude^2 of strengths, 1 / variance of forms and discrepancy, 0 of
    coefficients. gaussian (p,): whether the prior is normal (forms, discrepancy). included (p,):
    whether the expansion's likelihood includes that prior. signed: cause -> whether its strength
    has one sign. at (p,): strengths and discrepancy at the expansion, 0 elsewhere. held (p,):
    columns at a bound that the gradient pushes against. sizes: cause -> plausible magnitudes.
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


@dataclass(frozen=True)
class _Column:
    """One column of a set: its place in the expansion, prior precision, value at the expansion."""

    index: int
    precision: float
    gaussian: bool
    at: float = 0.0
    included: bool = False


def layout(problem: Problem, expansion: Expansion, causes: Sequence[str]) -> Layout:
    """`Layout` of a set of causes in an expansion about any set."""
    values, count = expansion.model.fit.values, len(problem.coefficients)
    columns = [_Column(i, 0.0, gaussian=False, at=float(values[i])) for i in range(count)]
    blocks: dict[str, np.ndarray] = {}
    for cause in causes:
        inside = cause in expansion.model.causes
        strengths, forms = (_fitted_columns if inside else _further_columns)(
            problem, expansion, problem.by_name[cause]
        )
        blocks[cause] = np.arange(len(columns), len(columns) + len(strengths))
        columns += [*strengths, *forms]
    columns += _discrepancy(problem, expansion, causes)
    columns += _tolerances(problem, expansion, causes)
    system = problem.kernel.system
    return Layout(
        columns=np.array([c.index for c in columns]),
        count=count,
        blocks=blocks,
        precision=np.array([c.precision for c in columns]),
        gaussian=np.array([c.gaussian for c in columns]),
        included=np.array([c.included for c in columns]),
        signed={c: is_signed(system, problem.by_name[c]) for c in causes},
        at=np.array([c.at for c in columns]),
        held=np.array([_is_held(problem, expansion, c.index) for c in columns]),
        sizes={c: plausible_sizes(problem, c)[: len(blocks[c])] for c in causes},
    )


def _fitted_columns(
    problem: Problem, expansion: Expansion, candidate: Candidate
) -> tuple[list[_Column], list[_Column]]:
    """Strengths and forms of a cause that is in the expanded set.

    The likelihood of a fit includes normal priors of forms; one that is uniform between bounds
    counts by its width alone.
    """
    model, system = expansion.model, problem.kernel.system
    place = {f.label: i for i, f in enumerate(model.fit.free)}
    own = [f for f in candidate.strengths if f.label in place]
    sizes = plausible_sizes(problem, candidate.name)[: len(own)]
    strengths = [_Column(place[f.label], size**-2.0, False, float(model.fit.values[place[f.label]]))
                 for f, size in zip(own, sizes, strict=True)]  # fmt: skip
    free = [f for f in candidate.forms if f.label in place]
    forms = [_Column(place[f.label], float(precision), True,
                     included=bool(np.isfinite(parameter(system, f).spread)))
             for f, precision in zip(free, form_precision(system, free), strict=True)]  # fmt: skip
    return strengths, forms


def _further_columns(
    problem: Problem, expansion: Expansion, candidate: Candidate
) -> tuple[list[_Column], list[_Column]]:
    """Strengths of a cause that is not in the expanded set, and the differences of its forms, which
    are as large as the strength.
    """
    columns = expansion.strengths[candidate.name]
    sizes = plausible_sizes(problem, candidate.name)
    strengths = [_Column(i, float(size**-2.0), False)
                 for i, size in zip(columns, sizes, strict=True)]  # fmt: skip
    forms = expansion.forms[candidate.name]
    if not forms:
        return strengths, []
    size = _expected_strength(problem, expansion, candidate)
    return strengths, [_Column(i, size**-2.0, gaussian=True) for i in forms]


def _expected_strength(problem: Problem, expansion: Expansion, candidate: Candidate) -> float:
    """Size of the strength of a cause that is not in the expanded set: one Newton step, within once
    and ten times its plausible magnitude. A law of another form than the leading one may have no
    strength at the leading one; its forms must not be scaled to nothing with it.
    """
    columns = [*range(len(expansion.own)), expansion.strengths[candidate.name][0]]
    H = expansion.hessian.sum(axis=0)[np.ix_(columns, columns)]
    g = expansion.gradient.sum(axis=0)[columns]
    step = np.linalg.lstsq(H + 1e-9 * np.diag(np.diag(H)), g, rcond=1e-12)[0][-1]
    size = float(plausible_sizes(problem, candidate.name)[0])
    return float(np.clip(abs(step), size, 10.0 * size))


def plausible_sizes(problem: Problem, cause: str) -> Float:
    """Plausible magnitudes (strengths,) of a cause; of residual terms as `Problem` states them."""
    system, candidate = problem.kernel.system, problem.by_name[cause]
    if cause in problem.residual_sizes:
        return np.array(problem.residual_sizes[cause])
    return np.array([parameter(system, f).typical for f in candidate.strengths])


def _discrepancy(problem: Problem, expansion: Expansion, causes: Sequence[str]) -> list[_Column]:
    """Residual terms that may stem from the formula of one of the causes: their prior deviation
    makes their force `KAPPA` times that of the cause.
    """
    information = np.einsum("tpp->p", expansion.hessian)
    model = expansion.model
    place = {f.label: i for i, f in enumerate(model.fit.free)}
    found: dict[int, tuple[float, float]] = {}
    for cause in (c for c in causes if c in model.causes and not problem.by_name[c].is_residual):
        candidate = problem.by_name[cause]
        own = [place[f.label] for f in candidate.strengths if f.label in place]
        visible = float(np.sum(information[own] * model.fit.values[own] ** 2))
        for other in problem.candidates:
            known = other.name not in causes and other.name in expansion.strengths
            if not known or not problem.covers(candidate, other):
                continue
            for free, column in zip(other.strengths, expansion.strengths[other.name], strict=True):
                deviation = KAPPA * np.sqrt(visible / max(information[column], LEAST))
                at = model.discrepancy.get(free.label, 0.0)
                found[column] = max(found.get(column, (LEAST, at)), (float(deviation), at))
    return [_Column(i, std**-2.0, gaussian=True, at=at) for i, (std, at) in found.items()]


def _tolerances(problem: Problem, expansion: Expansion, causes: Sequence[str]) -> list[_Column]:
    """Strengths that are 0 only within the tolerance of careful work, of causes not in the set."""
    return [
        _Column(column, problem.tolerances[free.name] ** -2.0, gaussian=True)
        for name, columns in expansion.strengths.items()
        if name not in causes
        for free, column in zip(problem.by_name[name].strengths, columns, strict=True)
        if free.name in problem.tolerances
    ]


def _is_held(problem: Problem, expansion: Expansion, column: int) -> bool:
    """Whether a fitted number stands at a bound that the gradient pushes against."""
    free = expansion.model.fit.free
    if column >= len(free):
        return False
    p, value = parameter(problem.kernel.system, free[column]), expansion.model.fit.values[column]
    g = float(expansion.gradient[:, column].sum())
    return bool((value <= p.lower and g <= 0) or (value >= p.upper and g >= 0))


def log_evidence(expansion: Expansion, lay: Layout) -> float:
    """Log m(S) of a set."""
    H = expansion.hessian.sum(axis=0)[np.ix_(lay.columns, lay.columns)]
    g = expansion.gradient.sum(axis=0)[lay.columns]
    return float(expansion.log_likelihood.sum()) + laplace(H, g, lay)


def laplace(H: Float, g: Float, lay: Layout) -> float:
    """What the numbers of a set add to the log likelihood: best step, Occam factor and priors.

    H (p, p), g (p,): information and gradient of the likelihood in the columns of the layout.
    """
    index = np.flatnonzero(~lay.held)
    if len(index) == 0:
        return 0.0
    precision = np.where(lay.included, 0.0, lay.precision)
    off = np.where(lay.gaussian & ~lay.included, lay.at, 0.0)  # from the mean of their prior, 0
    g = g - precision * off
    whole = H + np.diag(precision)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(whole)[index], 1e-30))
    A = whole[np.ix_(index, index)] * np.outer(scale, scale) + RIDGE * np.eye(len(index))
    step = np.zeros(len(g))
    step[index] = scale * np.linalg.solve(A, scale * g[index])
    # the width of the Cauchy prior regularises the step; it does not pull a strength to 0
    pull = np.where(lay.gaussian, 0.0, lay.precision)
    gain = 0.5 * float(g @ step) + 0.5 * float(pull @ step**2) - 0.5 * float(precision @ off**2)
    own = index >= lay.count
    if not own.any():
        return gain
    cov = np.linalg.inv(A)[np.ix_(own, own)] * np.outer(scale[own], scale[own])  # G^-1
    rest = index[own]
    normal = lay.gaussian[rest]
    return (
        gain
        + 0.5 * float(np.linalg.slogdet(cov)[1])
        + 0.5 * float(np.log(lay.precision[rest][normal]).sum())
        + sum(_strength_prior(cause, cov, rest, step, lay) for cause in lay.blocks)
    )


def _strength_prior(cause: str, cov: Float, rest: np.ndarray, step: Float, lay: Layout) -> float:
    """Log p(s) + k/2 log 2 pi of a cause's strengths at their best values; see `laplace`.

    A strength that is held at 0 makes the cause absent: e^-50, for no set is named for it. One that
    is held at another bound counts by its prior density over its plausible magnitude.
    """
    block = lay.blocks[cause]
    free = np.isin(block, rest)
    if not free.any():
        held, widths = lay.at[block], lay.sizes[cause]
        return ABSENT if not held.any() else _cauchy(held, widths) + float(np.log(widths).sum())
    own, sizes = block[free], lay.sizes[cause][free]
    k, values = len(own), lay.at[own] + step[own]
    side = 0.0
    if lay.signed[cause]:
        at = int(np.flatnonzero(rest == own[0])[0])
        side = np.log(2.0) + float(log_ndtr(values[0] / np.sqrt(cov[at, at])))
    return _cauchy(values, sizes) + 0.5 * k * float(np.log(2.0 * np.pi)) + side


def _cauchy(values: Float, sizes: Float) -> float:
    """Log density of the Cauchy distribution (k,) with these widths."""
    k = len(values)
    return float(
        gammaln(0.5 * (k + 1))
        - 0.5 * (k + 1) * np.log(np.pi)
        - np.log(sizes).sum()
        - 0.5 * (k + 1) * np.log1p(np.sum((values / sizes) ** 2))
    )


def log_prior(problem: Problem, causes: Sequence[str]) -> float:
    """Log prior probability of a set, relative to that of no cause."""
    odds = [problem.by_name[c].prior / (1.0 - problem.by_name[c].prior) for c in causes]
    return float(np.log(odds).sum())


def discrepancy_at_best(problem: Problem, expansion: Expansion, lay: Layout) -> dict[str, float]:
    """Residual term -> its most probable strength as a discrepancy of the set's causes."""
    H = expansion.hessian.sum(axis=0)[np.ix_(lay.columns, lay.columns)]
    g = expansion.gradient.sum(axis=0)[lay.columns]
    precision = np.where(lay.included, 0.0, lay.precision)
    prior = np.where(lay.gaussian & ~lay.included, lay.at, 0.0)
    free = ~lay.held
    A = (H + np.diag(precision))[np.ix_(free, free)]
    step = np.zeros(len(g))
    step[free] = np.linalg.lstsq(A, (g - precision * prior)[free], rcond=1e-10)[0]
    places = {
        column: free.label
        for name, columns in expansion.strengths.items() if problem.by_name[name].is_residual
        for free, column in zip(problem.by_name[name].strengths, columns, strict=True)
    }  # fmt: skip
    return {places[i]: float(lay.at[k] + step[k])
            for k, i in enumerate(lay.columns) if i in places and lay.gaussian[k]}  # fmt: skip
