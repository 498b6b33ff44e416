"""Whatever the trials are, a fit ends with numbers or in an outcome with advice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bluekoi.fitting import TrialSeries
from bluekoi.integrate import compile_system
from bluekoi.mismatch.camera_displacement import detect_displacements
from bluekoi.model import two_plate_system
from bluekoi.tuning import JointFit, coefficient_table, downsampled, fit_all_trials
from bluekoi.tuning.draws import sample_parameters
from bluekoi.tuning.identify import fisher_eigendirections, likelihood_profiles
from simulated_campaigns import ErrorModel, simulate_campaigns
from simulated_campaigns import trial_plans as plans_of


@pytest.fixture(scope="module")
def simulated_trials() -> list[TrialSeries]:
    wanted = plans_of((100,), ((0.0, 0.12), (30.0, 0.12), (-45.0, 0.12)))
    return simulate_campaigns(wanted, ErrorModel(), np.random.default_rng(3), count=1)[0]


def with_changes(
    one: TrialSeries, *, clock: float = 1.0, scale: float = 1.0, shift_m: float = 0.0,
    mirrored: bool = False, frames: int | None = None,
) -> TrialSeries:  # fmt: skip
    """The trial with another clock, scale or place, seen in a mirror, or cut short."""
    seen, mean = one.seen.copy(), one.mean.copy()
    seen[:, :2] *= scale
    mean[:2] *= scale
    mean[3:6] *= np.array([scale, scale, 1.0]) / clock
    if mirrored:
        seen[:, 1:] *= -1
        mean[[1, 2, 4, 5]] *= -1
    seen[:, :2] += shift_m
    mean[:2] += shift_m
    cut = slice(frames)
    return replace(one, times=clock * one.times[cut], seen=seen[cut], mean=mean,
                   inputs=one.inputs[cut], noise=one.noise[cut])  # fmt: skip


def tuning_json(series: list[TrialSeries]) -> JointFit:
    """Everything that the stage `tuning` makes of a joint fit."""
    few = downsampled(series)
    found = fit_all_trials(few)
    cells = coefficient_table(found)
    assert all(np.isfinite(cell["value"]) for cell in cells.values())
    assert all(cell["why"] for cell in cells.values() if not cell["determined"])
    assert found.fit.outcome
    assert np.isfinite(sample_parameters(found, 20, np.random.default_rng(0))).all()
    assert len(fisher_eigendirections(found)) == len(likelihood_profiles(few, found)) == len(cells)
    return found


@settings(max_examples=7, deadline=None, derandomize=True,
          suppress_health_check=[HealthCheck.function_scoped_fixture])  # fmt: skip
@given(
    clock=st.sampled_from([1 / 16, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0]),
    scale=st.sampled_from([0.01, 0.3, 1.0, 3.0, 30.0]),
    shift_m=st.sampled_from([0.0, -40.0]),
    mirrored=st.booleans(),
    frames=st.sampled_from([None, 2, 7, 40]),
    order=st.permutations([0, 1, 2]),
)
def test_a_fit_ends_with_numbers_or_advice(
    simulated_trials, clock, scale, shift_m, mirrored, frames, order
):
    series = [
        with_changes(
            simulated_trials[i],
            clock=clock,
            scale=scale,
            shift_m=shift_m,
            mirrored=mirrored,
            frames=frames,
        )
        for i in order
    ]
    assert tuning_json(series).fit.normal.all_finite


@pytest.mark.parametrize("change", [{"clock": 0.125}, {"scale": 10.0}, {"scale": 100.0}])
def test_a_model_that_runs_away_at_its_usual_numbers_is_begun_at_smaller_ones(
    simulated_trials, change
):
    assert tuning_json(
        [with_changes(one, **change) for one in simulated_trials]
    ).fit.normal.all_finite


def test_trials_that_no_coefficients_describe_are_refused(simulated_trials):
    with pytest.raises(FloatingPointError, match="runs away from these trials"):
        fit_all_trials(downsampled([with_changes(one, scale=1000.0) for one in simulated_trials]))


def test_trials_too_short_for_a_displaced_camera_have_none(simulated_trials):
    kernel, few = (
        compile_system(two_plate_system()),
        downsampled([with_changes(one, frames=16) for one in simulated_trials]),
    )
    found = fit_all_trials(few)
    values = found.parameter_vectors_by_trial(kernel, few)
    assert max(len(one.times) for one in few) < 8
    assert detect_displacements(kernel, few, values, found.noise) == []


def test_a_mirrored_study_has_the_same_coefficients(simulated_trials):
    values = tuning_json(simulated_trials).fit.values
    wanted = [replace(with_changes(one, mirrored=True), inputs=one.inputs * [-1.0, 1.0])
              for one in simulated_trials]  # fmt: skip
    assert tuning_json(wanted).fit.values == pytest.approx(values, rel=0.02)
