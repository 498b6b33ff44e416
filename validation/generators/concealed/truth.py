"""The true path of a trial."""

from typing import Any

import numpy as np

from validation.generators.concealed.strength import KEEP, STEP_S
from validation.generators.concealed.trials import SimulatedTrial

__all__ = ["path_truth"]

PATH_INTERVAL_S = STEP_S * KEEP


def path_truth(one: SimulatedTrial) -> dict[str, Any]:
    """Command and mean motion of a trial: rows x, y (m), heading (rad), u, v (m/s), r (rad/s),
    every 1/15 s from release.
    """
    at_s = np.arange(0.0, max(float(one.trial.time_s[-1]), 10 * PATH_INTERVAL_S), PATH_INTERVAL_S)
    mean = one.trial.motion.state_without_recoil(at_s)
    own = (mean[:, 3] + 1j * mean[:, 4]) * np.exp(-1j * mean[:, 2])
    rows = np.column_stack([mean[:, :3], own.real, own.imag, mean[:, 5]])
    return {"command": one.command._asdict(), "mean": np.round(rows, 6)}
