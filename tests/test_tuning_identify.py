"""What trials determine and what not: spectrum, profiles, and the trial that would help."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.fitting import TrialSeries, cluster_covariance, off_bounds
from bluekoi.fitting.joint_fit import AT_BOUND_REASON
from bluekoi.model import two_plate_system
from bluekoi.tuning import JointFit, coefficient_table, downsampled, fit_all_trials
from bluekoi.tuning.identify import fisher_eigendirections, likelihood_profiles, parameter_scales
from bluekoi.tuning.new_trial import c_optimal_trial, parameters_for_planned_trials
from bluekoi.tuning.turning_trials import joint_fit_outcome_text, undetermined_without_turns
from bluekoi.tuning.undetermined import undetermined_combinations
from paper_robot import PAPER_SETUP
from simulated_campaigns import COEFFICIENTS, ErrorModel, simulate_campaigns, trial_plans

NAMES = tuple(COEFFICIENTS)


@pytest.fixture(scope="module")
def simulated_campaign() -> list[TrialSeries]:
    return downsampled(
        simulate_campaigns(trial_plans((50, 100)), ErrorModel(), np.random.default_rng(7), count=1)[
            0
        ]
    )


@pytest.fixture(scope="module")
def straight_runs_fit() -> list[TrialSeries]:
    made = simulate_campaigns(
        trial_plans((50, 100), ((0.0, 0.12), (0.0, 0.12))),
        ErrorModel(push=(1e-4, 1e-4, 1e-6)),
        np.random.default_rng(8),
        count=1,
    )
    return downsampled(made[0])


def test_spectrum_covers_all_directions_the_least_determined_first(simulated_campaign) -> None:
    found = fisher_eigendirections(fit_all_trials(simulated_campaign))
    assert len(found) == 6
    stds = [c.std for c in found]
    assert stds == sorted(stds, reverse=True)
    for one in found:
        assert np.linalg.norm(one.direction) == pytest.approx(1.0)
    assert found[-1].std < 0.02


def test_straight_runs_leave_the_turning_coefficients_open_and_say_so(straight_runs_fit) -> None:
    joint = fit_all_trials(straight_runs_fit)
    combinations = undetermined_combinations(straight_runs_fit, joint, PAPER_SETUP)
    assert combinations
    named = " ".join(t["combination"] for t in combinations)
    assert "C_Da" in named or "C_Md" in named
    assert any("Straight runs hold alpha at 0" in t["sentence"] for t in combinations)
    assert any(t["trial"].startswith("a turn at") for t in combinations), combinations


def test_the_trial_that_is_named_does_help(straight_runs_fit) -> None:
    joint = fit_all_trials(straight_runs_fit)
    worst = fisher_eigendirections(joint)[0]
    trial = c_optimal_trial(straight_runs_fit, joint, PAPER_SETUP, worst)
    assert trial.head_angle_deg > 0
    assert trial.left < 0.7


BOUNDS = {"C_Da": 40.0, "C_La": 4.2, "C_Ma": -1.0, "C_Md": 5.0}


@pytest.fixture(scope="module")
def fit_at_bounds(straight_runs_fit) -> JointFit:
    """The straight runs' fit as it comes out where three numbers run to their bounds."""
    found = fit_all_trials(straight_runs_fit)
    values = np.array([BOUNDS.get(n, v) for n, v in found.fit.values_by_label().items()])
    fit = replace(found.fit, values=values, outcome=AT_BOUND_REASON)
    spread = cluster_covariance(fit.normal, off_bounds(fit))
    return JointFit(fit, found.noise, spread.cov, found.base, spread.df, spread.influence)


def test_a_trial_is_named_even_where_numbers_stand_at_bounds(
    straight_runs_fit, fit_at_bounds
) -> None:
    """With C_Da 40 and C_Ma -1 imagined turns run away; nan is no recommendation."""
    combinations = undetermined_combinations(straight_runs_fit, fit_at_bounds, PAPER_SETUP)
    assert len(combinations) >= 4
    for one in combinations:
        assert "nan" not in one["trial"]
    for one in fisher_eigendirections(fit_at_bounds):
        trial = c_optimal_trial(straight_runs_fit, fit_at_bounds, PAPER_SETUP, one)
        assert trial is not None
        assert 0.0 <= trial.left <= 1.0
    assert any(t["trial"].startswith("a turn at") for t in combinations)


