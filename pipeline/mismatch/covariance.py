"""Covariance of a chosen model's numbers: how its trials disagree, and what its held shapes may be.

With the Fisher matrix in blocks of the fitted numbers s and the held shapes b, another shape moves
the numbers by -H_ss^-1 H_sb db. What is known of b is its spread beforehand and what the trials say
of it, divided by the inflation as elsewhere in the search.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..data import Float
from ..fitting import (
    Fit,
    Free,
    Spread,
    inverse_fisher,
    moving,
    normal_equations,
    pseudo_inverse,
    response,
    spread_over_trials,
)
from .bench import Bench
from .judge import Trialled, parameters_of
from .search import held_shapes, with_starts


def spread_of(bench: Bench, model: Trialled, aside: Mapping[str, float] | None = None) -> Spread:
    """`Spread` of a model's fitted numbers (p,), the doubt about its held shapes included.

    aside: label -> standard deviation of the side measurement that a number was taken from.
    """
    found = model.fit
    move = moving(bench.kernel, found)
    between = _one_trial_s_own(model, move, spread_over_trials(found.normal, move))
    cov = between.cov + _of_shapes(bench, model, move) + _of_aside(found, move, aside or {})
    return Spread(cov, between.freedom)


def _of_aside(found: Fit, move: np.ndarray, aside: Mapping[str, float]) -> Float:
    """Covariance (p, p) that numbers bring along which were taken from a side measurement."""
    cov = np.zeros((len(move), len(move)))
    H = found.normal.hessian.sum(axis=0)
    taken = [i for i, free in enumerate(found.free) if free.label in aside and move[i]]
    own = [i for i in np.flatnonzero(move).tolist() if i not in taken]
    for i in taken:
        along = np.zeros(len(move))
        along[i], along[own] = 1.0, response(H, own, [i])[:, 0]
        cov += aside[found.free[i].label] ** 2 * np.outer(along, along)
    return cov


def _one_trial_s_own(model: Trialled, move: np.ndarray, between: Spread) -> Spread:
    """`between`, where a number hangs on one trial alone (a camera knocked in it) with its naive
    variance times the inflation.
    """
    cov, freedom = between.cov.copy(), between.freedom.copy()
    own = np.flatnonzero(move & (freedom == 0))
    pooled = model.inflation * np.diag(inverse_fisher(model.fit.normal, move))
    cov[own, own] = np.maximum(cov[own, own], pooled[own])
    freedom[own] = max(len(model.fit.normal.hessian) - 1, 1)
    return Spread(cov, freedom)


def _of_shapes(bench: Bench, model: Trialled, move: np.ndarray) -> Float:
    """Covariance (p, p) that the held shapes add."""
    kernel, p = bench.kernel, len(model.fit.values)
    held = held_shapes(kernel, model)
    frees = [*model.fit.free, *(Free(name) for name in held)]
    cov = np.zeros((p, p))
    if not held or not move.any():
        return cov
    point = with_starts(kernel, bench.base, model.effects)
    values = np.concatenate([model.fit.values, list(held.values())])
    normal = normal_equations(kernel, bench.series, point, frees, values, noise=model.noise)
    if not normal.usable:
        return cov
    H = normal.hessian.sum(axis=0)
    own, shapes = np.flatnonzero(move).tolist(), list(range(p, p + len(held)))
    shift = response(H, own, shapes)
    known = np.array([one.spread**-2.0 for one in parameters_of(kernel, frees[p:])])
    seen = H[np.ix_(shapes, shapes)] - np.diag(known) + H[np.ix_(shapes, own)] @ shift
    open_ = pseudo_inverse(np.diag(known) + seen / model.inflation)
    cov[np.ix_(own, own)] = shift @ open_ @ shift.T
    return cov
