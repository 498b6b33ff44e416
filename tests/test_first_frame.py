"""The start of a trial in the search for causes: what is known of it, and what was measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.engine import CauseSearchProblem
from bluekoi.fitting import TrialEffect
from bluekoi.mismatch.robot_problem import START_TIME_STD_S
from simulated_campaigns import simulated_search_problem
from validation import first_frame

START_DELAY = "time_offset.start_delay"


@pytest.fixture(scope="module")
def problem() -> CauseSearchProblem:
    """Six trials that begin at rest."""
    return simulated_search_problem(np.random.default_rng(5))


def test_the_start_has_an_error_in_each_trial_and_one_in_all(problem: CauseSearchProblem) -> None:
    assert problem.tolerances[START_DELAY] == START_TIME_STD_S
    assert TrialEffect(START_DELAY, START_TIME_STD_S) in problem.noise.trial_effects


def test_one_standard_deviation_of_the_start_is_changed_at_a_time(
    problem: CauseSearchProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The velocities, where a trial begins at rest alone; the log likelihood has a stand-in."""
    swims = replace(problem.series[0], mean=problem.series[0].mean + 0.1)
    series = (swims, *problem.series[1:])
    velocities = np.array([np.sqrt(np.diag(one.cov))[3:6] for one in series])
    seen = []
    monkeypatch.setattr(first_frame, "_log_likelihood", lambda one, _: seen.append(one) or 0.0)
    gains = first_frame.gains_of_problem(replace(problem, series=series), {})
    for name, other in zip(gains, seen[1:], strict=True):
        times, factor = name.startswith("start time"), float(name.split()[-1])
        std = next(e.std for e in other.noise.trial_effects if e.parameter == START_DELAY)
        assert std == pytest.approx(START_TIME_STD_S * (factor if times else 1.0))
        found = np.array([np.sqrt(np.diag(one.cov))[3:6] for one in other.series])
        assert found[0] == pytest.approx(velocities[0])
        assert found[1:] == pytest.approx(velocities[1:] * (1.0 if times else factor))
    assert "least" in first_frame.gain_table([gains])
