"""Which additions to a model pay, judged on trials that were not fitted.

Knows no fish: a model, candidate effects, trials. A candidate is fitted together with all the
coefficients of the model, since these have absorbed part of what it would explain. Its worth is
the gain in log likelihood on held-out conditions, each fold predicted from the others by a Newton
step from the joint fit (the trials' normal equations are kept apart for that). How sure its
strength is follows from leaving out trials, which correlated errors within a trial cannot feign.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import f as f_distribution

from ..data import Float
from ..fitting import (
    Filtered,
    Fit,
    Free,
    Noise,
    Normal,
    Series,
    filter_all,
    fit,
    jackknife_cov,
    moving,
    normal_equations,
    pseudo_inverse,
    trial_values,
)
from ..integrate import Kernel, System

FOLDS = 6
PASSES = 2
"""How often the filter's gains follow a candidate's fit: first those of the model before it."""


@dataclass(frozen=True)
class Trialled:
    """A model with some effects, fitted: worth (trials,) is its held-out log likelihood.

    noise: the random part it was judged under. inflation: how many times wider its numbers spread
    over trials than one Fisher matrix says (1 where errors are as independent as modelled).
    p_value: effect -> probability that strengths as sure as these come of nothing.
    """

    effects: tuple[str, ...]
    fit: Fit
    worth: Float
    noise: Noise
    inflation: float
    p_value: Mapping[str, float]

    @property
    def total(self) -> float:
        """Held-out log likelihood of all trials."""
        return float(self.worth.sum())


def trialled(
    kernel: Kernel, effects: Sequence[str], found: Fit, noise: Noise, series: Sequence[Series]
) -> Trialled:
    """`Trialled` of a finished fit; worth nothing where the fit's model runs away."""
    if not found.normal.usable:
        nothing = np.full(len(series), -np.inf)
        return Trialled(tuple(effects), found, nothing, noise, np.inf, dict.fromkeys(effects, 1.0))
    free = np.flatnonzero(moving(kernel, found)).tolist()
    worth = held_out_worth(_part(found.normal, free), folds(series))
    p_value = {name: p_value_of(kernel, found, name) for name in effects}
    return Trialled(tuple(effects), found, worth, noise, inflation(kernel, found), p_value)


def p_value_of(kernel: Kernel, found: Fit, effect: str) -> float:
    """Probability of an effect at least as sure as this where there is none.

    W = s' C^-1 s of its k strengths s with their covariance C over n trials; W / k is compared to
    Fisher's F with k and n - 1 degrees of freedom.
    """
    frees, strengths = candidate_frees(kernel.system, effect)
    names = [free.name for free in frees[:strengths]]
    own = [i for i, free in enumerate(found.free) if free.name in names]
    move = moving(kernel, found)
    move[own] = True
    cov = jackknife_cov(found.normal, move)[np.ix_(own, own)]
    s = found.values[own]
    wald = max(float(s @ pseudo_inverse(cov) @ s), 0.0)
    trials = int(np.sum(np.any(np.einsum("tpp->tp", found.normal.hessian)[:, own] > 0, axis=1)))
    return float(f_distribution.sf(wald / len(own), len(own), max(trials - 1, 1)))


def inflation(kernel: Kernel, found: Fit) -> float:
    """Mean eigenvalue of H C, at least 1: C over trials, H the Fisher matrix."""
    move = moving(kernel, found)
    H = found.normal.hessian.sum(axis=0)[np.ix_(move, move)]
    C = jackknife_cov(found.normal, move)[np.ix_(move, move)]
    return float(max(1.0, np.trace(H @ C) / max(int(move.sum()), 1)))


def folds(series: Sequence[Series], count: int = FOLDS) -> list[np.ndarray]:
    """Trials by fold; trials of one condition are never parted, folds are about equally long."""
    conditions = sorted({s.condition for s in series})
    order = {c: i % min(count, max(len(conditions), 1)) for i, c in enumerate(conditions)}
    chosen = np.array([order[s.condition] for s in series])
    return [np.flatnonzero(chosen == k) for k in sorted(set(order.values()))]


def held_out_worth(normal: Normal, parts: Sequence[np.ndarray]) -> Float:
    """Log likelihood (trials,) of each trial, predicted from the other folds.

    With the rest's Fisher matrix H and gradient g at the joint fit, the rest alone would move the
    numbers by H^-1 g; the left-out trials' likelihood follows to second order.
    """
    H, g = normal.hessian, normal.gradient
    worth = normal.log_likelihood.copy()
    total_h, total_g = H.sum(axis=0), g.sum(axis=0)
    for part in parts:
        rest = total_h - H[part].sum(axis=0) + 1e-6 * np.diag(np.diag(total_h))
        step = pseudo_inverse(rest) @ (total_g - g[part].sum(axis=0))
        worth[part] += g[part] @ step - 0.5 * np.einsum("p,tpq,q->t", step, H[part], step)
    return worth


