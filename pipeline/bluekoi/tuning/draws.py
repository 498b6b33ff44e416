"""Draws of the coefficients for bands, as wide as their stated intervals."""

from __future__ import annotations

import numpy as np
from scipy.special import stdtr, stdtrit

from ..data import Float
from ..fitting import Fit, ensemble, response, without_bounds
from .bounds import one_sided, parameter_of
from .joint import Tuned


def drawn(tuned: Tuned, count: int, rng: np.random.Generator) -> Float:
    """Draws (count, p) of a fit's numbers, within their bounds.

    Numbers off their bounds as in `ensemble`. One at its bound varies over its one-sided interval,
    by the law that it would have if nothing were bounded; the others go along with it as the trials
    have it, by -H_mm^-1 H_mh. It stays where the data ask for values beyond its bound alone.
    """
    found = tuned.fit
    out = ensemble(found, tuned.spread, count, rng)
    at_bound = one_sided(found)
    out[:, list(at_bound)] = found.values[list(at_bound)]
    held = [i for i, ends in at_bound.items() if np.isfinite(ends).all()]
    if held:
        moved = _inside(found, held, rng.random((count, len(held)))) - found.values[held]
        out[:, held] += moved
        out += moved @ along(found, held).T
    return within(found, out)


def within(found: Fit, rows: Float) -> Float:
    """Rows (count, p) clipped to the bounds of what is plausible."""
    parameters = [parameter_of(f) for f in found.free]
    return np.clip(rows, [p.lower for p in parameters], [p.upper for p in parameters])


def _inside(found: Fit, held: list[int], u: Float) -> Float:
    """Values (count, held) within the one-sided intervals, from uniform u; evenly where nothing
    is known.
    """
    change, spread = without_bounds(found.normal)
    out = np.empty_like(u)
    for k, i in enumerate(held):
        low, high = one_sided(found)[i]
        if spread.freedom[i] <= 0:
            out[:, k] = low + u[:, k] * (high - low)
            continue
        freedom, std = max(spread.freedom[i], 1.0), np.sqrt(spread.cov[i, i])
        middle = found.values[i] + change[i]
        first, last = stdtr(freedom, (np.array([low, high]) - middle) / std)
        quantiles = stdtrit(freedom, first + u[:, k] * (last - first))
        out[:, k] = np.clip(middle + std * quantiles, low, high)
    return out


def along(found: Fit, held: list[int]) -> Float:
    """How far (p, held) each number off its bounds goes with a change of those held."""
    H = found.normal.hessian.sum(axis=0)
    bound = set(one_sided(found))
    own = [i for i in range(len(H)) if i not in bound]
    out = np.zeros((len(H), len(held)))
    if own:
        out[own] = response(H, own, held)
    return out
