"""Process noise chosen by likelihood, and wrong measurements found from both sides in time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.stats import chi2

from ..data import Float
from . import twin
from .chain import Chain, Mask

GATE_TAIL = 1e-5
"""A right measurement is refused about so often."""


@dataclass(frozen=True)
class Found:
    """Chain with its noise, the measurements that count, and the logarithms chosen."""

    chain: Chain
    used: Mask
    logs: Float


def most_likely(
    build: Callable[[Float], Chain], seen: Mask, *, start: Float, spread: Float, rounds: int = 3
) -> Found:
    """Chain whose noise has the greatest posterior, with outliers set aside.

    -2 log p = -2 log L(z | noise) + sum ((log noise - start) / spread)^2; the prior is weak (a
    factor e^spread) and keeps a noise that the data do not show from running off to zero.
    A measurement is set aside where it lies beyond the gate of what all the others, before and
    after it, predict (deletion residual); those set aside are tried again in each round.

    build: chain for logarithms of the noise (m,). seen: (n,) where there is a measurement at all.
    """
    gate = float(chi2.isf(GATE_TAIL, build(start).z.shape[1]))
    logs, used = start, seen
    for turn in range(rounds):
        limit = gate if turn == 0 else np.inf
        logs = _search(build, used, limit, logs, (start, spread))
        chain = build(logs)
        kept = seen & (_deletion_squares(chain, _within(chain, used, limit)) <= gate)
        if turn and np.array_equal(kept, used):
            break
        used = kept if kept.sum() > 0.5 * seen.sum() else used
    return Found(build(logs), used, logs)


def _within(chain: Chain, used: Mask, gate: float) -> Mask:
    if not np.isfinite(gate):
        return used
    squares = twin.innovations(chain, used, gate)
    return used & ~(squares > gate)


def _search(
    build: Callable[[Float], Chain],
    used: Mask,
    gate: float,
    logs: Float,
    prior: tuple[Float, Float],
) -> Float:
    center, spread = prior

    def cost(at: Float) -> float:
        bounded = np.clip(at, center - 5 * spread, center + 5 * spread)
        value = twin.likelihood(build(bounded), used, gate)
        return value + float(np.sum(((at - center) / spread) ** 2)) if np.isfinite(value) else 1e12

    simplex = np.vstack([logs, logs + np.diag(np.minimum(spread, 1.5))])
    options = {"initial_simplex": simplex, "maxfev": 60 * len(logs), "xatol": 0.1, "fatol": 0.1}
    return np.asarray(minimize(cost, logs, method="Nelder-Mead", options=options).x)


def _deletion_squares(chain: Chain, used: Mask) -> Float:
    """Squared normalised distance of each measurement from what all the others say, (n,).

    With e = z - H x, and V = R - H P H' where the measurement was used, R + H P H' where not, the
    form e' V^-1 e is the deletion residual's; NaN measurements give 0.
    """
    state = twin.smoothed(chain, used)
    error = np.nan_to_num(chain.z - np.einsum("npd,nd->np", chain.H, state.x))
    seen = np.einsum("npd,nde,nqe->npq", chain.H, state.P, chain.H)
    V = chain.R + np.where(used, -1.0, 1.0)[:, None, None] * seen
    return np.einsum("np,np->n", error, np.linalg.solve(V, error[..., None])[..., 0])
