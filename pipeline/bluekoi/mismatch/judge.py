"""How much a fitted model is worth: on trials left out, and how sure its effects are.

The worth is the log likelihood on held-out conditions, each fold predicted from the others (but
for shapes that these cannot tell, which cost what they gain by having seen it). How
sure a strength is follows from leaving out trials, which correlated errors within one cannot feign.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, fdtrc

from ..data import Float
from ..fitting import (
    Fit,
    Free,
    Noise,
    Normal,
    Passes,
    Series,
    inverse_fisher,
    jackknife_cov,
    log_likelihoods,
    moving,
    pseudo_inverse,
    scatter_cov,
    side_log_likelihoods,
    trial_values,
)
from ..integrate import Kernel, Parameter, System

FOLDS = 6
MOST_LOST = 50.0
"""Log likelihood that a trial left out may lose at most, whatever the other folds foretell."""
MOST_TOLD = 0.9
"""Share of the information on a shape above which the fold left out keeps it: the others cannot
foretell it, and what a strong effect's shape loses by chance (17, of a `wave_drag` that the one
fastest trial shaped) would count for or against whatever is tried beside it.
"""
VAGUE = 0.1
"""So does a shape that all trials together tell no better than to this part of its value: along a
curved ridge of strength and shape Newton's step leads astray.
"""
KEPT_COST = 1.0
"""A kept shape has seen the fold that it foretells: by so much log likelihood times the inflation
that is too good on the mean (half of it gained in the fit, half not lost in the prediction).
"""
NAMELESS = "residual"
MOMENTS = 2000
"""Moments at which a jump is looked for: 24 trials of some 80 observations."""
PRIOR_FREEDOM = 6
"""Trials that all numbers together count for, where few say how much one number varies."""


@dataclass(frozen=True)
class Trialled:
    """A model with some effects, fitted: worth (trials,) is its held-out log likelihood.

    noise: the random part it was judged under. inflation: how many times wider its numbers spread
    over trials than one Fisher matrix says (1 where errors are as independent as modelled).
    p_value: effect -> probability that strengths as sure as these come of nothing. side: log
    likelihood of the side measurements. astray: the inflation of the model's own coefficients
    alone: where it is large they mean different things in different trials, whatever the effects.
    """

    effects: tuple[str, ...]
    fit: Fit
    worth: Float
    noise: Noise
    inflation: float
    p_value: Mapping[str, float]
    side: float = 0.0
    astray: float = 1.0

    @property
    def total(self) -> float:
        """Held-out log likelihood of all trials."""
        return float(self.worth.sum())


def trialled(
    kernel: Kernel,
    effects: Sequence[str],
    found: Fit,
    noise: Noise,
    series: Sequence[Series],
    *,
    worth: Float | None = None,
) -> Trialled:
    """`Trialled` of a finished fit; worth nothing where the fit's model runs away.

    Without `worth` it has that on the fitted trials: a model to begin from, not yet judged.
    """
    if not found.normal.usable:
        nothing = np.full(len(series), -np.inf)
        return Trialled(tuple(effects), found, nothing, noise, np.inf, dict.fromkeys(effects, 1.0))
    wider = inflation(kernel, found)
    p_value = {name: p_value_of(kernel, found, name, wider) for name in effects}
    own = found.normal.log_likelihood if worth is None else worth
    return Trialled(tuple(effects), found, own, noise, wider, p_value,
                    astray=inflation(kernel, found, own=True))  # fmt: skip


def p_value_of(kernel: Kernel, found: Fit, effect: str, wider: float) -> float:
    """Probability of an effect at least as sure as this where there is none.

    W = s' C^-1 s of its k strengths s with covariance C; W / k is compared to Fisher's F. C is that
    between the n trials, moderated by what all numbers together say, the inverse Fisher matrix
    times the inflation, `wider`: the mean of both with weights n - 1 and `PRIOR_FREEDOM`, whose sum
    are the degrees of freedom (Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004), 3: few repeats).
    Numbers that side measurements alone tell are left out: one measurement is no n repeats.
    Where one trial alone informs on them there is no other; the chance is then that of chi-squared
    at any of `MOMENTS` moments: such an effect was looked for at all of them (`jumps`). Of a term
    without a name it is asked whether something is missing, not in what shape: vague shapes of it
    are held.
    """
    frees, strengths = candidate_frees(kernel.system, effect)
    aside = () if "." in effect else kernel.system.effect(effect).aside
    names = [f.name for f in frees[:strengths] if f.name.partition(".")[2] not in aside]
    own = [i for i, free in enumerate(found.free) if free.name in names]
    move = moving(kernel, found)
    if _is_nameless(kernel.system, effect):
        move &= ~(_vague(kernel, found) & own_numbers(found.free, effect))
    move[own] = True
    s = found.values[own]
    naive = inverse_fisher(found.normal, move)[np.ix_(own, own)]
    trials = int((np.einsum("tpp->tp", found.normal.hessian)[:, own] > 0).any(axis=1).sum())
    if telling(found.normal)[:, own].any(axis=1).sum() == 1 and len(found.normal.hessian) > 1:
        fisher = pseudo_inverse(naive) / wider
        return min(1.0, MOMENTS * float(chdtrc(len(own), s @ fisher @ s)))
    pooled = wider * naive
    between = jackknife_cov(found.normal, move)[np.ix_(own, own)]
    cov = (PRIOR_FREEDOM * pooled + (trials - 1) * between) / (PRIOR_FREEDOM + trials - 1)
    wald = max(float(s @ pseudo_inverse(cov) @ s), 0.0)
    return float(fdtrc(len(own), PRIOR_FREEDOM + trials - 1, wald / len(own)))


def inflation(kernel: Kernel, found: Fit, *, own: bool = False) -> float:
    """Mean eigenvalue of H C, at least 1: C over trials, H the Fisher matrix, both of the numbers
    that more than one trial tells of. C without bias: few trials are no sign of a wrong model.

    own: of the model's own coefficients alone, H being that left of them when the numbers of the
    effects are free as well.
    """
    move = moving(kernel, found) & (telling(found.normal).sum(axis=0) > 1)
    if not move.any():
        return 1.0
    H = found.normal.hessian.sum(axis=0)[np.ix_(move, move)]
    C = scatter_cov(found.normal, move)[np.ix_(move, move)]
    if own:
        names = [free.name for free, moves in zip(found.free, move, strict=True) if moves]
        kept = [i for i, name in enumerate(names) if "." not in name]
        H = pseudo_inverse(pseudo_inverse(H)[np.ix_(kept, kept)])
        C = C[np.ix_(kept, kept)]
    return float(max(1.0, np.trace(H @ C) / max(len(H), 1)))


def telling(normal: Normal) -> np.ndarray:
    """Which trials tell of which number (trials, p): a thousandth of what one may, at least."""
    information = np.einsum("tpp->tp", normal.hessian)
    return information > 1e-3 * information.max(axis=0)


def folds(series: Sequence[Series], count: int = FOLDS) -> list[np.ndarray]:
    """Trials by fold; trials of one condition are never parted, folds are about equally long."""
    conditions = sorted({s.condition for s in series})
    order = {c: i % min(count, max(len(conditions), 1)) for i, c in enumerate(conditions)}
    chosen = np.array([order[s.condition] for s in series])
    return [np.flatnonzero(chosen == k) for k in sorted(set(order.values()))]


def held_out_worth(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    found: Fit,
    *,
    noise: Noise,
    predictor: Passes,
) -> Float:
    """Log likelihood (trials,) of each trial at the numbers that the other folds alone give.

    With the rest's Fisher matrix H and gradient g at the joint fit, the rest alone would move the
    numbers by H^-1 g, within their bounds; the trials left out are run anew with these. Where a
    fold holds most of what is known of a number, a prediction to second order is worth nothing: a
    shape stays as it is then, and since a strength may lie anywhere, no trial loses more than
    `MOST_LOST`.
    """
    move = moving(kernel, found)
    shape = _shapes(kernel.system, found.free)[move]
    vague = _vague(kernel, found)[move]
    normal = part_of(found.normal, np.flatnonzero(move).tolist())
    told, wider = np.einsum("tpp->tp", normal.hessian), inflation(kernel, found)
    cost = np.zeros(len(series))
    bounds = np.array([(p.lower, p.upper) for p in parameters_of(kernel, found.free)])
    points: list[Float] = [base] * len(series)
    for part in folds(series):
        kept = kept_shapes(normal, part, shape, vague)
        values = found.values.copy()
        values[move] += step_of_rest(normal, part, kept)
        share = told[part].sum(axis=0)[kept] / np.maximum(told.sum(axis=0)[kept], 1e-300)
        cost[part] = KEPT_COST * wider * share.sum() / len(part)
        values = np.clip(values, bounds[:, 0], bounds[:, 1])
        for t in part:
            points[t] = trial_values(kernel, base, found.free, values, series[t].group)
    seen = log_likelihoods(kernel, points, noise=noise, predictor=predictor)
    worth = np.nan_to_num(seen, nan=-np.inf) + side_log_likelihoods(kernel, series, points)
    return np.maximum(worth, found.normal.log_likelihood - MOST_LOST) - cost


def kept_shapes(
    normal: Normal, part: np.ndarray, shape: np.ndarray, vague: np.ndarray
) -> np.ndarray:
    """Which numbers (p,) stay as they are when the trials `part` are left out: shapes that are
    vague, or of which `part` has told nearly all.
    """
    total, own = (np.einsum("tpp->p", h) for h in (normal.hessian, normal.hessian[part]))
    return vague | (shape & (own >= MOST_TOLD * total))


def step_of_rest(normal: Normal, part: np.ndarray, kept: np.ndarray) -> Float:
    """Newton's step (p,) of the trials that are not in `part`, without the numbers kept."""
    total, own, moved = normal.hessian.sum(axis=0), normal.hessian[part].sum(axis=0), ~kept
    rest = (total - own + 1e-6 * np.diag(np.diag(total)))[np.ix_(moved, moved)]
    gradient = normal.gradient.sum(axis=0) - normal.gradient[part].sum(axis=0)
    step = np.zeros(len(kept))
    step[moved] = pseudo_inverse(rest) @ gradient[moved]
    return step


