"""Fewer, better observations: frames averaged in blocks, so that fits need not pass all of them.

A block's observation is the mean of its frames' distances from a local parabola, put back on the
parabola at the block's middle: curvature does not bias it. Blocks are equally long in time, so that
none reaches over frames that are absent. Random forces and lasting errors are
slower than a block, so that hardly anything is lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Float
from .series import TrialSeries

DEFAULT_BLOCK_RATE_HZ = 10.0
PARABOLA_HALF_WINDOW_S = 0.15
MIN_FRAMES_FOR_PARABOLA = 5


def block_averaged(
    series: TrialSeries,
    rate_hz: float = DEFAULT_BLOCK_RATE_HZ,
    *,
    constant: Sequence[int] = (),
    half_window_s: float = PARABOLA_HALF_WINDOW_S,
) -> TrialSeries:
    """`series` at about `rate_hz`, its first frame kept as it is.

    constant: observations whose stated variance is one of the whole trial, spread over its frames
    (see `trial_series`); it is spread over the blocks instead.
    """
    step = float(np.median(np.diff(series.times)))
    size = round(1.0 / (rate_hz * step))
    if size < 2 or len(series.times) < 4 * size:
        return series
    turn = np.floor((series.times - series.times[1]) / (size * step) + 1e-3)
    first = np.flatnonzero(np.diff(turn, prepend=-np.inf))
    lengths = np.diff([*first, len(series.times)])
    times, seen, noise = _block_means(series, first, lengths, half_window_s)
    share = len(first) / len(series.times)
    seen_first = int(np.argmax(np.all(np.isfinite(series.seen), axis=1)))
    for o in constant:
        noise[:, o, o] = series.noise[seen_first, o, o] * share
    inputs = np.add.reduceat(series.inputs, first) / lengths[:, None]
    return replace(series, times=times, seen=seen, noise=noise, inputs=inputs)


def _block_means(
    series: TrialSeries, first: np.ndarray, lengths: np.ndarray, half_window_s: float
) -> tuple[Float, Float, Float]:
    """Times (b,), observations (b, observations) and covariances of blocks that begin at the frames
    `first` (b,) and have so many; NaN where nothing is seen.
    """
    known = np.all(np.isfinite(series.seen), axis=1)
    counts = np.maximum(np.add.reduceat(known.astype(int), first), 1)
    some = np.logical_or.reduceat(known, first)

    def mean(rows: Float) -> Float:
        sums = np.zeros((len(first), *rows.shape[1:]))
        np.add.at(sums, np.repeat(np.arange(len(first)), lengths)[known], rows[known])
        return (sums.T / counts).T

    times = np.where(some, mean(series.times), np.add.reduceat(series.times, first) / lengths)
    off = series.times - np.repeat(times, lengths)
    seen = mean(series.seen) - 0.5 * mean(off**2)[:, None] * _second_derivatives(
        series, times, known, half_window_s
    )
    noise = (mean(series.noise).T / counts).T
    seen[~some], noise[~some] = np.nan, np.eye(series.seen.shape[1])
    return times, seen, noise


def _second_derivatives(
    series: TrialSeries, times: Float, known: np.ndarray, half_window_s: float
) -> Float:
    """Second derivatives (b, observations) of parabolas about times; 0 where frames are few."""
    begin, end = (np.searchsorted(series.times, times + k * half_window_s) for k in (-1, 1))
    frames = begin[:, None] + np.arange(max(1, int((end - begin).max())))
    near = np.minimum(frames, len(series.times) - 1)
    weight = (frames < end[:, None]) & known[near]
    t = np.where(weight, series.times[near] - times[:, None], 0.0) / half_window_s
    powers = t[:, :, None] ** np.arange(3) * weight[:, :, None]
    enough = weight.sum(axis=1) >= MIN_FRAMES_FOR_PARABOLA
    A = np.einsum("bwi,bwj->bij", powers, powers)
    A[~enough] = np.eye(3)
    sides = np.einsum("bwi,bwo->bio", powers, np.where(weight[:, :, None], series.seen[near], 0.0))
    bends = 2.0 * np.linalg.solve(A, sides)[:, 2] / half_window_s**2
    return np.where(enough[:, None], bends, 0.0)