def test_trials_are_imagined_at_plausible_values(
    straight_runs_fit, simulated_campaign, fit_at_bounds
) -> None:
    values = dict(
        zip(NAMES, parameters_for_planned_trials(straight_runs_fit, fit_at_bounds), strict=True)
    )
    starts = {p.name: p.start for p in two_plate_system().parameters}
    assert all(values[name] == starts[name] for name in BOUNDS)
    assert values["C_T"] == fit_at_bounds.fit.values[NAMES.index("C_T")]
    joint = fit_all_trials(simulated_campaign)
    assert parameters_for_planned_trials(simulated_campaign, joint) == pytest.approx(
        joint.fit.values
    )


def test_straight_runs_at_a_bound_lack_turns_not_physics(
    straight_runs_fit, simulated_campaign, fit_at_bounds
) -> None:
    text = joint_fit_outcome_text(fit_at_bounds, straight_runs_fit)
    assert "turns are lacking" in text
    assert "C_Da, C_Ma, C_Md" in text
    assert "physics" not in text
    table_ = undetermined_without_turns(coefficient_table(fit_at_bounds), straight_runs_fit)
    assert "no turns" in table_["C_Da"]["why"]
    assert joint_fit_outcome_text(fit_at_bounds, simulated_campaign) == AT_BOUND_REASON


def test_numbers_at_a_bound_are_never_determined_combinations(fit_at_bounds) -> None:
    held = [one for one in fisher_eigendirections(fit_at_bounds) if one.side]
    assert len(held) == 3
    assert not any(one.determined for one in held)


def test_spectrum_has_the_widths_of_the_table(simulated_campaign) -> None:
    joint = fit_all_trials(simulated_campaign)
    size = parameter_scales(joint)
    for one in fisher_eigendirections(joint):
        half = joint.covariance.half_width(one.direction / size)
        assert one.std == pytest.approx(max(half / 1.96, one.naive))
    widths = [joint.covariance.half_width(unit) for unit in np.eye(6)]
    assert widths == pytest.approx(joint.covariance.half_widths())


def test_one_trial_determines_no_combination(simulated_campaign) -> None:
    turn = [next(s for s in simulated_campaign if abs(s.inputs[0, 0]) > 0.5)]
    joint = fit_all_trials(turn)
    assert not any(one.determined for one in fisher_eigendirections(joint))
    combinations = undetermined_combinations(turn, joint, PAPER_SETUP)
    assert len(combinations) == 6
    assert any("Only one trial determines it" in one["sentence"] for one in combinations)


def test_what_only_one_trial_determines_is_to_be_repeated(simulated_campaign) -> None:
    """Two straight runs and one turn: the turn again."""
    few = [*[s for s in simulated_campaign if s.inputs[0, 0] == 0.0][:2],
           next(s for s in simulated_campaign if abs(s.inputs[0, 0]) > 0.5)]  # fmt: skip
    combinations = undetermined_combinations(few, fit_all_trials(few), PAPER_SETUP)
    advice = [one["trial"] for one in combinations]
    assert any(a.startswith(f"a repeat of {few[2].name}") for a in advice), advice


def test_profile_has_its_top_at_the_fit_and_agrees_with_the_fisher_matrix(
    simulated_campaign,
) -> None:
    joint = fit_all_trials(simulated_campaign)
    drawn = likelihood_profiles(simulated_campaign, joint)
    for name in ("C_T", "C_La"):
        index = NAMES.index(name)
        found = drawn[index]
        assert np.all(found.lost > -0.1)
        naive = np.sqrt(joint.fit.naive_cov[index, index])
        expected = 0.5 * ((found.values - joint.fit.values[index]) / naive) ** 2
        assert found.lost == pytest.approx(expected, rel=0.5, abs=0.3)
        assert found.lower is None or found.lower < joint.fit.values[index]
        assert found.upper is None or found.upper > joint.fit.values[index]


def test_a_well_planned_campaign_determines_what_it_should(simulated_campaign) -> None:
    joint = fit_all_trials(simulated_campaign)
    truth = np.array([COEFFICIENTS[n] for n in NAMES])
    inside = (joint.interval_95[:, 0] <= truth) & (truth <= joint.interval_95[:, 1])
    assert inside.sum() >= 5
    assert joint.df is not None
    assert np.all((joint.df > 1) & (joint.df < 12))
