"""Intervals from how trials disagree: they hold the truth as often as they say."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.fitting import Normal, jackknife_cov, spread_over_trials

TRUTH = np.array([1.0, -0.5, 0.3])
FRAMES, MEMORY = 30, 8.0


def fitted(trials: int, rng: np.random.Generator) -> tuple[np.ndarray, Normal]:
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
    return values, Normal(H, g, np.zeros(trials))


def shares(trials: int, count: int = 800) -> dict[str, np.ndarray]:
    """Share of the intervals that hold the truth, by way and number."""
    rng = np.random.default_rng(trials)
    inside: dict[str, list[np.ndarray]] = {"disagreement": [], "jackknife": [], "naive": []}
    for _ in range(count):
        values, normal = fitted(trials, rng)
        off = np.abs(values - TRUTH)
        inside["disagreement"].append(off <= spread_over_trials(normal).half_widths())
        inside["jackknife"].append(off <= 1.96 * np.sqrt(np.diag(jackknife_cov(normal))))
        naive = np.linalg.inv(normal.hessian.sum(axis=0))
        inside["naive"].append(off <= 1.96 * np.sqrt(np.diag(naive)))
    return {name: np.mean(rows, axis=0) for name, rows in inside.items()}


@pytest.mark.parametrize("trials", [6, 12, 40])
def test_95_percent_intervals_hold_the_truth_95_times_in_100(trials: int) -> None:
    found = shares(trials)
    assert np.all(np.abs(found["disagreement"] - 0.95) < 0.03), found
    assert np.all(found["naive"] < 0.85), "errors that last make the naive intervals too short"


def test_degrees_of_freedom_tell_how_many_trials_speak() -> None:
    """One number that two trials of ten inform, one that all do."""
    rng = np.random.default_rng(4)
    X = rng.standard_normal((10, FRAMES, 2))
    X[2:, :, 0] = 0.0
    H = np.einsum("tnp,tnq->tpq", X, X)
    e = rng.standard_normal((10, FRAMES))
    shift = np.linalg.solve(H.sum(axis=0), np.einsum("tnp,tn->p", X, e))
    g = np.einsum("tnp,tn->tp", X, e - X @ shift)
    freedom = spread_over_trials(Normal(H, g, np.zeros(10))).freedom
    assert freedom[0] == pytest.approx(1.0, abs=0.3)
    assert 6 < freedom[1] < 9.5


def test_numbers_at_a_bound_have_no_variance_and_do_not_disturb_the_others() -> None:
    values, normal = fitted(12, np.random.default_rng(1))
    moving = np.array([True, False, True])
    spread = spread_over_trials(normal, moving)
    alone = spread_over_trials(
        Normal(normal.hessian[:, moving][:, :, moving], normal.gradient[:, moving], np.zeros(12))
    )
    assert np.all(spread.cov[1] == 0)
    assert spread.freedom[1] == 0
    assert spread.cov[np.ix_(moving, moving)] == pytest.approx(alone.cov)
    assert len(values) == 3


def test_one_trial_falls_back_on_what_it_says_of_itself() -> None:
    _, normal = fitted(12, np.random.default_rng(2))
    one = Normal(normal.hessian[:1], normal.gradient[:1], np.zeros(1))
    assert spread_over_trials(one).cov == pytest.approx(np.linalg.inv(one.hessian[0]), rel=1e-6)
