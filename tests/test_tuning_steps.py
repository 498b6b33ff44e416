"""What is stated of a step that takes an earlier one's numbers, and draws as wide as intervals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_tuning_bounds import at_lower_bound

from bluekoi.fitting import (
    ClusterCovariance,
    FreeParameter,
    NormalEquationsByTrial,
    ParameterFit,
    TrialSeries,
    cluster_covariance,
    off_bounds,
    student_t_draws,
)
from bluekoi.fitting.joint_fit import free_parameter_definitions
from bluekoi.model import two_plate_system
from bluekoi.tuning import JointFit, downsampled, fit_all_trials
from bluekoi.tuning.draws import response_to_parameters_at_bounds, sample_parameters
from bluekoi.tuning.joint_fit import START_NOISE
from bluekoi.tuning.paper_steps import _fit_second_step, sample_step_parameters
from bluekoi.tuning.two_step_covariance import (
    sensitivity_to_earlier_step,
    with_earlier_step_covariance,
)
from simulated_campaigns import ErrorModel, simulate_campaigns, trial_plans

FRAMES = 20
CONDITIONS = ((0.0, 0.12), (0.0, 0.12), (30.0, 0.12), (-30.0, 0.12), (45.0, 0.12))


def fit_result(
    values: np.ndarray, names: list[str], normal: NormalEquationsByTrial, **more: object
) -> JointFit:
    spread = cluster_covariance(normal, **more)  # type: ignore[arg-type]
    free = tuple(FreeParameter(n) for n in names)
    known = free_parameter_definitions(two_plate_system(), free)
    fit = ParameterFit(free, values, normal, "", 1, known)
    return JointFit(
        fit,
        START_NOISE,
        spread.cov,
        two_plate_system().parameter_vector({}),
        spread.df,
        spread.influence,
    )


def two_step_regression(rng: np.random.Generator) -> tuple[JointFit, JointFit, np.ndarray]:
    """Lines whose first number comes from 4 trials of its own, two others from 6; truth is 0."""
    X1, X2 = rng.standard_normal((4, FRAMES, 1)), rng.standard_normal((6, FRAMES, 3))
    X2[:, :, 0] += 2.0 * X2[:, :, 1]
    y1, y2 = rng.standard_normal((4, FRAMES)), rng.standard_normal((6, FRAMES))
    first, left1 = least_squares(X1, y1)
    own = X2[:, :, 1:]
    second, left2 = least_squares(own, y2 - X2[:, :, 0] * first)
    H = np.einsum("tnp,tnq->pq", X2, X2)
    sensitivity = -np.linalg.solve(H[1:, 1:], H[1:, :1])
    return (
        fit_result(second, ["C_La", "C_Ma"], normal_equations_of(own, left2)),
        fit_result(first, ["C_D0"], normal_equations_of(X1, left1)),
        sensitivity,
    )


def least_squares(X: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rows = X.reshape(-1, X.shape[2])
    values = np.linalg.lstsq(rows, y.ravel(), rcond=None)[0]
    return values, y - X @ values


def normal_equations_of(X: np.ndarray, left: np.ndarray) -> NormalEquationsByTrial:
    H = np.einsum("tnp,tnq->tpq", X, X)
    return NormalEquationsByTrial(H, np.einsum("tnp,tn->tp", X, left), np.zeros(len(X)))


def test_intervals_of_a_step_hold_the_truth_if_the_earlier_step_is_carried_along() -> None:
    rng = np.random.default_rng(6)
    plain, whole = [], []
    for _ in range(500):
        later, earlier, sensitivity = two_step_regression(rng)
        whole_one = with_earlier_step_covariance(later, earlier, sensitivity)
        off = np.abs(later.fit.values)
        plain.append(off <= later.covariance.half_widths())
        whole.append(off <= whole_one.covariance.half_widths())
    assert np.mean(plain, axis=0)[0] < 0.75, "C_La leans on the number that was taken as exact"
    assert np.mean(whole, axis=0) == pytest.approx([0.95, 0.95], abs=0.03)


def test_what_cannot_be_judged_of_the_earlier_step_is_not_judged_of_the_later() -> None:
    later, earlier, sensitivity = two_step_regression(np.random.default_rng(7))
    unknown = replace(earlier, df=np.zeros(1), influence=None)
    assert with_earlier_step_covariance(later, unknown, sensitivity).df[0] == 0.0
    nothing = with_earlier_step_covariance(later, earlier, 0.0 * sensitivity)
    assert nothing.cov == pytest.approx(later.cov)
    assert nothing.df == pytest.approx(later.df)


@pytest.fixture(scope="module")
def three_step_fit() -> tuple[list[TrialSeries], JointFit, JointFit]:
    few = downsampled(
        simulate_campaigns(
            trial_plans((75,), CONDITIONS), ErrorModel(), np.random.default_rng(5), count=1
        )[0]
    )
    first = fit_all_trials(few[:2], [FreeParameter("C_T"), FreeParameter("C_D0")], min_share=1.0)
    return few[2:], first, _fit_second_step(few[2:], first)


def test_a_step_goes_along_with_the_earlier_one_as_refitting_it_shows(three_step_fit) -> None:
    turns, first, second = three_step_fit
    sensitivity = sensitivity_to_earlier_step(turns, second, first)
    change = 0.02 * first.fit.values[1]

    def refitted(by: float) -> np.ndarray:
        changed = second.base.copy()
        changed[two_plate_system().parameter_index["C_D0"]] += by
        return fit_all_trials(turns, second.fit.free, base=changed, noise=second.noise,
                    start=second.fit.values_by_label()).fit.values  # fmt: skip

    # half the difference of two refits: how far one fit stops from its optimum cancels
    moved = 0.5 * (refitted(change) - refitted(-change))
    size = np.abs(sensitivity[:, 1] * change)
    reported = size > 0.1 * second.std
    assert reported.any()
    assert moved[reported] == pytest.approx(sensitivity[reported, 1] * change, rel=0.25)
    whole = with_earlier_step_covariance(second, first, sensitivity)
    assert whole.cov == pytest.approx(second.cov + sensitivity @ first.cov @ sensitivity.T)
    assert np.all(whole.std >= second.std)


def test_no_variance_of_a_step_is_less_than_the_naive_one(three_step_fit) -> None:
    _, first, second = three_step_fit
    for one in (first, second):
        assert np.all(one.std >= 0.999 * np.sqrt(np.diag(one.fit.naive_cov)))


def test_draws_of_a_step_go_along_with_those_of_the_earlier_one(three_step_fit) -> None:
    turns, first, second = three_step_fit
    sensitivity = sensitivity_to_earlier_step(turns, second, first)
    tight = replace(second, cov=1e-12 * second.cov)
    found = sample_step_parameters((first, tight), sensitivity, np.random.default_rng(1))
    moved = np.column_stack([found[n] for n in ("C_T", "C_D0")]) - first.fit.values
    expected = second.fit.values[0] + moved @ sensitivity[0]
    near = np.abs(expected - second.fit.values[0]) < 1.0
    assert near.sum() > 30
    assert np.array(found["C_La"])[near] == pytest.approx(expected[near], abs=1e-3)


def test_draws_are_as_wide_as_students_intervals_number_by_number() -> None:
    std = np.array([0.1, 0.02, 0.3])
    near = np.array([[1.0, 0.9994, 0.2], [0.9994, 1.0, 0.2], [0.2, 0.2, 1.0]])
    spread = ClusterCovariance(near * np.outer(std, std), np.array([2.0, 2.02, 12.0]))
    values = np.array([1.0, 2.0, 3.0])
    free = tuple(FreeParameter(n) for n in ("C_La", "C_Ma", "C_Da"))
    fit = ParameterFit(
        free,
        values,
        NormalEquationsByTrial(np.zeros((1, 3, 3)), np.zeros((1, 3)), np.zeros(1)),
        "",
        1,
        free_parameter_definitions(two_plate_system(), free),
    )
    rows = student_t_draws(fit, spread, 40_000, np.random.default_rng(2)) - values
    for level in (0.5, 0.95):
        found = np.quantile(np.abs(rows), level, axis=0)
        assert found == pytest.approx(spread.half_widths(level), rel=0.06)
    known = rows[:, 0] / std[0] - rows[:, 1] / std[1]
    expected = spread.half_widths()[0] / std[0] * np.sqrt(2 * (1 - 0.9994))
    assert np.quantile(np.abs(known), 0.95) == pytest.approx(expected, rel=0.3)


def test_a_number_at_its_bound_varies_over_its_interval_and_the_others_go_along() -> None:
    fit = at_lower_bound(-0.5, widths=0.1)
    low, high = fit.interval_95[2]
    rows = sample_parameters(fit, 4000, np.random.default_rng(3))
    assert rows[:, 2].min() >= low
    assert rows[:, 2].max() <= high
    assert rows[:, 2].max() - rows[:, 2].min() > 0.8 * (high - low)
    assert np.mean(rows[:, 2] < 0.5 * (low + high)) > 0.5
    slope = np.cov(rows[:, 2], rows[:, 3])[0, 1] / np.var(rows[:, 2])
    wide = np.std(rows[:, 3]) / np.std(rows[:, 2]) / np.sqrt(4000)
    assert slope == pytest.approx(
        response_to_parameters_at_bounds(fit.fit, [2])[3, 0], abs=5 * wide
    )
    assert not off_bounds(fit.fit)[2]


def test_a_number_beyond_its_bound_alone_stays_there() -> None:
    fit = at_lower_bound(-50.0, widths=0.1)
    assert np.isnan(fit.interval_95[2]).all()
    rows = sample_parameters(fit, 50, np.random.default_rng(3))
    assert np.all(rows[:, 2] == fit.fit.values[2])
