"""Rigid distances averaged over windows of half a second."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ..data import Float
from .rigid_distances import RigidDistances

LENGTH_WINDOW_S = 0.5
"""Duration in which a robot moves by a fifth of a metre and turns by less than a radian."""
MAX_LENGTH_WINDOWS = 6000
STORED_DECIMALS = 7  # a tenth of a micrometre


def window_means(distances: RigidDistances) -> RigidDistances:
    """Means of distances over windows of one pair in one trial; std_m (n,): of each mean, frames
    taken as independent.
    """
    step = LENGTH_WINDOW_S
    keys = _window_of_each_distance(distances, step)
    while len(np.unique(keys, axis=0)) > MAX_LENGTH_WINDOWS:
        step *= 2.0
        keys = _window_of_each_distance(distances, step)
    _, place = np.unique(keys, axis=0, return_inverse=True)
    count = np.bincount(place).astype(float)

    def mean(values: Float) -> Float:
        if values.ndim == 2:
            return np.column_stack([mean(column) for column in values.T])
        return np.asarray(np.bincount(place, weights=values) / count)

    means = {f.name: mean(getattr(distances, f.name)) for f in fields(RigidDistances)}
    variance = np.bincount(place, weights=distances.std_m**2) / count
    return RigidDistances(**{**means, "std_m": np.sqrt(variance / count)})


def _window_of_each_distance(distances: RigidDistances, step_s: float) -> Float:
    """Trial, pair and window (n, 3) of each distance."""
    return np.column_stack(
        [distances.trial, distances.pair, np.floor(distances.time_s / step_s)]
    ).round()


def windows_to_columns(windows: RigidDistances) -> dict[str, Any]:
    """Windows as columns of a json object."""
    return {
        f.name: np.round(getattr(windows, f.name), STORED_DECIMALS) for f in fields(RigidDistances)
    }


def windows_without_trials(windows: RigidDistances, left_out: Collection[int]) -> RigidDistances:
    """Windows without those of the trials with these numbers."""
    return windows.select(~np.isin(windows.trial.round(), list(left_out)))


def windows_from_columns(columns: Mapping[str, Any]) -> RigidDistances:
    """Windows from the columns of a json object."""
    return RigidDistances(**{f.name: np.array(columns[f.name], dtype=np.float64)
                             for f in fields(RigidDistances)})  # fmt: skip
