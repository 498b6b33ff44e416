"""Draws of the coefficients for bands, as wide as their stated intervals."""

from __future__ import annotations

import numpy as np
from scipy.special import stdtr, stdtrit

from ..data import Float
from ..fitting import (
    ParameterFit,
    newton_step_ignoring_bounds,
    sensitivity_to_other_parameters,
    student_t_draws,
)
from .bounds import intervals_at_bounds
from .joint_fit import JointFit


def sample_parameters(tuned: JointFit, count: int, rng: np.random.Generator) -> Float:
    """Draws (count, p) of a fit's numbers, within their bounds.

    Numbers off their bounds as in `student_t_draws`. One at its bound varies over its one-sided
    interval, with the distribution that it would have without bounds; the others respond to it by
    -H_mm^-1 H_mh. It stays at the bound where the data ask for values beyond it only.
    """
    found = tuned.fit
    out = student_t_draws(found, tuned.covariance, count, rng)
    at_bound = intervals_at_bounds(found)
    out[:, list(at_bound)] = found.values[list(at_bound)]
    held = [i for i, ends in at_bound.items() if np.isfinite(ends).all()]
    if held:
        moved = _sample_one_sided(found, held, rng.random((count, len(held)))) - found.values[held]
        out[:, held] += moved
        out += moved @ response_to_parameters_at_bounds(found, held).T
    return clip_to_bounds(found, out)


def clip_to_bounds(found: ParameterFit, rows: Float) -> Float:
    """Rows (count, p) clipped to the bounds of what is plausible."""
    bounds = found.definitions
    return np.clip(rows, [p.lower for p in bounds], [p.upper for p in bounds])


def _sample_one_sided(found: ParameterFit, held: list[int], u: Float) -> Float:
    """Values (count, held) within the one-sided intervals, from uniform u; evenly where nothing
    is known.
    """
    change, spread = newton_step_ignoring_bounds(found.normal)
    out = np.empty_like(u)
    for k, i in enumerate(held):
        low, high = intervals_at_bounds(found)[i]
        if spread.df[i] <= 0:
            out[:, k] = low + u[:, k] * (high - low)
            continue
        df, std = max(spread.df[i], 1.0), np.sqrt(spread.cov[i, i])
        middle = found.values[i] + change[i]
        first, last = stdtr(df, (np.array([low, high]) - middle) / std)
        quantiles = stdtrit(df, first + u[:, k] * (last - first))
        out[:, k] = np.clip(middle + std * quantiles, low, high)
    return out


def response_to_parameters_at_bounds(found: ParameterFit, held: list[int]) -> Float:
    """Response (p, held) of each number off its bounds to a change of those at a bound."""
    H = found.normal.hessian.sum(axis=0)
    bound = set(intervals_at_bounds(found))
    own = [i for i in range(len(H)) if i not in bound]
    out = np.zeros((len(H), len(held)))
    if own:
        out[own] = sensitivity_to_other_parameters(H, own, held)
    return out
