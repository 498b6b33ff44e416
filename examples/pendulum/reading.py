"""The pendulum's one long recording, whole and in stretches that serve as trials."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bluekoi.errors import input_error
from bluekoi.fitting import Noise, Series

ANGLE_STD, RATE_STD = 0.01, 0.01
FIRST_NOISE = Noise(np.array([0.0, 0.01, 0.01]), np.array([0.5, 0.3, 0.3]), np.ones(2))
"""No random moment: nothing pushes a pendulum in still air, and one that is allowed to takes the
friction's place. What errors last are the recording's."""
STRETCHES = 6


def read_folder(folder: Path) -> Series:
    """The recording; columns trial, time s, angle rad, rate rad/s.

    Raises: InputError where there is no such file.
    """
    paths = sorted(folder.glob("*.txt"))
    if not paths:
        raise input_error(folder, "", "no .txt", "the pendulum's recording")
    table = np.loadtxt(paths[0], comments="%")
    return series("whole", table[:, 1], table[:, 2:4])


def series(name: str, times: np.ndarray, seen: np.ndarray) -> Series:
    """A stretch of the recording as a trial of its own."""
    n = len(times)
    return Series(
        name=name, group="all", condition=name, times=np.ascontiguousarray(times - times[0]),
        inputs=np.zeros((n, 0)), constants=np.zeros(0), seen=np.ascontiguousarray(seen),
        noise=np.tile(np.diag([ANGLE_STD**2, RATE_STD**2]), (n, 1, 1)),
        mean=np.array([*seen[0], 0.0, 0.0, 0.0]),
        cov=np.diag([0.05, 0.05, 1e-6, 1e-6, 1e-6]) ** 2,
    )  # fmt: skip


def stretches(whole: Series, count: int = STRETCHES) -> tuple[Series, ...]:
    """The recording cut into `count` trials of equal length."""
    parts = np.array_split(np.arange(len(whole.times)), count)
    return tuple(series(f"stretch {i + 1}", whole.times[p], whole.seen[p])
                 for i, p in enumerate(parts))  # fmt: skip
