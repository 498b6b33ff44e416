"""Time series of every trial for the trial explorer of the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..campaign import Campaign
from ..data import Float
from .packing import gzip_base64_json, quantised_differences

MAX_POINTS_PER_TRIAL = 2000
"""Longer trials are thinned to this many points."""
COLUMN_RESOLUTION = {
    "time_s": 1e-4, "x_m": 1e-4, "y_m": 1e-4, "speed_m_s": 1e-4, "speed_m_s_std": 1e-5,
    "heading_rad": 1e-3, "head_angle_rad": 1e-4, "yaw_rate_rad_s": 1e-4,
    "yaw_rate_rad_s_std": 1e-4,
}  # fmt: skip
"""Columns shown, and the resolution to which they are stored (far below their uncertainty)."""
SIMULATION_COLUMN_PREFIXES = {"before": "joint", "after": "extended"}
"""Model -> beginning of the names of its columns in the explorer's data."""


def compressed_trial_time_series(campaign: Campaign, trial_id: str) -> str:
    """Packed columns of a trial: measured, and each model's path, heading and rates.

    Empty for a trial without a track.
    """
    track = campaign.tracks.get(trial_id)
    if track is None:
        return ""
    count = len(track.time_s)
    kept = np.unique(
        np.linspace(0, count - 1, min(count, MAX_POINTS_PER_TRIAL)).round().astype(int)
    )
    columns = {name: np.asarray(getattr(track, name))[kept] for name in COLUMN_RESOLUTION}
    given = campaign.model_columns(trial_id)
    models = {
        name: _simulated_path_at_times(given, prefix, track.time_s[kept])
        for name, prefix in SIMULATION_COLUMN_PREFIXES.items()
        if f"{prefix}_x_m" in given
    }
    return gzip_base64_json({
        "measured": _quantised_columns(columns),
        **{name: _quantised_columns(found) for name, found in models.items()},
    })  # fmt: skip


def _simulated_path_at_times(
    columns: Mapping[str, Float], prefix: str, at: Float
) -> dict[str, Float]:
    """Path, heading and their rates of a simulated path at times `at`; NaN outside it."""
    times = columns["time_s"]
    names = [name for name in ("x_m", "y_m", "heading_rad") if f"{prefix}_{name}" in columns]
    path = {name: columns[f"{prefix}_{name}"] for name in names}
    if len(times) > 1:
        path["speed_m_s"] = np.hypot(
            np.gradient(path["x_m"], times), np.gradient(path["y_m"], times)
        )
        if "heading_rad" in path:
            path["yaw_rate_rad_s"] = np.gradient(np.unwrap(path["heading_rad"]), times)
    return {name: np.interp(at, times, v, np.nan, np.nan) for name, v in path.items()}


def _quantised_columns(columns: Mapping[str, Float]) -> dict[str, Any]:
    limited = {name: np.where(np.abs(v) < 1e6, v, np.nan) for name, v in columns.items()}
    return {
        name: quantised_differences(values, COLUMN_RESOLUTION[name])
        for name, values in limited.items()
    }
