"""Sums of products of weighted errors and differences, trial by trial."""

from __future__ import annotations

import numpy as np
from numba import njit

from ..data import Float

CHUNK = 64
"""Observations gathered before their products are summed: sums along rows become vectors."""


FAST = {"nsz", "contract", "reassoc"}


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _add(columns: Float, count: int, sums: Float) -> None:
    """Add products of the first `count` numbers of all columns to the lower half of `sums`."""
    for j in range(sums.shape[0]):
        for k in range(j + 1):
            total = 0.0
            for p in range(count):
                total += columns[j * CHUNK + p] * columns[k * CHUNK + p]
            sums[j, k] += total


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def set_products(
    observed: Float, seen: Float, weight: Float, trials: tuple[int, int], out: Float
) -> None:
    """Set `out` (trials, used, used) to the products of columns of the trials first to last.

    Column 0 holds (seen - simulated) w, column j what lane j differs from lane 0 by, times w.
    observed (trials, frames, observations, 16); seen, weight (trials, frames, observations),
    weight 0 where nothing was seen.
    """
    used, observations = out.shape[1], seen.shape[2]
    columns = np.zeros(used * CHUNK)
    for t in range(trials[0], trials[1]):
        out[t], count = 0.0, 0
        for row in range(seen.shape[1] * observations):
            i, o = row // observations, row % observations
            w, base = weight[t, i, o], observed[t, i, o, 0]
            if w != 0.0:
                columns[count] = (seen[t, i, o] - base) * w
                for j in range(1, used):
                    columns[j * CHUNK + count] = (observed[t, i, o, j] - base) * w
                count += 1
            if count == CHUNK:
                _add(columns, count, out[t])
                count = 0
        _add(columns, count, out[t])
        for j in range(used):
            out[t, :j, j] = out[t, j, :j]
