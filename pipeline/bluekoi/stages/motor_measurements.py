"""Side measurements of spin-up and sag, by the motor logs and the tail beat in the video."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..data import FlappingFrequency
from ..fitting import TrialSeries
from .clock_measurement import within_between_group_variances

SPIN_UP_LOST_TIME_STD_S = (
    0.005  # ASSUME a motor counts as starting at once that loses a reading's time
)
NEGLIGIBLE_DRIFT_STD_PER_S = (
    0.0003  # ASSUME a supply counts as steady that loses 0.2 % of speed in 6 s
)
MOTOR_FORMULA_STD_SHARE = 0.2  # ASSUME a motor follows the formula of its spin-up or sag to 20 %


def with_spin_up_time_measurement(
    series: Sequence[TrialSeries], flapping: Mapping[str, FlappingFrequency], *, fitted: int
) -> list[TrialSeries]:
    """Series with what the motor logs say of the spin-up as evidence, one measurement shared by the
    `fitted` trials: the mean of the logs, as certain as they agree, and no better than the cause's
    formula describes a motor.
    """
    lost = np.array([flapping[s.name].lost_time_s for s in series])
    known = lost[np.isfinite(lost)]
    if not len(known):
        return list(series)
    mean, scatter = float(known.mean()), float(known.std())
    std = np.sqrt(
        SPIN_UP_LOST_TIME_STD_S**2 + (MOTOR_FORMULA_STD_SHARE * mean) ** 2 + scatter**2 / len(known)
    )
    shared = {"lost_time": (mean, float(std) * max(fitted, 1) ** 0.5)}
    return [replace(s, evidence=s.evidence | shared) for s in series]


def with_frequency_drift(
    series: Sequence[TrialSeries], flapping: Mapping[str, FlappingFrequency], *, fitted: int
) -> list[TrialSeries]:
    """Series with the drift of each trial's flapping frequency as evidence, by the motor log, or
    without one by the video.

    The deviations are those of the drift itself, of how trials of one power differ, and of the
    causes' formulas, which are as wrong in all `fitted` trials.
    """
    found = {s.name: flapping[s.name] for s in series
             if np.isfinite(flapping[s.name].drift_per_s)}  # fmt: skip
    if not found:
        return list(series)
    drift = np.array([f.drift_per_s for f in found.values()])
    own = np.nan_to_num([f.drift_std_per_s for f in found.values()])
    within, _ = within_between_group_variances(
        drift, own**2, [s.group for s in series if s.name in found]
    )
    formula = NEGLIGIBLE_DRIFT_STD_PER_S**2 + (MOTOR_FORMULA_STD_SHARE * drift) ** 2
    std = np.sqrt(own**2 + within + max(fitted, 1) * formula)
    name = {n: "frequency_drift" if f.source == "motor_log" else "tail_beat_drift"
            for n, f in found.items()}  # fmt: skip
    evidence = {n: {name[n]: (float(v), float(d))}
                for n, v, d in zip(found, drift, std, strict=True)}  # fmt: skip
    return [replace(s, evidence=s.evidence | evidence.get(s.name, {})) for s in series]