def candidate_frees(system: System, name: str) -> tuple[list[Free], int]:
    """The numbers of a candidate that a fit may change, and how many of them are strengths.

    A candidate is an effect, or one term of an effect of many terms as `effect.term`.
    """
    if "." in name:
        return [Free(name)], 1
    effect = system.effect(name)
    return [Free(f"{name}.{p.name}") for p in effect.parameters], effect.strengths


def with_starts(kernel: Kernel, base: Float, effects: Sequence[str], share: float = 1.0) -> Float:
    """`base` with the named effects at `share` of their starting strength, shapes at start."""
    out, system = base.copy(), kernel.system
    for name in effects:
        frees, strengths = candidate_frees(system, name)
        for i, free in enumerate(frees):
            slot = system.slot[free.name]
            out[slot] = system.parameters[slot].start * (share if i < strengths else 1.0)
    return out


def try_effects(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    coefficients: Sequence[Free],
    effects: Sequence[str],
    *,
    noise: Noise,
    predictor: Sequence[Filtered] | None = None,
    start: Mapping[str, float] | None = None,
    iterations: int = 12,
    passes: int = PASSES,
) -> Trialled:
    """The model with these effects, all its numbers fitted, and its held-out worth."""
    frees = [*coefficients, *(f for e in effects for f in candidate_frees(kernel.system, e)[0])]
    point = with_starts(kernel, base, effects, 0.3)
    known = dict(start or {})
    for _ in range(passes):
        found = fit(kernel, series, point, frees, noise, start=known, iterations=iterations,
                    tolerance=0.05, predictor=predictor)  # fmt: skip
        known = found.by_label()
        points = [trial_values(kernel, point, frees, found.values, s.group) for s in series]
        predictor = filter_all(kernel, series, points, noise)
    normal = normal_equations(kernel, series, point, frees, found.values, noise=noise,
                              predictor=predictor)  # fmt: skip
    return trialled(kernel, effects, replace(found, normal=normal), noise, series)


@dataclass(frozen=True)
class Foretold:
    """What a refit with a candidate would bring: log likelihood, and where it would begin."""

    gain: float
    start: Mapping[str, float]


def screened(
    kernel: Kernel,
    series: Sequence[Series],
    current: Trialled,
    base: Float,
    candidates: Sequence[str],
    *,
    predictor: Sequence[Filtered] | None = None,
) -> dict[str, Foretold]:
    """Candidate -> what is expected of it, from one set of normal equations for all.

    At the current fit each candidate's strengths are differenced at zero beside the numbers
    already free; a step of Newton's in these alone foretells the refit. Numbers that stand at a
    bound stay there, and a strength that would leave its bounds foretells nothing. The gain is that
    on the fitted trials: far from the end of a refit, a fold left out is foretold badly.
    """
    shifted = list(current.fit.free)
    both = {c: candidate_frees(kernel.system, c) for c in candidates}
    strengths = {c: frees[:count] for c, (frees, count) in both.items()}
    frees = [*shifted, *(f for c in candidates for f in strengths[c])]
    values = np.concatenate([current.fit.values, np.zeros(len(frees) - len(shifted))])
    normal = normal_equations(kernel, series, base, frees, values, noise=current.noise,
                              predictor=predictor)  # fmt: skip
    own = np.flatnonzero(moving(kernel, current.fit)).tolist()
    if not _part(normal, own).usable:
        return {c: Foretold(-np.inf, {}) for c in candidates}
    reference = _step_gain(_part(normal, own))[1]
    told, at = {}, len(shifted)
    for c in candidates:
        columns = [*own, *range(at, at + len(strengths[c]))]
        at += len(strengths[c])
        told[c] = _foretold(kernel, _part(normal, columns), [frees[k] for k in columns],
                            values[columns], reference)  # fmt: skip
    return told


def _step_gain(normal: Normal) -> tuple[Float, float]:
    """Newton's step and the gain in log likelihood that it foretells, g' H^-1 g / 2."""
    g = normal.gradient.sum(axis=0)
    step = pseudo_inverse(normal.hessian.sum(axis=0)) @ g
    return step, 0.5 * float(g @ step)


def _foretold(
    kernel: Kernel, normal: Normal, frees: Sequence[Free], values: Float, reference: float
) -> Foretold:
    if not normal.usable:
        return Foretold(-np.inf, {})
    step, gain = _step_gain(normal)
    parameters = [kernel.system.parameters[kernel.system.slot[f.name]] for f in frees]
    lower, upper = np.array([(p.lower, p.upper) for p in parameters]).T
    end = values + step
    new = np.array(["." in f.name for f in frees]) & (values == 0.0)
    wrong_way = new & ((end < lower) | ((lower >= 0.0) & (step <= 0.0)))
    start = {f.label: float(v) for f, v in zip(frees, np.clip(end, lower, upper), strict=True)}
    return Foretold(-np.inf if wrong_way.any() else gain - reference, start)


def _part(normal: Normal, columns: Sequence[int]) -> Normal:
    return Normal(
        normal.hessian[:, columns][:, :, columns],
        normal.gradient[:, columns],
        normal.log_likelihood,
    )
