"""The pendulum's recording: columns trial, time s, angle rad, rate rad/s."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bluekoi.errors import input_error
from bluekoi.explain import Trial


def read_folder(folder: Path) -> list[Trial]:
    """The recording of a folder.

    Raises: InputError where there is none.
    """
    paths = sorted(folder.glob("*.txt"))
    if not paths:
        raise input_error(folder, "", "no .txt", "the pendulum's recording")
    times, angle, rate = np.loadtxt(paths[0], comments="%")[:, 1:4].T
    return [Trial("whole", times - times[0], {"angle": angle, "rate": rate}, source=str(paths[0]))]
