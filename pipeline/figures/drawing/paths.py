"""Distances between measured and simulated paths."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...data import Float, Track

JOINT, PAPER, EXTENDED = "joint", "paper", "extended"
"""Prefixes of the model paths in simulations/ID.csv."""


def path_rmse_m(track: Track, columns: Mapping[str, Float], prefix: str) -> float:
    """Root mean square distance of a simulated path to the track, both at the track's times, m."""
    t, times = track.time_s, columns["time_s"]
    x = np.interp(t, times, columns[f"{prefix}_x_m"], left=np.nan, right=np.nan)
    y = np.interp(t, times, columns[f"{prefix}_y_m"], left=np.nan, right=np.nan)
    return float(np.sqrt(np.nanmean((x - track.x_m) ** 2 + (y - track.y_m) ** 2)))
