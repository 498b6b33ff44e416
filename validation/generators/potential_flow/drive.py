"""What the motors do in time: flapping frequency, phase of the beat, and head angle."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from .form import HiddenForm
from .lanes import ParallelTrials

FREQUENCY_DRIFT_STD = 0.004
"""Relative standard deviation of the frequency's wander within a trial."""
FREQUENCY_DRIFT_TIME_S = 0.4
"""Correlation time of the wander, s."""


@dataclass(frozen=True)
class DriveHistory:
    """Frequency (Hz), phase of the beat (rad) and head angle (rad), each (times, n)."""

    flap: np.ndarray
    phase: np.ndarray
    angle: np.ndarray


def draw_frequency_drift(rng: np.random.Generator, times: np.ndarray, trials: int) -> np.ndarray:
    """(times, trials) relative frequency: an Ornstein-Uhlenbeck process, exact at the steps."""
    keep = np.exp(-(times[1] - times[0]) / FREQUENCY_DRIFT_TIME_S)
    out = rng.normal(size=(len(times), trials))
    for i in range(1, len(times)):
        out[i] = keep * out[i - 1] + np.sqrt(1 - keep**2) * out[i]
    return FREQUENCY_DRIFT_STD * out


def drive_history(
    lanes: ParallelTrials, laws: list[HiddenForm], wander: np.ndarray, times: np.ndarray
) -> DriveHistory:
    """Drive at even `times`, which begin at half a step; phase 0 at time 0."""
    step = times[1] - times[0]
    s = SimpleNamespace(t=times[:, None], power=lanes.power, command=lanes.command)
    flap = lanes.flap * (1 + wander[: len(times), lanes.trial])
    angle = np.broadcast_to(lanes.command, flap.shape)
    for i, law in enumerate(laws):
        if law.form.stage == "motor":
            flap = flap * law(s, lanes.strengths[i])
        elif law.form.stage == "servo":
            angle = angle + law(s, lanes.strengths[i]) - lanes.command
    angle = angle + lanes.servo
    phase = 2 * np.pi * step * (np.cumsum(flap, axis=0) - flap / 2)
    return DriveHistory(flap, phase, angle)
