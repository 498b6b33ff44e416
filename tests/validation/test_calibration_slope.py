"""The slope of the stated probabilities, from names that were right or wrong."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bluekoi.engine.calibration import (
    LOG_ODDS_CALIBRATION_SLOPE,
    MAX_POSTERIOR,
    calibrated_probability,
)
from validation import report
from validation.calibration_slope import (
    Names,
    estimation_runs,
    fitted_slope,
    left_out_log_scores,
    names_of,
    posterior_log_odds,
    slope_interval,
)


def overconfident_names(slope, count=4000, seed=3):
    """Names whose log odds of being true are `slope` times those of their posterior."""
    rng = np.random.default_rng(seed)
    log_odds = rng.exponential(3.0, count)
    true = rng.random(count) < 1.0 / (1.0 + np.exp(-slope * log_odds))
    return Names(rng.choice(["a", "b", "c"], count), log_odds, true)


@pytest.mark.parametrize("slope", [0.2, 0.5, 1.0])
def test_the_slope_behind_simulated_names_is_recovered(slope):
    names = overconfident_names(slope)
    low, high = slope_interval(names, resamples=50)
    assert fitted_slope(names) == pytest.approx(slope, rel=0.15)
    assert low - 0.1 < slope < high + 0.1


def test_the_slope_of_the_finder_is_that_of_the_recorded_verdicts():
    names = names_of(estimation_runs(report.load_runs()))
    fitted, plain = left_out_log_scores(names)
    assert pytest.approx(fitted_slope(names), abs=0.005) == LOG_ODDS_CALIBRATION_SLOPE
    assert fitted > plain + 10.0


def test_the_slope_of_verdicts_that_were_stated_with_it_is_within_its_interval():
    runs = report.load_runs()
    low, high = slope_interval(names_of(estimation_runs(runs)))
    assert low < fitted_slope(names_of([r for r in runs if r.slope != 1.0])) < high
    assert low < fitted_slope(names_of(runs)) < high


def test_recorded_names_are_true_as_often_as_their_calibrated_probabilities_state():
    names = names_of(report.load_runs())
    stated = 1.0 / (1.0 + np.exp(-LOG_ODDS_CALIBRATION_SLOPE * names.log_odds))
    for low in np.arange(0.5, 0.95, 0.1):
        inside = (stated >= low) & (stated < low + 0.1)
        hits, count = int(names.true[inside].sum()), int(inside.sum())
        least, most = report.clopper_pearson(hits, count)
        assert least <= stated[inside].mean() <= most, f"{low:.1f}: {hits} of {count}"


@pytest.mark.parametrize("p", [0.02, 0.5, 0.7, 0.99])
def test_the_posterior_behind_a_stated_probability_is_found_again(p):
    stated = calibrated_probability(p)
    assert posterior_log_odds(stated, LOG_ODDS_CALIBRATION_SLOPE) == pytest.approx(
        np.log(p / (1 - p))
    )
    assert calibrated_probability(1.0) == calibrated_probability(MAX_POSTERIOR) < 1.0