def own_numbers(free: Sequence[Free], effect: str) -> np.ndarray:
    """Which numbers are an effect's own (p,)."""
    return np.array([f.name.startswith(f"{effect}.") for f in free], dtype=bool)


def _is_nameless(system: System, effect: str) -> bool:
    return system.effect(effect.partition(".")[0]).kind == NAMELESS


def _shapes(system: System, free: Sequence[Free]) -> np.ndarray:
    """Which numbers are shapes of effects, not strengths (p,)."""
    shapes = {f.name for e in system.effects
              for frees, strengths in [candidate_frees(system, e.name)]
              for f in frees[strengths:]}  # fmt: skip
    return np.array([f.name in shapes for f in free], dtype=bool)


def _vague(kernel: Kernel, found: Fit) -> np.ndarray:
    """Which numbers are shapes that all trials together tell worse than to `VAGUE` (p,)."""
    std = np.sqrt(np.diag(inverse_fisher(found.normal, moving(kernel, found))))
    return _shapes(kernel.system, found.free) & (std > VAGUE * np.abs(found.values))


def parameters_of(kernel: Kernel, free: Sequence[Free]) -> list[Parameter]:
    """The parameters that these numbers are values of."""
    return [kernel.system.parameters[kernel.system.slot[f.name]] for f in free]


def candidate_frees(system: System, name: str) -> tuple[list[Free], int]:
    """The numbers of a candidate that a fit may change, and how many of them are strengths.

    A candidate is an effect, or one term of an effect of many terms as `effect.term`.
    """
    if "." in name:
        return [Free(name)], 1
    effect = system.effect(name)
    return [Free(f"{name}.{p.name}") for p in effect.parameters], effect.strengths


def part_of(normal: Normal, columns: Sequence[int]) -> Normal:
    """Normal equations of some of the numbers, the others held."""
    return Normal(
        normal.hessian[:, columns][:, :, columns],
        normal.gradient[:, columns],
        normal.log_likelihood,
    )
