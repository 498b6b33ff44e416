"""Fewer, better observations: frames averaged in blocks, so that fits need not pass all of them.

A block's observation is the mean of its frames' distances from a local parabola, put back on the
parabola at the block's middle: curvature does not bias it. Random forces and lasting errors are
slower than a block, so that hardly anything is lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Float
from .series import Series

RATE_HZ = 10.0
HALF_WINDOW_S = 0.15


def thinned(series: Series, rate_hz: float = RATE_HZ, *, constant: Sequence[int] = ()) -> Series:
    """`series` at about `rate_hz`, its first frame kept as it is.

    constant: observations whose stated variance is one of the whole trial, spread over its frames
    (see `trial_series`); it is spread over the blocks instead.
    """
    step = float(np.median(np.diff(series.times)))
    size = round(1.0 / (rate_hz * step))
    if size < 2 or len(series.times) < 4 * size:
        return series
    blocks = [np.array([0]), *np.split(np.arange(1, len(series.times)),
                                       np.arange(size, len(series.times) - 1, size))]  # fmt: skip
    known = np.all(np.isfinite(series.seen), axis=1)
    rows = [_block(series, block, known) for block in blocks]
    noise = np.array([row[2] for row in rows])
    share = len(rows) / len(series.times)
    for o in constant:
        first = noise[0, o, o]
        noise[:, o, o] = first * share
    return replace(
        series,
        times=np.array([row[0] for row in rows]),
        seen=np.array([row[1] for row in rows]),
        noise=noise,
        inputs=np.array([series.inputs[b].mean(axis=0) for b in blocks]),
    )


def _block(series: Series, block: np.ndarray, known: np.ndarray) -> tuple[float, Float, Float]:
    """Time, observation (observations,) and covariance of one block; NaN where none is seen."""
    own = block[known[block]]
    width = series.seen.shape[1]
    if len(own) == 0:
        return float(series.times[block].mean()), np.full(width, np.nan), np.eye(width)
    if len(own) == 1:
        return float(series.times[own[0]]), series.seen[own[0]], series.noise[own[0]]
    time = float(series.times[own].mean())
    spread = series.times[own] - time
    mean = series.seen[own].mean(axis=0)
    bend = _bend(series, time, known)
    return (
        time,
        mean - 0.5 * bend * float(np.mean(spread**2)),
        (series.noise[own].sum(axis=0) / len(own) ** 2),
    )


def _bend(series: Series, time: float, known: np.ndarray) -> Float:
    """Second derivative (observations,) of a parabola fitted about a time; 0 where too few."""
    near = known & (np.abs(series.times - time) <= HALF_WINDOW_S)
    if near.sum() < 5:
        return np.zeros(series.seen.shape[1])
    t = series.times[near] - time
    return 2.0 * np.polynomial.polynomial.polyfit(t, series.seen[near], 2)[2]
