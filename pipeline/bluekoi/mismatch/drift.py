"""A trial in which everything seen drifts: a camera that turns slowly, a stabilised video.

The drift grows evenly from the trial's start to its size at the end. As in `camera_displacement`,
lambda = (J'e)' (J'J)^-1 (J'e) with e the filter's whitened prediction errors and J = de / d(size).
Without a drift, lambda is chi-squared with two degrees of freedom, an exponential distribution,
times a factor that missing physics gives to all trials. The largest of n is tested against the
others by its share g of their sum (Fisher, Proc. R. Soc. A 125 (1929), 54):

    P(g > x) <= n (1 - x)^(n - 1)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Noise, TrialSeries, filter_all
from ..integrate import CompiledSystem
from .camera_displacement import (
    DERIVATIVE_STEP_M,
    DISPLACEMENT_PRIOR_PROBABILITY,
    NULL_DISTRIBUTION_TAIL_FACTOR,
)

FALSE_ALARM_PROBABILITY = 1e-4
"""Significance of Fisher's test. Physics is missing in more than one way, so that the rate is
higher than stated: `python -m validation drift` has it, 1 of 99 studies of nine generators."""
MIN_TRIALS = 3
"""Trials among which one can stand out."""


@dataclass(frozen=True)
class CameraDrift:
    """Displacement at the end of a trial (2,) m, with its standard deviation, and lambda."""

    trial: str
    size_m: Float
    std_m: Float
    likelihood_ratio: float

    @property
    def sentence(self) -> str:
        """A warning with the remedy."""
        size, std = (1e3 * float(np.linalg.norm(v)) for v in (self.size_m, self.std_m))
        return (
            f"Trial {self.trial}: against the model and the other trials, what is seen drifts by "
            f"{size:.0f} +- {std:.0f} mm during the trial. Did the camera turn slowly, is the "
            "video stabilised, did the keypoints drift, or did water flow in this trial alone? "
            "Compare a verdict without it."
        )


def trial_with_camera_drift(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise
) -> CameraDrift | None:
    """The trial that drifts where the others do not; None for fewer than three trials.

    values: full parameter vectors, one a trial.
    """
    if len(series) < MIN_TRIALS:
        return None
    found = drift_by_trial(kernel, series, values, noise)
    ratios = np.array([d.likelihood_ratio for d in found])
    least = 2.0 * (
        NULL_DISTRIBUTION_TAIL_FACTOR * np.log(len(found)) - np.log(DISPLACEMENT_PRIOR_PROBABILITY)
    )
    if ratios.max() > least and fisher_p_value(ratios) < FALSE_ALARM_PROBABILITY:
        return found[int(np.argmax(ratios))]
    return None


def drift_by_trial(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise
) -> list[CameraDrift]:
    """The likeliest drift of each trial."""

    def errors(step: tuple[float, float]) -> list[Float]:
        shown = [add_drift(one, np.array(step)) for one in series]
        return [f.innovations.ravel() for f in filter_all(kernel, shown, values, noise)]

    each = zip(
        series,
        errors((0, 0)),
        errors((DERIVATIVE_STEP_M, 0)),
        errors((0, DERIVATIVE_STEP_M)),
        strict=True,
    )
    return [
        _likeliest_drift(one.name, e, np.column_stack([x - e, y - e]) / DERIVATIVE_STEP_M)
        for one, e, x, y in each
    ]


def fisher_p_value(ratios: Float) -> float:
    """Probability of a largest ratio (n,) as large beside the others, by Fisher's test."""
    n, total = len(ratios), float(ratios.sum())
    share = float(ratios.max()) / total if total > 0 else 0.0
    return min(1.0, n * (1.0 - share) ** (n - 1))


def add_drift(one: TrialSeries, size_m: Float) -> TrialSeries:
    """A trial whose picture drifts evenly to a displacement (2,) m at its end."""
    since = one.times - one.times[0]
    seen = one.seen.copy()
    seen[:, :2] += np.outer(since / max(since[-1], 1e-9), size_m)
    return replace(one, seen=seen)


def _likeliest_drift(trial: str, e: Float, J: Float) -> CameraDrift:
    cov = np.linalg.inv(J.T @ J + 1e-9 * np.eye(2))
    size = cov @ (J.T @ e)
    return CameraDrift(trial, size, np.sqrt(np.diag(cov)), float(size @ (J.T @ e)))
