"""Distances between measured and simulated paths."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...data import Float, Track

JOINT, PAPER, EXTENDED = "joint", "paper", "extended"
"""Prefixes of the model paths in simulations/ID.csv."""
LEAST_SHARE = 0.8


def path_rmse_m(track: Track, columns: Mapping[str, Float], prefix: str) -> float:
    """Root mean square distance of a simulated path to the track, at the track's times, m.

    NaN where the path ends early (a simulation that ran away).
    """
    t, times = track.time_s, columns["time_s"]
    x = np.interp(t, times, columns[f"{prefix}_x_m"], left=np.nan, right=np.nan)
    y = np.interp(t, times, columns[f"{prefix}_y_m"], left=np.nan, right=np.nan)
    square = (x - track.x_m) ** 2 + (y - track.y_m) ** 2
    known = np.isfinite(square)
    return float(np.sqrt(square[known].mean())) if known.mean() > LEAST_SHARE else float("nan")
