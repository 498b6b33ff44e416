"""Where the water swings: names are sought anew beside it, with the swing among the model's own.

So strong and so regular a push bends every other law to it, and a fin beside it stays unseen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Float
from ..fitting import Free, Series
from ..model import is_nameless, plates
from .bench import Bench
from .judge import Trialled, candidate_frees, own_numbers
from .locate import Dependence
from .nameless import PULSE, SWING, nameless
from .select import Choice, choose
from .setting import CHANNELS

OF_TIME = (SWING, PULSE)
LEAST_CHANNEL = 0.02
MANY = 4


def beside_a_swing(
    bench: Bench, choice: Choice, residual: Trialled
) -> tuple[Bench, Choice, Trialled]:
    """Bench, choice and nameless terms of a search beside the swing that is in `residual`.

    The swing's numbers are then free in every model of the search, and in none of its effects.
    """
    bench.progress("names beside water that swings")
    others = [e for e in residual.effects if e != SWING]
    swing = bench.less(residual, others, choice.bare) if others else residual
    own = candidate_frees(bench.kernel.system, SWING)[0]
    bench = replace(bench, coefficients=(*bench.coefficients, *own))
    anew = choose(bench, replace(swing, effects=()))
    anew = replace(anew, rounds=(*choice.rounds, *anew.rounds))
    return bench, anew, nameless(bench, anew.chosen, anew.bare)


def swings(free: Sequence[Free]) -> bool:
    """Whether a swing is among the numbers of a model."""
    return bool(own_numbers(free, SWING).any())


def of_time(
    series: Sequence[Series], forces: Sequence[Float], told: Sequence[Dependence], units: Float,
    free: Sequence[Free],
) -> list[Dependence]:  # fmt: skip
    """`told` for a push that is a swing's or a pulse's: it depends on the time wholly, however
    fast it changes, in their channels.

    forces: (n, channels) of each trial; units (channels,): see `dependences`.
    """
    present = [name for name in OF_TIME if own_numbers(free, name).any()]
    own = [any(channel in plates().effect(name).channels for name in present)
           for channel in CHANNELS]  # fmt: skip
    size = np.array([np.sum((f / units) ** 2, axis=0) * own for f in forces])
    share = size.sum(axis=0) / max(size.sum(), 1e-300)
    out = []
    for d in told:
        wholly = d.variable == "time_s" and share[d.channel] >= LEAST_CHANNEL
        order = np.argsort(-size[:, d.channel])[: max(3, len(series) // MANY)]
        trials = tuple(series[int(t)].name for t in order)
        out.append(
            Dependence(
                d.channel, d.variable, float(share[d.channel]), trials, float(share[d.channel])
            )
            if wholly
            else replace(d, adds=0.0)
        )
    return sorted(out, key=lambda d: -d.share)


def only_of_time(free: Sequence[Free]) -> bool:
    """Whether what swings or pulses with the time is all that has no name in a model."""
    own = [f for f in free if is_nameless(f.name)]
    of_these = sum(int(own_numbers(own, name).sum()) for name in OF_TIME)
    return bool(own) and of_these == len(own)
