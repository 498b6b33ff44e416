"""What is measured of a coordinate or of both, cleaned of gross errors, with its usual sizes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data import BoolNDArray, Float
from .grid import FilterTimeGrid


@dataclass(frozen=True)
class ScreenedMeasurements:
    """Measurements z (nodes, m) with variance R (nodes, m, m) where seen (nodes,).

    plausible: (nodes,) those not far off the line between their neighbours. onset: (nodes,)
    start-up window. speed: usual rate of change of z. variance: usual one of R. span_s: time from
    the first frame to the last.
    """

    z: Float
    R: Float
    seen: BoolNDArray
    plausible: BoolNDArray
    onset: Float
    speed: float
    variance: float
    span_s: float


def screen_measurements(z: Float, R: Float, grid: FilterTimeGrid) -> ScreenedMeasurements:
    """Measurements of z (nodes, m) with covariance R (nodes, m, m), NaN where not seen."""
    seen = np.asarray(np.isfinite(z).all(axis=1) & np.isfinite(R).all(axis=(1, 2)))
    m = z.shape[1]
    R = np.where(seen[:, None, None], R, np.eye(m))
    z = np.where(seen[:, None], z, 0.0)
    plausible = seen.copy()
    plausible[seen] = _agrees_with_neighbours(z[seen])
    t, at = grid.time_s[plausible], z[plausible]
    variance = float(np.median(np.trace(R[plausible].T))) / m
    # over whole beats, in which the recoil is back where it was
    beats = round(grid.scale_s / float(np.median(np.diff(t))))
    lag = max(min(beats, len(t) // 3), 1)
    rates = np.abs(at[lag:] - at[:-lag]).max(axis=1) / (t[lag:] - t[:-lag])
    floor = np.sqrt(variance) / max(float(np.ptp(t)), 1e-9)
    speed = float(max(np.quantile(rates, 0.8), floor))
    span = float(np.ptp(grid.time_s))
    return ScreenedMeasurements(
        z, R, seen, plausible, _onset_window(grid, t, at), speed, variance, span
    )


def _agrees_with_neighbours(z: Float) -> BoolNDArray:
    """Points (n,) within 8 robust deviations of what their neighbours say.

    Neighbours say the median of (z[k-j] + z[k+j]) / 2, j = 1, 2, 3, and at the ends that of the
    lines 2 z[k+j] - z[k+2j]. Only gross errors: recoil and start pass.
    """
    n = len(z)
    k, j = np.arange(n), np.array([1, 2, 3])[:, None]
    inside = (k - 3 >= 0) & (k + 3 < n)
    ahead = np.where(k < n / 2, 1, -1)
    near, far = np.clip(k + ahead * j, 0, n - 1), np.clip(k + 2 * ahead * j, 0, n - 1)
    between = 0.5 * (z[np.clip(k - j, 0, n - 1)] + z[np.clip(k + j, 0, n - 1)])
    interpolated = np.where(inside[:, None], between, 2 * z[near] - z[far])
    away = np.abs(z - np.median(interpolated, axis=0))
    scale = 1.4826 * np.median(away, axis=0)
    return np.asarray((away <= 8 * np.maximum(scale, 1e-12)).all(axis=1))


def _onset_window(grid: FilterTimeGrid, time_s: Float, z: Float) -> Float:
    """Window exp(-|t - t_start| / T) around the onset of the motion, (nodes,).

    Onset: where the path leaves its first place by a fiftieth of its extent.
    """
    away = np.linalg.norm(z - np.median(z[:5], axis=0), axis=1)
    moved = away > 0.02 * max(float(np.quantile(away, 0.95)), 1e-300)
    coloured = np.minimum.accumulate(moved[::-1])[::-1]
    onset = time_s[int(np.argmax(coloured))] if coloured.any() else time_s[0]
    return np.asarray(
        np.exp(-np.abs(grid.time_s - max(onset - grid.scale_s, time_s[0])) / grid.scale_s)
    )
