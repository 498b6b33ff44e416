"""Sums of products of weighted errors and differences, trial by trial."""

from __future__ import annotations

import numpy as np

from ..data import Float
from ..numba_settings import njit

OBSERVATIONS_PER_CHUNK = 64
"""Observations gathered before their products are summed: sums along rows become vectors."""


FASTMATH_FLAGS = {"nsz", "contract", "reassoc"}


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH_FLAGS)
def _add_column_products(columns: Float, count: int, sums: Float) -> None:
    """Add products of the first `count` numbers of all columns to the lower half of `sums`."""
    for j in range(sums.shape[0]):
        for k in range(j + 1):
            total = 0.0
            for p in range(count):
                total += (
                    columns[j * OBSERVATIONS_PER_CHUNK + p]
                    * columns[k * OBSERVATIONS_PER_CHUNK + p]
                )
            sums[j, k] += total


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH_FLAGS)
def compute_column_products(
    observed: Float, seen: Float, weight: Float, trials: tuple[int, int], out: Float
) -> None:
    """Set `out` (trials, used, used) to the products of columns of the trials first to last.

    Column 0 holds (seen - simulated) w, column j what lane j differs from lane 0 by, times w.
    observed (trials, frames, observations, 16); seen, weight (trials, frames, observations),
    weight 0 where nothing was seen.
    """
    used, observations = out.shape[1], seen.shape[2]
    columns = np.zeros(used * OBSERVATIONS_PER_CHUNK)
    for t in range(trials[0], trials[1]):
        count = 0
        for j in range(used):
            for k in range(used):
                out[t, j, k] = 0.0
        for row in range(seen.shape[1] * observations):
            i, o = row // observations, row % observations
            w, base = weight[t, i, o], observed[t, i, o, 0]
            if w != 0.0:
                columns[count] = (seen[t, i, o] - base) * w
                for j in range(1, used):
                    columns[j * OBSERVATIONS_PER_CHUNK + count] = (observed[t, i, o, j] - base) * w
                count += 1
            if count == OBSERVATIONS_PER_CHUNK:
                _add_column_products(columns, count, out[t])
                count = 0
        _add_column_products(columns, count, out[t])
        for j in range(used):
            for k in range(j):
                out[t, k, j] = out[t, j, k]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH_FLAGS)
def add_whitened_column_products(  # noqa: PLR0917
    observed: Float, seen: Float, roots: Float, frames: np.ndarray, first: np.ndarray,
    places: np.ndarray, counts: np.ndarray, trials: tuple[int, int], out: Float,
) -> None:  # fmt: skip
    """Add to `out` (trials, p, p) the products of columns of the trials first to last.

    Column 0 holds R (seen - predicted), column j what its lane differs from lane 0 by, times R, of
    each frame's root R; column j stands at `places` (trials, p) of `out`, `counts` (trials,) of
    them. Of trial t are the blocks `first[t]` to `first[t + 1]` of observed (blocks, frames,
    observations, 16), 15 columns each. seen (trials, frames, observations); roots (trials, frames,
    observations, observations), lower triangles, rows of 0 where nothing was seen.
    """
    most, size = places.shape[1], seen.shape[2]
    columns, sums = np.zeros(most * OBSERVATIONS_PER_CHUNK), np.zeros((most, most))
    for t in range(trials[0], trials[1]):
        used, count = counts[t], 0
        own = observed[first[t] : first[t + 1]]
        for j in range(most):
            for k in range(most):
                sums[j, k] = 0.0
        for row in range(frames[t] * size):
            i, o = row // size, row % size
            if roots[t, i, o, o] != 0.0:
                _write_whitened_row(
                    columns, count, used, own[:, i], seen[t, i], roots[t, i, o, : o + 1]
                )
                count += 1
            if count == OBSERVATIONS_PER_CHUNK:
                _add_column_products(columns, count, sums[:used])
                count = 0
        _add_column_products(columns, count, sums[:used])
        for j in range(used):
            for k in range(j + 1):
                a, b = places[t, j], places[t, k]
                out[t, a, b] = out[t, b, a] = sums[j, k]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH_FLAGS)
def _write_whitened_row(  # noqa: PLR0917
    columns: Float, count: int, used: int, observed: Float, seen: Float, root: Float
) -> None:
    """Row `count` of all columns: one row of a root times errors and differences of a frame."""
    for j in range(used):
        total = 0.0
        for q in range(len(root)):
            if j == 0:
                total += root[q] * (seen[q] - observed[0, q, 0])
            else:
                block = observed[(j - 1) // 15, q]
                total += root[q] * (block[(j - 1) % 15 + 1] - block[0])
        columns[j * OBSERVATIONS_PER_CHUNK + count] = total
