"""A trial in which everything seen drifts: a camera that turns slowly, a stabilised video.

The drift grows evenly from the trial's start to its size at the end. As in `camera_displacement`,
lambda = (J'e)' (J'J)^-1 (J'e) with e the filter's whitened prediction errors and J = de / d(size).
Missing physics imitates a drift, in all trials of its kind alike. A trial is named whose lambda
stands out from the others'.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Noise, Series, filter_all
from ..integrate import Kernel
from .camera_displacement import PRIOR, STEP_M, TAIL_FACTOR

MIN_FRAMES = 8
MIN_RATIO = 5.0
"""Lambda over the next largest. Of 75 simulated studies with missing physics and no drift one has a
larger ratio; a drift of 8.5 cm in one of 24 trials gave 11 to 170 in 15 cases, 3.6 in one (along
the slowest straight path).
"""


@dataclass(frozen=True)
class Drift:
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


def drifting_trial(
    kernel: Kernel, series: Sequence[Series], values: Sequence[Float], noise: Noise
) -> Drift | None:
    """The trial that drifts where the others do not; None for fewer than three trials.

    values: full parameter vectors, one a trial.
    """
    long = [k for k, one in enumerate(series) if len(one.times) >= MIN_FRAMES]
    own = [values[k] for k in long]

    def errors(step: tuple[float, float]) -> list[Float]:
        shown = [_drifting(series[k], np.array(step)) for k in long]
        return [f.innovations.ravel() for f in filter_all(kernel, shown, own, noise)]

    each = zip(errors((0, 0)), errors((STEP_M, 0)), errors((0, STEP_M)), strict=True)
    found = [_drift(series[k].name, e, np.column_stack([x - e, y - e]) / STEP_M)
             for k, (e, x, y) in zip(long, each, strict=True)]  # fmt: skip
    ordered = sorted(found, key=lambda d: -d.likelihood_ratio)
    if len(ordered) < 3:
        return None
    first, second = ordered[:2]
    least = 2.0 * (TAIL_FACTOR * np.log(len(ordered)) - np.log(PRIOR))
    stands_out = first.likelihood_ratio > max(least, MIN_RATIO * second.likelihood_ratio)
    return first if stands_out else None


def _drifting(one: Series, size_m: Float) -> Series:
    since = one.times - one.times[0]
    seen = one.seen.copy()
    seen[:, :2] += np.outer(since / since[-1], size_m)
    return replace(one, seen=seen)


def _drift(trial: str, e: Float, J: Float) -> Drift:
    cov = np.linalg.inv(J.T @ J + 1e-9 * np.eye(2))
    size = cov @ (J.T @ e)
    return Drift(trial, size, np.sqrt(np.diag(cov)), float(size @ (J.T @ e)))
