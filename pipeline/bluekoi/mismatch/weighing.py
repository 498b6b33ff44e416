"""Weights: how the chosen cause and its rivals share a place, and what is left for none of them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

HALF_SURE, STEEP = 6.0, 1.2
"""Softmax among the candidates knows of no law that is not among them: with it alone all weights
were 1. In 96 concealed studies (seeds 11, 31, 1001 and 1002) 121 of 127 causes were true: 94 of 94
that gained 80 or more over the inflation, 13 of 14 from 40 on, 9 of 11 from 20 on, 5 of 8 below.
These two numbers are the logistic regression on the logarithm of that gain.
"""
CANDIDATES = 30
"""Causes tried beside the right one, about as many as there are files of them."""

SELDOM = 2.0
"""By this much log likelihood (over the inflation) a force without a name must be ahead of a named
cause to be as likely: laws outside the list are seldom, and some nameless terms are nearly a
candidate's own law.
"""


def reliability(gain: float) -> float:
    """Probability that a cause does not stand in for something that is no candidate, (0, 1).

    g^b / (g^b + g_0^b), with g its held-out gain in log likelihood over the inflation.
    """
    return 1.0 / (1.0 + (HALF_SURE / max(1e-9, gain)) ** STEEP)


def told_aside(gain: float) -> float:
    """Probability of a cause by what it gains (log likelihood) on side measurements alone, against
    chance in one of `CANDIDATES`: misfit of the paths has no part in it.
    """
    return 1.0 / (1.0 + CANDIDATES * np.exp(-max(gain, 0.0)))


def weights(totals: Mapping[str, float], inflation: float) -> dict[str, float]:
    """Weights that sum to 1 from held-out log likelihoods over an inflation."""
    best = max(totals.values())
    raw = {name: float(np.exp((total - best) / inflation)) for name, total in totals.items()}
    whole = sum(raw.values())
    return {name: value / whole for name, value in raw.items()}


def beside_nameless(shares: Mapping[str, float], name: str, ahead: float) -> dict[str, float]:
    """Shares of a place with one for a force without a name, `unexplained`.

    ahead: by how much the best nameless term does better than the cause `name` there, in held-out
    log likelihood over the inflation; -inf where none was tried.
    """
    own = shares[name] * float(np.exp(min(ahead - SELDOM, 50.0)))
    return {n: s / (1.0 + own) for n, s in shares.items()} | {"unexplained": own / (1.0 + own)}
