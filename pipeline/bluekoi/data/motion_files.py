"""Readers and writers of poses/ID.csv and tracks/ID.csv."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from .csv_columns import read_columns, write_columns
from .types import Float, Pose, Track

TRACK_COLUMNS = tuple(
    f.name for f in fields(Track) if f.name not in ("recoil", "recoil_std", "remarks")
)
"""Columns of tracks/ID.csv."""
RECOIL_COLUMNS = ("recoil_x_m", "recoil_y_m", "recoil_heading_rad")
"""Further columns; those of the standard deviations end in `_std`."""


def write_track(path: str | Path, track: Track) -> None:
    """Write tracks/ID.csv as the contract lists it, with the recoil as extra columns."""
    columns = {name: getattr(track, name) for name in TRACK_COLUMNS}
    recoil = dict(zip(RECOIL_COLUMNS, track.recoil.T, strict=True))
    recoil_std = {
        f"{k}_std": std for k, std in zip(RECOIL_COLUMNS, track.recoil_std.T, strict=True)
    }
    write_columns(path, columns | recoil | recoil_std)


def read_track(path: str | Path) -> Track:
    """Track of one trial from tracks/ID.csv.

    Raises: InputError where a column is missing or a value is not a number.

        >>> track = read_track("results/lab/tracks/T09.csv")
        >>> float(track.speed_m_s[-1])
        0.5
    """
    columns = read_columns(path, TRACK_COLUMNS)
    values: dict[str, Any] = {name: columns[name] for name in TRACK_COLUMNS}
    recoil, recoil_std = (
        _stack_columns_if_all_present(columns, [f"{name}{end}" for name in RECOIL_COLUMNS])
        for end in ("", "_std")
    )
    return Track(**values, recoil=recoil, recoil_std=recoil_std)


def _stack_columns_if_all_present(columns: Mapping[str, Float], names: Sequence[str]) -> Float:
    """Columns side by side (frames, names); (0, names) where one is missing."""
    if not set(names) <= columns.keys():
        return np.zeros((0, len(names)))
    return np.column_stack([columns[name] for name in names])


_POSE_COVARIANCE_INDICES = [(i, j) for i in range(4) for j in range(i, 4)]
POSE_COLUMNS = (
    "time_s",
    "x_m",
    "y_m",
    "heading_rad",
    "head_angle_rad",
    *(f"cov_{i}{j}" for i, j in _POSE_COVARIANCE_INDICES),
)
"""Columns of poses/ID.csv."""


def write_pose(path: str | Path, pose: Pose) -> None:
    """Write poses/ID.csv: measured pose and the upper triangle of its covariance."""
    columns = {"time_s": pose.time_s} | dict(zip(POSE_COLUMNS[1:5], pose.values.T, strict=True))
    write_columns(
        path, columns | {f"cov_{i}{j}": pose.cov[:, i, j] for i, j in _POSE_COVARIANCE_INDICES}
    )


def read_pose(path: str | Path) -> Pose:
    """Pose of one trial from poses/ID.csv."""
    columns = read_columns(path, POSE_COLUMNS)
    cov = np.empty((len(columns["time_s"]), 4, 4))
    for i, j in _POSE_COVARIANCE_INDICES:
        cov[:, i, j] = cov[:, j, i] = columns[f"cov_{i}{j}"]
    return Pose(columns["time_s"], np.column_stack([columns[c] for c in POSE_COLUMNS[1:5]]), cov)
