"""Which additions to a model pay, judged on trials that were not fitted.

Knows no fish: a model, candidate effects, trials. A candidate is fitted together with all the
coefficients of the model, since these have absorbed part of what it would explain. Its worth is
the gain in log likelihood on held-out conditions, each fold predicted from the others by a Newton
step from the joint fit (the trials' normal equations are kept apart for that).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

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
    normal_equations,
    pseudo_inverse,
    trial_values,
)
from ..integrate import Effect, Kernel

FOLDS = 6
PASSES = 2
"""How often the filter's gains follow a candidate's fit: first those of the model before it."""


@dataclass(frozen=True)
class Trialled:
    """A model with some effects, fitted: worth (trials,) is its held-out log likelihood.

    noise: the random part it was judged under.
    """

    effects: tuple[str, ...]
    fit: Fit
    worth: Float
    noise: Noise

    @property
    def total(self) -> float:
        """Held-out log likelihood of all trials."""
        return float(self.worth.sum())


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


def effect_frees(effect: Effect, *, shape: bool = True) -> list[Free]:
    """The numbers of an effect that a fit may change; its strengths alone where not `shape`."""
    parameters = effect.parameters if shape else effect.parameters[: effect.strengths]
    return [Free(f"{effect.name}.{p.name}") for p in parameters]


def with_starts(kernel: Kernel, base: Float, effects: Sequence[str], share: float = 1.0) -> Float:
    """`base` with the named effects at `share` of their starting strength, shapes at start."""
    out = base.copy()
    for name in effects:
        effect = kernel.system.effect(name)
        for i, (slot, p) in enumerate(
            zip(kernel.system.slots(name), effect.parameters, strict=True)
        ):
            out[slot] = p.start * (share if i < effect.strengths else 1.0)
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
    start: dict[str, float] | None = None,
    iterations: int = 12,
) -> Trialled:
    """The model with these effects, all its numbers fitted, and its held-out worth."""
    frees = [*coefficients, *(f for e in effects for f in effect_frees(kernel.system.effect(e)))]
    point = with_starts(kernel, base, effects, 0.3)
    known = dict(start or {})
    for _ in range(PASSES):
        found = fit(kernel, series, point, frees, noise, start=known, iterations=iterations,
                    tolerance=0.05, predictor=predictor)  # fmt: skip
        known = found.by_label()
        points = [trial_values(kernel, point, frees, found.values, s.group) for s in series]
        predictor = filter_all(kernel, series, points, noise)
    normal = normal_equations(kernel, series, point, frees, found.values, noise=noise,
                              predictor=predictor)  # fmt: skip
    found = replace(found, normal=normal)
    return Trialled(tuple(effects), found, held_out_worth(normal, folds(series)), noise)


def screened(
    kernel: Kernel,
    series: Sequence[Series],
    current: Trialled,
    base: Float,
    candidates: Sequence[str],
    *,
    noise: Noise,
    predictor: Sequence[Filtered] | None = None,
) -> dict[str, float]:
    """Candidate -> held-out gain expected of it, from one set of normal equations for all.

    At the current fit each candidate's strengths are differenced at zero beside the numbers
    already free; a step of Newton's in these alone foretells the refit.
    """
    shifted = [Free(f.name, f.group) for f in current.fit.free]
    strengths = {c: effect_frees(kernel.system.effect(c), shape=False) for c in candidates}
    frees = [*shifted, *(f for c in candidates for f in strengths[c])]
    values = np.concatenate([current.fit.values, np.zeros(len(frees) - len(shifted))])
    normal = normal_equations(kernel, series, base, frees, values, noise=noise, predictor=predictor)
    parts = folds(series)
    own = list(range(len(shifted)))
    reference = float(held_out_worth(_part(normal, own), parts).sum())
    gains, at = {}, len(shifted)
    for c in candidates:
        columns = [*own, *range(at, at + len(strengths[c]))]
        at += len(strengths[c])
        gains[c] = float(held_out_worth(_part(normal, columns), parts).sum()) - reference
    return gains


def _part(normal: Normal, columns: Sequence[int]) -> Normal:
    return Normal(
        normal.hessian[:, columns][:, :, columns],
        normal.gradient[:, columns],
        normal.log_likelihood,
    )
