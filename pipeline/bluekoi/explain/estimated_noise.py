"""Errors of the observations and random forces as they were estimated with the named causes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .cause_search import CauseSearchResult
from .preparation import stated_std

NOISE_TABLE_HEAD = (
    "errors and random forces", "stated", "independent", "autocorrelated", "correlation time, s",
)  # fmt: skip


@dataclass(frozen=True)
class ObservationErrors:
    """Standard deviations of the errors of an observation, in its unit: stated, independent from
    sample to sample, and autocorrelated, with their correlation time.
    """

    name: str
    unit: str
    stated_std: float
    independent_std: float
    autocorrelated_std: float
    correlation_time_s: float


@dataclass(frozen=True)
class RandomForce:
    """Standard deviation of the random force on a channel, in the unit of the model's force, and
    its correlation time.
    """

    channel: str
    std: float
    correlation_time_s: float


def estimated_errors(found: CauseSearchResult) -> list[ObservationErrors]:
    """Errors of each observation."""
    noise, observations = found.best.model.noise, found.model.observations
    count = len(observations)
    stated = stated_std(found.prepared.series)
    times = np.broadcast_to(noise.tau, noise.disturbance.shape)
    rows = np.column_stack(
        [stated, noise.scale * stated, noise.disturbance[-count:], times[-count:]]
    )
    return [
        ObservationErrors(o.name, o.unit, *map(float, row))
        for o, row in zip(observations, rows, strict=True)
    ]


def estimated_random_forces(found: CauseSearchResult) -> list[RandomForce]:
    """Random force on each channel."""
    noise, channels = found.best.model.noise, found.model.channels
    times = np.broadcast_to(noise.tau, noise.disturbance.shape)
    return [RandomForce(name, float(noise.disturbance[k]), float(times[k]))
            for k, name in enumerate(channels)]  # fmt: skip


def noise_rows(found: CauseSearchResult) -> list[tuple[str, ...]]:
    """Rows of `NOISE_TABLE_HEAD`: observations, then channels."""
    errors = [
        (f"errors of {e.name}, {e.unit}", f"{e.stated_std:.3g}", f"{e.independent_std:.3g}",
         f"{e.autocorrelated_std:.3g}", f"{e.correlation_time_s:.3g}")
        for e in estimated_errors(found)
    ]  # fmt: skip
    forces = [
        (f"random force on {f.channel}", "", "", f"{f.std:.3g}", f"{f.correlation_time_s:.3g}")
        for f in estimated_random_forces(found)
    ]
    return [*errors, *forces]
