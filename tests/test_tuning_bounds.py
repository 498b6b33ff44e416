"""Statements on parameters at a bound, undetermined, or known from one trial only."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import exact_campaign as exact
import numpy as np
import pytest

from bluekoi.fitting import (
    FreeParameter,
    NormalEquationsByTrial,
    ParameterFit,
    cluster_covariance,
    off_bounds,
)
from bluekoi.fitting.joint_fit import free_parameter_definitions
from bluekoi.model import RobotScaleRatios, two_plate_system
from bluekoi.report import identifiability, tables
from bluekoi.study import Study, Trial
from bluekoi.tuning import (
    coefficient_cell,
    coefficient_table,
    downsampled,
    fit_all_trials,
    fit_paper_steps,
    table_1_coefficients,
)
from bluekoi.tuning.joint_fit import (
    START_NOISE,
    JointFit,
)
from bluekoi.tuning.results import straight_swimming_stability
from bluekoi.tuning.similar_robots import noise_scaled_to_robot
from paper_robot import PAPER_SETUP
from simulated_campaigns import COEFFICIENTS, ErrorModel, simulate_campaigns, trial_plans

NAMES = tuple(COEFFICIENTS)
TRUTH = np.array([COEFFICIENTS[n] for n in NAMES])


def tuned_at(
    values: np.ndarray, *, pull: float = 0.0, widths: float = 0.02, trials: int = 12
) -> JointFit:
    """A fit that ended at these values; the trials pull C_Da by `pull` of its deviations beyond."""
    rng = np.random.default_rng(5)
    scale = 1.0 / (widths * TRUTH)
    X = rng.standard_normal((trials, 40, 6)) * scale / np.sqrt(40 * trials)
    H = np.einsum("tnp,tnq->tpq", X, X)
    e = rng.standard_normal((trials, 40))
    e -= np.einsum("tnp,p->tn", X, np.linalg.solve(H.sum(0), np.einsum("tnp,tn->p", X, e)))
    g = np.einsum("tnp,tn->tp", X, e)
    push = np.zeros(6)
    push[2] = pull * widths * TRUTH[2]
    normal = NormalEquationsByTrial(H, g + H @ push, np.zeros(trials))
    free = tuple(FreeParameter(n) for n in NAMES)
    known = free_parameter_definitions(two_plate_system(), free)
    found = ParameterFit(free, values, normal, "", 1, known)
    spread = cluster_covariance(normal, off_bounds(found))
    return JointFit(
        found, START_NOISE, spread.cov, two_plate_system().parameter_vector({}), spread.df
    )


def at_lower_bound(pull: float, **more: float) -> JointFit:
    values = TRUTH.copy()
    values[2] = {p.name: p for p in two_plate_system().parameters}["C_Da"].lower
    return tuned_at(values, pull=pull, **more)


def test_a_number_at_its_bound_has_a_one_sided_interval_and_no_deviation() -> None:
    row = coefficient_table(at_lower_bound(-1.0, widths=0.1))["C_Da"]
    low, high = row["interval_95"]
    assert row["std"] is None
    assert row["at_bound"] == "lower"
    assert low == row["value"]
    assert high > low
    assert not row["determined"]
    assert "at its bound" in row["why"]
    assert f"{high:.3g}" in row["why"]
    others = [c for n, c in coefficient_table(at_lower_bound(-1.0)).items() if n != "C_Da"]
    assert all(c["std"] > 0 and "at_bound" not in c for c in others)


def test_the_one_sided_interval_ends_where_it_would_without_the_bound() -> None:
    fit = at_lower_bound(0.5, widths=0.1)
    free = replace(fit.fit.normal, gradient=tuned_at(TRUTH, widths=0.1).fit.normal.gradient)
    half = cluster_covariance(free).half_widths()[2]
    low, high = coefficient_cell(fit, 2)["interval_95"]
    assert high - low == pytest.approx(0.5 * 0.1 * TRUTH[2] + half, rel=1e-6)


def test_where_the_data_ask_for_more_than_the_bound_the_interval_is_unknown() -> None:
    row = coefficient_cell(at_lower_bound(-40.0), 2)
    assert row["interval_95"] == [None, None]
    assert row["std"] is None
    assert "physics that is not in the model" in row["why"]


def test_the_percentage_that_is_reported_is_that_of_the_interval() -> None:
    wide = tuned_at(TRUTH, widths=2.0)
    for row in coefficient_table(wide).values():
        low, high = row["interval_95"]
        assert not row["determined"]
        assert row["why"].startswith("half of its 95 % interval is ")
        percent = float(row["why"].split(" is ")[1].split(" %")[0])
        assert percent == pytest.approx(50 * (high - low) / abs(row["value"]), abs=0.6) or (
            "usual size" in row["why"]
        )


def test_sizes_that_are_not_the_values_are_named() -> None:
    values = TRUTH.copy()
    values[4] = 0.001
    usual = {p.name: abs(p.start) for p in two_plate_system().parameters}["C_Ma"]
    assert (
        f"its usual size of {usual:g}" in coefficient_cell(tuned_at(values, widths=2.0), 4)["why"]
    )


def test_a_number_that_hangs_on_one_trial_alone_is_not_judged() -> None:
    """C_Da is in the sight of one trial of twelve, whose score of it is 0 by construction."""
    fit = tuned_at(TRUTH)
    H, g = fit.fit.normal.hessian.copy(), fit.fit.normal.gradient.copy()
    H[1:, 2], H[1:, :, 2], g[:, 2] = 0.0, 0.0, 0.0
    spread = cluster_covariance(NormalEquationsByTrial(H, g, np.zeros(12)))
    changed = replace(fit.fit, normal=NormalEquationsByTrial(H, g, np.zeros(12)))
    row = coefficient_table(JointFit(changed, fit.noise, spread.cov, fit.base, spread.df))
    assert row["C_Da"]["std"] is None
    assert row["C_Da"]["interval_95"] == [None, None]
    assert "only one trial determines it" in row["C_Da"]["why"]
    assert row["C_T"]["determined"]


@pytest.fixture(scope="module")
def fit_with_one_turn() -> tuple[Study, list]:
    wanted = trial_plans((75,), ((30.0, 0.12),))
    series = downsampled(
        simulate_campaigns(wanted, ErrorModel(), np.random.default_rng(3), count=1)[0]
    )
    trials = [
        Trial(
            trial_id=p.name,
            source="k.csv",
            power_pct=p.power,
            fps=30.0,
            head_angle_deg=p.angle_deg,
            head_length_m=p.head_length_m,
        )
        for p in wanted
    ]
    return Study(root=Path("one"), setup=PAPER_SETUP, trials=tuple(trials)), series  # fmt: skip


def test_one_trial_determines_nothing_in_the_joint_fit_and_in_the_three_steps(
    fit_with_one_turn,
) -> None:
    study, series = fit_with_one_turn
    steps, _, _ = fit_paper_steps(study, series, {})
    joint = coefficient_table(fit_all_trials(series))
    for cells in (joint, steps["75"]["coefficients"]):
        for name, row in cells.items():
            assert not row["determined"], name
            assert row["std"] is None or "at_bound" in row
            assert "one trial" in row["why"] or "at its bound" in row["why"]
    one = table_1_coefficients(steps)
    assert np.isnan(one["C_T_std_m2"][0])
    assert "C_T_upper_95_m2" in one


def test_one_turn_says_nothing_of_straight_swimming(fit_with_one_turn) -> None:
    study, series = fit_with_one_turn
    joint = fit_all_trials(series)
    steps = {"75": {"flap_hz": 3.4}}
    row = straight_swimming_stability(study, steps, joint, np.tile(TRUTH, (3, 1)), series=series)
    assert row["stable"] is None
    assert row["interval_95"] is None
    assert "fewer than two turning trials" in row["sentence"]


@pytest.fixture
def shown_figures():
    given = exact.coefficients_json((75,))
    fit = coefficient_table(at_lower_bound(-1.0, widths=0.1))
    given["joint"]["coefficients"] = fit
    given["paper_steps"]["75"]["coefficients"] = fit
    given["joint"]["identifiability"] = {
        "profiles": {
            "C_Da": {"values": [1.0, 2.0], "lost": [1.0, 3.0], "lower": None, "upper": 1.5}
        }
    }
    return exact.exact_campaign(powers=(75,), coefficients=given)


def test_the_report_says_at_its_bound_and_never_plus_minus_nothing(shown_figures) -> None:
    row = next(r for r in tables.joint_fit_rows(shown_figures) if r.name == "C_Da")
    assert "(at its bound, 95 % limit " in row.cells[0]
    assert row.cells[1] == "–"
    assert row.marked
    (power,) = tables.coefficients_per_power_table(shown_figures)
    text, open_, why = power["cells"][2]
    assert "(at its bound, 95 % limit " in text
    assert open_
    assert "at its bound" in why
    assert not any("± 0.0000" in c[0] or c[0].endswith("± 0") for c in power["cells"])
    (one,) = identifiability.likelihood_profile_curves(shown_figures)
    assert one.interval.startswith("bound to 1.50")


def test_table_1_shows_the_interval_that_stands_in_the_file(shown_figures) -> None:
    cells = shown_figures.coefficients["paper_steps"]["75"]["coefficients"]
    low, high = cells["C_T"]["interval_95"]
    (power,) = tables.coefficients_per_power_table(shown_figures)
    assert float(power["cells"][0][0].split(" ± ")[1]) == pytest.approx(0.5 * (high - low), rel=0.1)


@pytest.mark.parametrize(
    "units", [RobotScaleRatios(14.0, 2.4, 1.55), RobotScaleRatios(0.02, 0.3, 0.55)]
)
def test_random_forces_of_a_first_fit_give_every_robot_the_same_accelerations(
    units: RobotScaleRatios,
) -> None:
    """With 0.5 mN m for a robot of 0.89 kg m2, a first fit ended at negative lift and drag."""
    found = noise_scaled_to_robot(units, START_NOISE).disturbance / START_NOISE.disturbance
    force = units.mass * units.length / units.time**2
    lengths = [force, force, force * units.length, units.length, units.length, 1.0]
    assert found == pytest.approx(lengths)
