"""Errors that differ between trials have parameters of their own, without functional forms."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.engine import CauseSearchProblem
from bluekoi.fitting.normal import trial_normal_equations
from simulated_campaigns import simulated_search_problem


@pytest.fixture(scope="module")
def problem() -> CauseSearchProblem:
    """Six trials with an error of the servo in each."""
    return simulated_search_problem(np.random.default_rng(5))


def test_an_error_of_a_trial_has_no_functional_form(problem: CauseSearchProblem) -> None:
    """With the form of a gain error, straight trials had no error of the servo."""
    system = problem.kernel.system
    for effect in problem.noise.trial_effects:
        if "." in effect.parameter:
            own = system.effect(effect.parameter.split(".")[0])
            assert len(own.parameters) == own.strengths, effect.parameter
    assert not {"servo_error", "head_angle_error"} & {c.name for c in problem.candidates}


@pytest.mark.parametrize("form", ["head_angle_offset.gain_share", "keypoint_bias.head_angle_share"])
def test_the_form_of_an_absent_cause_does_not_change_the_likelihood(
    problem: CauseSearchProblem, form: str
) -> None:
    kernel, free = problem.kernel, problem.coefficients
    at = np.array([problem.base[kernel.system.parameter_index[f.name]] for f in free])
    other = problem.base.copy()
    other[kernel.system.parameter_index[form]] = 1.0
    first, second = (
        trial_normal_equations(kernel, problem.series, base, free, at, noise=problem.noise)
        for base in (problem.base, other)
    )
    assert second.log_likelihood == pytest.approx(first.log_likelihood)
