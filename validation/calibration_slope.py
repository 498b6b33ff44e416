"""How often names were right at their posterior probability: the slope of the stated probabilities.

The slope b of `bluekoi.engine.calibration` is the one of maximum likelihood for the names in
validation/results: log odds of being true = b times the log odds of the posterior. Its interval is
that of resampled generators, and its log score is that of predictions for the names of each
generator by the slope from the other generators.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize_scalar

from bluekoi.engine.calibration import MAX_POSTERIOR, calibrated_probability

from .report import Run

MAX_SLOPE = 2.0
RESAMPLES = 1000
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Names:
    """Named causes (names,): generator, log odds of the posterior, whether the cause was true."""

    generator: npt.NDArray[np.str_]
    log_odds: Array
    true: npt.NDArray[np.bool_]

    def __getitem__(self, chosen: npt.NDArray[Any]) -> Names:
        return Names(self.generator[chosen], self.log_odds[chosen], self.true[chosen])


def estimation_runs(runs: Sequence[Run]) -> list[Run]:
    """Runs from which the slope is estimated: those that stated posterior probabilities. Runs that
    stated calibrated ones had the slope already and are its test.
    """
    return [run for run in runs if run.slope == 1.0]


def names_of(runs: Sequence[Run]) -> Names:
    """All named causes of runs. A run with stated probabilities keeps its slope (`slope`)."""
    rows = [
        (run.generator, posterior_log_odds(p, run.slope), name in study["truth"])
        for run in runs
        for study in run.studies
        for name, p in study["named"].items()
    ]
    generator, log_odds, true = (np.array(column) for column in zip(*rows, strict=True))
    return Names(generator, log_odds.astype(float), true.astype(bool))


def posterior_log_odds(stated: float, slope: float) -> float:
    """Log odds of the posterior behind a probability that was stated with a slope."""
    bound = calibrated_probability(MAX_POSTERIOR, slope)
    p = float(np.clip(stated, 1.0 - MAX_POSTERIOR, bound))
    odds = float(np.log(p / (1.0 - p)))
    return odds / slope if odds > 0 else odds


def negative_log_score(names: Names, slope: float) -> float:
    """-log of the probability of what was true, by a slope."""
    sign = np.where(names.true, 1.0, -1.0)
    return float(np.sum(np.logaddexp(0.0, -sign * slope * names.log_odds)))


def fitted_slope(names: Names) -> float:
    """Slope of maximum likelihood."""
    return float(minimize_scalar(lambda b: negative_log_score(names, b), bounds=(0.0, MAX_SLOPE),
                                 method="bounded").x)  # fmt: skip


def left_out_log_scores(names: Names) -> tuple[float, float]:
    """Log scores of the names of each generator: with the slope from the others, and with 1."""
    fitted = 0.0
    for one in np.unique(names.generator):
        own = names.generator == one
        fitted -= negative_log_score(names[own], fitted_slope(names[~own]))
    return fitted, -negative_log_score(names, 1.0)


def slope_interval(names: Names, resamples: int = RESAMPLES, seed: int = 1) -> tuple[float, float]:
    """95 % interval of the slope over resampled generators."""
    rng = np.random.default_rng(seed)
    places = [np.flatnonzero(names.generator == one) for one in np.unique(names.generator)]
    slopes = [
        fitted_slope(names[np.concatenate([places[i] for i in drawn])])
        for drawn in rng.integers(len(places), size=(resamples, len(places)))
    ]
    low, high = np.percentile(slopes, [2.5, 97.5])
    return float(low), float(high)


def slope_report(names: Names) -> str:
    """Lines: slope with interval, and log scores on left-out generators."""
    fitted, plain = left_out_log_scores(names)
    low, high = slope_interval(names)
    return (
        f"{len(names.true)} names, {len(np.unique(names.generator))} generators\n"
        f"slope {fitted_slope(names):.2f} (95 % {low:.2f} to {high:.2f})\n"
        f"log score on left-out generators: {fitted:.1f}, with slope 1 {plain:.1f}"
    )
