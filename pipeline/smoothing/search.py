"""Process noise chosen by likelihood, and wrong measurements found from both sides in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from ..data import Float
from . import twin
from .chain import Chain, Mask
from .descent import descend

GATE_TAIL = 1e-5
"""A right measurement is refused about so often."""


@dataclass(frozen=True)
class Found:
    """Chain with its noise, the measurements of the first round and those that count in the end.

    logs: logarithms of the noise over its units; cost: what they and the outliers cost. shown:
    variance of the measuring errors that show, white or lasting, over what is stated. lasts:
    whether some of them last.
    """

    chain: Chain
    first: Mask
    used: Mask
    logs: Float
    cost: float
    shown: float
    lasts: bool = False


def most_likely(
    build: Callable[[Float], Chain],
    seen: Mask,
    *,
    first: Mask,
    spread: Float,
    starts: Sequence[Float],
    livelier: Sequence[Float] = (),
    rounds: int = 4,
) -> Found:
    """Chain whose noise has the greatest posterior, with outliers set aside.

    -2 log p = -2 log L(z | noise) + sum (log noise / spread)^2; the prior is weak (a factor
    e^spread about the unit) and keeps a noise that the data do not show from running off to zero.
    A measurement is set aside where it lies beyond the gate of what all the others, before and
    after it, predict (deletion residual); those set aside are tried again in each round.

    build: chain for logarithms of the noise (m,). seen: (n,) where there is a measurement at all;
    first: (n,) those that the first round uses. starts: logarithms from which the first round
    searches, the best end counts: a motion disturbed in its rate and one disturbed in its
    acceleration are valleys of their own. livelier: further ones, tried where the search ended at
    a measurement noise much larger than stated, in which every motion drowns.
    A measurement set aside counts in the cost as one that lies on the gate.
    """
    used, places = first, starts
    gate = gate_of(build(starts[0]).z.shape[1])
    for turn in range(rounds):
        limit = gate if turn == 0 else np.inf
        ends = [_search(build, used, limit, place, spread) for place in places]
        if min(ends, key=lambda end: end[1])[0][-1] > 2 * spread[-1]:
            ends += [_search(build, used, limit, place, spread) for place in livelier]
        logs = min(ends, key=lambda end: end[1])[0]
        places = [logs]
        chain = build(logs)
        kept = seen & (_deletion_squares(chain, _within(chain, used, limit)) <= gate)
        if np.array_equal(kept, used):
            break
        used = kept if kept.sum() > 0.5 * seen.sum() else used
    chain = build(logs)
    cost = _cost(chain, seen, used, gate) + _prior(logs, spread)
    return Found(chain, first, used, logs, cost, float(np.exp(logs[-1])))


def gate_of(size: int) -> float:
    """Squared normalised distance beyond which a measurement of `size` numbers is refused."""
    return float(chdtri(size, GATE_TAIL))


def _prior(logs: Float, spread: Float) -> float:
    return float(np.sum((logs / spread) ** 2))


def _cost(chain: Chain, seen: Mask, used: Mask, gate: float) -> float:
    """Minus twice the log likelihood, those set aside as if they lay on the gate."""
    aside = chain.R[seen & ~used]
    return twin.likelihood(chain, used, np.inf) + float(
        np.sum(gate + np.linalg.slogdet(2 * np.pi * aside)[1])
    )


def _within(chain: Chain, used: Mask, gate: float) -> Mask:
    if not np.isfinite(gate):
        return used
    squares = twin.innovations(chain, used, gate)
    return used & ~(squares > gate)


def _search(
    build: Callable[[Float], Chain], used: Mask, gate: float, start: Float, spread: Float
) -> tuple[Float, float]:
    """Logarithms of least cost, and the cost, outliers counted as lying on the gate."""

    def cost(at: Float) -> float:
        value = twin.likelihood(build(at), used, gate)
        return value + _prior(at, spread) if np.isfinite(value) else 1e12

    return descend(cost, start)


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
