"""Intervals from how trials disagree: they hold the truth as often as they say."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.fitting import (
    NormalEquationsByTrial,
    TrialRandomEffect,
    cluster_covariance,
    cov_hc2,
    cov_jackknife,
)
from bluekoi.fitting.resampling import MIN_INFORMATION_SHARE_LEFT, RIDGE_SHARE
from bluekoi.fitting.sandwich import _cr2_adjustment

TRUTH = np.array([1.0, -0.5, 0.3])
FRAMES, MEMORY = 30, 8.0


def fitted_line(trials: int, rng: np.random.Generator) -> tuple[np.ndarray, NormalEquationsByTrial]:
    """Least squares of a line with three numbers to trials whose errors last."""
    keep = np.exp(-1 / MEMORY)
    X = rng.standard_normal((trials, 1, 3)) + 0.5 * rng.standard_normal((trials, FRAMES, 3))
    e = rng.standard_normal((trials, FRAMES))
    for k in range(1, FRAMES):
        e[:, k] = keep * e[:, k - 1] + np.sqrt(1 - keep**2) * e[:, k]
    y = X @ TRUTH + e
    H = np.einsum("tnp,tnq->tpq", X, X)
    values = np.linalg.solve(H.sum(axis=0), np.einsum("tnp,tn->p", X, y))
    g = np.einsum("tnp,tn->tp", X, y - X @ values)
    return values, NormalEquationsByTrial(H, g, np.zeros(trials))


def coverage_shares(trials: int, count: int = 800) -> dict[str, np.ndarray]:
    """Share of the intervals that hold the truth, by way and number."""
    rng = np.random.default_rng(trials)
    inside: dict[str, list[np.ndarray]] = {"disagreement": [], "jackknife": [], "naive": []}
    for _ in range(count):
        values, normal = fitted_line(trials, rng)
        off = np.abs(values - TRUTH)
        inside["disagreement"].append(off <= cluster_covariance(normal).half_widths())
        inside["jackknife"].append(off <= 1.96 * np.sqrt(np.diag(cov_jackknife(normal))))
        naive = np.linalg.inv(normal.hessian.sum(axis=0))
        inside["naive"].append(off <= 1.96 * np.sqrt(np.diag(naive)))
    return {name: np.mean(rows, axis=0) for name, rows in inside.items()}


@pytest.mark.parametrize("trials", [6, 12, 40])
def test_95_percent_intervals_hold_the_truth_95_times_in_100(trials: int) -> None:
    found = coverage_shares(trials)
    assert np.all(np.abs(found["disagreement"] - 0.95) < 0.03), found
    assert np.all(found["naive"] < 0.85), "errors that last make the naive intervals too short"


def test_degrees_of_freedom_count_the_informative_trials() -> None:
    """One number that two trials of ten inform, one that all do."""
    rng = np.random.default_rng(4)
    X = rng.standard_normal((10, FRAMES, 2))
    X[2:, :, 0] = 0.0
    H = np.einsum("tnp,tnq->tpq", X, X)
    e = rng.standard_normal((10, FRAMES))
    shift = np.linalg.solve(H.sum(axis=0), np.einsum("tnp,tn->p", X, e))
    g = np.einsum("tnp,tn->tp", X, e - X @ shift)
    df = cluster_covariance(NormalEquationsByTrial(H, g, np.zeros(10))).df
    assert df[0] == pytest.approx(1.0, abs=0.3)
    assert 6 < df[1] < 9.5


def test_numbers_at_a_bound_have_no_variance_and_do_not_disturb_the_others() -> None:
    values, normal = fitted_line(12, np.random.default_rng(1))
    moving = np.array([True, False, True])
    spread = cluster_covariance(normal, moving)
    alone = cluster_covariance(
        NormalEquationsByTrial(
            normal.hessian[:, moving][:, :, moving], normal.gradient[:, moving], np.zeros(12)
        )
    )
    assert np.all(spread.cov[1] == 0)
    assert spread.df[1] == 0
    assert spread.cov[np.ix_(moving, moving)] == pytest.approx(alone.cov)
    assert len(values) == 3


def test_one_trial_falls_back_on_what_it_says_of_itself() -> None:
    _, normal = fitted_line(12, np.random.default_rng(2))
    one = NormalEquationsByTrial(normal.hessian[:1], normal.gradient[:1], np.zeros(1))
    assert cluster_covariance(one).cov == pytest.approx(np.linalg.inv(one.hessian[0]), rel=1e-6)


SERVO_STD = 0.5


def fits_with_trial_errors(
    count: int, size: float
) -> list[tuple[np.ndarray, NormalEquationsByTrial, TrialRandomEffect]]:
    """Fits to 18 trials of which three tell most; each has an error of its own that the fit lacks.

    z is what that error does to the observations; it weighs most where the information is largest.
    """
    rng = np.random.default_rng(11)
    weight = np.where(np.arange(18) < 3, 6.0, 1.0)[:, None]
    X = weight[..., None] * rng.standard_normal((18, FRAMES, 3))
    z = weight * (0.5 * rng.standard_normal((18, FRAMES)) + X[:, :, 0] / weight)
    H = np.einsum("tnp,tnq->tpq", X, X)
    out = []
    for _ in range(count):
        own = size * rng.standard_normal((18, 1))
        e = rng.standard_normal((18, FRAMES)) + own * z
        shift = np.linalg.solve(H.sum(axis=0), np.einsum("tnp,tn->p", X, e))
        left = e - X @ shift
        normal = NormalEquationsByTrial(H, np.einsum("tnp,tn->tp", X, left), np.zeros(18))
        lasting = TrialRandomEffect(
            np.einsum("tnp,tn->tp", X, z), np.sum(z**2, 1), np.sum(z * left, 1)
        )
        out.append((shift, normal, lasting))
    return out


@pytest.mark.parametrize("size", [0.0, SERVO_STD])
def test_the_error_that_each_trial_has_is_found_from_the_scores(size: float) -> None:
    fits = fits_with_trial_errors(400, size)
    found = np.mean([own.variance(normal.hessian) for _, normal, own in fits])
    assert found == pytest.approx(size**2, rel=0.12, abs=0.004)


def test_variances_are_right_where_the_most_informative_trials_err_most() -> None:
    """Of the second number: three degrees of freedom as if all erred alike, really two."""
    fits = fits_with_trial_errors(400, SERVO_STD)
    true = np.var([shift[1] for shift, _, _ in fits])
    alike = [cluster_covariance(normal) for _, normal, _ in fits]
    known = [cluster_covariance(normal, None, own) for _, normal, own in fits]
    short, right = (np.mean([s.cov[1, 1] for s in rows]) / true for rows in (alike, known))
    assert short < 0.75
    assert abs(right - 1.0) < 0.6 * abs(short - 1.0)
    assert known[0].df[1] < alike[0].df[1]
    half = np.array([s.half_widths() for s in known])
    inside = np.mean(np.abs([shift for shift, _, _ in fits]) <= half, axis=0)
    assert np.all(inside > 0.93), inside


def test_widened_scores_have_the_covariance_expected() -> None:
    rng = np.random.default_rng(3)
    X = rng.standard_normal((9, 4, 5, 1)) * rng.uniform(0.5, 2.0, (9, 1, 1, 1))
    H = (X @ np.swapaxes(X, 2, 3)).sum(axis=1)
    values, vectors = np.linalg.eigh(H.sum(axis=0))
    root = vectors / np.sqrt(values)
    S = root.T @ H @ root
    k = 0.3 * rng.standard_normal((9, 5))
    F = S + np.einsum("tp,tq->tpq", k, k)
    every = F.sum(axis=0)
    for A, s, f in zip(_cr2_adjustment(S, F), S, F, strict=True):
        left = f - s @ f - f @ s + s @ every @ s
        assert A @ left @ A.T == pytest.approx(f, abs=1e-9)


def test_an_error_that_is_not_there_changes_next_to_nothing() -> None:
    for _, normal, own in fits_with_trial_errors(20, 0.0):
        nothing = TrialRandomEffect(own.cross, own.fisher, 0.0 * own.score)
        same, white = cluster_covariance(normal, None, nothing), cluster_covariance(normal)
        assert same.cov == pytest.approx(white.cov)
        assert same.df == pytest.approx(white.df)


def test_scatter_of_scores_is_right_where_few_trials_hold_most_of_what_is_known():
    """Seven trials, white errors, two that tell ten times as much: 1 and the floor's 0.25 times.

    The jackknife finds half as much again.
    """
    rng = np.random.default_rng(8)
    size = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 3.0, 10.0])
    std_ratios = {cov_hc2: [], cov_jackknife: []}
    for _ in range(400):
        J = rng.normal(size=(7, 8, 3)) * size[:, None, None] ** 0.5
        e = rng.normal(size=(7, 8))
        H = np.einsum("tnp,tnq->tpq", J, J)
        fit = np.linalg.solve(H.sum(axis=0), np.einsum("tnp,tn->p", J, e))
        g = np.einsum("tnp,tn->tp", J, e - J @ fit)
        for cov, found in std_ratios.items():
            C = cov(NormalEquationsByTrial(H, g, np.zeros(7)), np.ones(3, dtype=bool))
            found.append(np.trace(H.sum(axis=0) @ C) / 3)
    assert np.mean(std_ratios[cov_hc2]) == pytest.approx(1.25, abs=0.08)
    assert np.mean(std_ratios[cov_jackknife]) > 1.5 * 1.25


def test_a_number_at_its_bound_widens_no_other():
    """Two numbers of nearly one effect: the second held at its bound, the first is known well."""
    rng = np.random.default_rng(5)
    one = np.array([[100.0, 99.9], [99.9, 100.0]])
    normal = NormalEquationsByTrial(
        np.repeat(one[None], 12, axis=0), rng.normal(0, 10, (12, 2)), np.zeros(12)
    )
    held = cov_jackknife(normal, np.array([True, False]))
    alone = NormalEquationsByTrial(
        normal.hessian[:, :1, :1], normal.gradient[:, :1], normal.log_likelihood
    )
    assert held[0, 0] == pytest.approx(cov_jackknife(alone)[0, 0])
    assert held[1].tolist() == [0.0, 0.0]


def test_the_variance_of_a_direction_that_one_trial_determines_is_finite():
    """Ten trials inform on the first parameter, one on the second: its score is almost nothing."""
    hessian = np.repeat(np.diag([10.0, 0.01])[None], 11, axis=0)
    hessian[4] = np.diag([10.0, 100.0])
    gradient = np.random.default_rng(3).normal(0, 10**0.5, (11, 2)) * [1.0, 0.1]
    gradient[:, 1] -= gradient[:, 1].mean()
    cov = cov_jackknife(NormalEquationsByTrial(hessian, gradient, np.zeros(11)))
    scores = np.abs(gradient[:, 1])
    left = np.array([max(1 - h / 100.1, MIN_INFORMATION_SHARE_LEFT) for h in hessian[:, 1, 1]])
    bound = np.sum((scores / left / 100.1) ** 2) + 0.25 / 100.1
    assert cov[1, 1] <= 1.01 * bound
    assert cov[0, 0] > 0.25 / 110


def test_with_equally_informative_trials_the_jackknife_is_the_usual_one():
    rng = np.random.default_rng(4)
    root = rng.normal(size=(20, 3, 5))
    hessian = root @ np.swapaxes(root, 1, 2)
    gradient = rng.normal(size=(20, 3))
    gradient -= gradient.mean(axis=0)
    ridge = RIDGE_SHARE * np.diag(np.diag(hessian.sum(axis=0)))
    rest = np.linalg.inv(hessian.sum(axis=0) + ridge - hessian)
    steps = np.einsum("tpq,tq->tp", rest, gradient)
    usual = 19 / 20 * steps.T @ steps + 0.25 * np.linalg.inv(hessian.sum(axis=0))
    assert cov_jackknife(NormalEquationsByTrial(hessian, gradient, np.zeros(20))) == pytest.approx(
        usual
    )
