"""Keypoint files read whole: every part of every individual."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bluekoi.data import Keypoints
from bluekoi.keypoints.deeplabcut import read_table


def read_all_parts(path: Path, fps: float) -> Keypoints:
    """Every part that a keypoint file holds, named `part` or `individual/part`; no covariances."""
    table = read_table(path)
    names = tuple(f"{who}/{part}" if who else part for who, part in table.columns)
    cov = np.full((*table.xy_px.shape, 2), np.nan)
    return Keypoints(table.frame / fps, names, table.xy_px, table.likelihood, cov, table.remarks)
