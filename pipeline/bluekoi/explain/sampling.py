"""Recordings at a lower rate, without bias of observations or of the impulse of inputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import solveh_banded

from ..data import Float
from ..fitting import TrialSeries

MIN_SAMPLES_PER_BLOCK = 5
"""Blocks of fewer samples are not averaged."""
MIN_BLOCKS_PER_TRIAL = 5
"""A trial that gives fewer blocks is not averaged."""
BLOCK_POLYNOMIAL_DEGREE = 2
"""Degree of the polynomial through the samples of a block."""


def block_averaging_rate_hz(times: Sequence[Float], rate_hz: float) -> float:
    """The rate, or infinity where some trial has fewer than five samples in a block of it."""
    sizes = [_samples_per_block(t, rate_hz) for t in times]
    enough = all(k >= MIN_SAMPLES_PER_BLOCK and len(t) // k >= MIN_BLOCKS_PER_TRIAL
                 for k, t in zip(sizes, times, strict=True))  # fmt: skip
    return rate_hz if enough else np.inf


def _samples_per_block(times: Float, rate_hz: float) -> int:
    step = float(np.median(np.diff(times)))
    return int(1.0 / (rate_hz * step) + 1e-6) if np.isfinite(rate_hz) else 1


def averaged_to_rate(series: TrialSeries, rate_hz: float, held: Sequence[bool]) -> TrialSeries:
    """A series at about `rate_hz`; itself where that is infinite.

    held (inputs,): whether an input keeps its value until the next sample.

    Observations become the value in the middle of each block of the parabola through its samples
    (Savitzky and Golay), so that curvature does not bias them. Inputs become the piecewise linear
    functions between the blocks that are closest to them (least squares): they keep the impulse
    about every block, which means over blocks do not.
    """
    step = float(np.median(np.diff(series.times)))
    size = _samples_per_block(series.times, rate_hz)
    if size < MIN_SAMPLES_PER_BLOCK:
        return series
    count = len(series.times) // size
    edge = series.times[0] + np.arange(count + 1) * size * step - 0.5 * step
    block = np.clip(np.searchsorted(edge, series.times, side="right") - 1, 0, count - 1)
    used = np.unique(block)
    parts = [np.flatnonzero(block == k) for k in used]
    times = np.array([series.times[p].mean() for p in parts])
    rows = [
        _observations_at_block_midpoint(series, p, t) for p, t in zip(parts, times, strict=True)
    ]
    seen = np.array([y for y, _ in rows])
    noise = np.array([r for _, r in rows])
    inputs = np.zeros((len(times), series.inputs.shape[1]))
    for k, holds in enumerate(held):  # a held value stands for the middle of its interval
        at = series.times + 0.5 * step * holds
        inputs[:, k] = piecewise_linear_fit(at, series.inputs[:, k : k + 1], times)[:, 0]
    return replace(series, times=times, seen=seen, noise=noise, inputs=inputs)


def _observations_at_block_midpoint(
    series: TrialSeries, part: np.ndarray, time: float
) -> tuple[Float, Float]:
    """Observations (o,) and their covariance (o, o) in the middle of a block."""
    count = series.seen.shape[1]
    seen, factor = np.full(count, np.nan), np.ones(count)
    width = max(float(np.ptp(series.times[part])), 1e-12)
    for o in range(count):
        known = part[np.isfinite(series.seen[part, o])]
        if len(known) >= MIN_SAMPLES_PER_BLOCK:
            design = np.vander(
                (series.times[known] - time) / width, BLOCK_POLYNOMIAL_DEGREE + 1, increasing=True
            )
            weights = np.linalg.pinv(design)[0]
            seen[o], factor[o] = weights @ series.seen[known, o], float(np.sqrt(weights @ weights))
        elif len(known) > len(part) // 2:
            seen[o] = series.seen[known[len(known) // 2], o]
    return seen, series.noise[part[0]] * np.outer(factor, factor)


def piecewise_linear_fit(times: Float, values: Float, nodes: Float) -> Float:
    """Values (nodes, columns) between which straight lines are closest to `values` (n, columns)."""
    left = np.clip(np.searchsorted(nodes, times, side="right") - 1, 0, len(nodes) - 2)
    right = np.clip((times - nodes[left]) / (nodes[left + 1] - nodes[left]), 0.0, 1.0)
    banded = np.zeros((2, len(nodes)))
    np.add.at(banded[1], left, (1 - right) ** 2)
    np.add.at(banded[1], left + 1, right**2)
    np.add.at(banded[0], left + 1, right * (1 - right))
    banded[1] += 1e-9 * max(banded[1].max(), 1.0)
    sides = np.zeros((len(nodes), values.shape[1]))
    np.add.at(sides, left, (1 - right)[:, None] * values)
    np.add.at(sides, left + 1, right[:, None] * values)
    return np.asarray(solveh_banded(banded, sides))
