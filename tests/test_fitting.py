"""Filter, noise and thinning against answers known otherwise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from bluekoi.fitting import (
    FreeParameter,
    Noise,
    NormalEquationsByTrial,
    TrialEffect,
    TrialSeries,
    block_averaged,
    estimate_noise_model,
    filter_all,
    filter_series,
    fit_parameters_jointly,
    trial_normal_equations,
)
from bluekoi.fitting.bootstrap import parametric_bootstrap
from bluekoi.fitting.bounded_step import bounded_step
from bluekoi.fitting.gram import add_whitened_column_products
from bluekoi.fitting.linear import linearised_filter, log_likelihood, log_likelihood_gradient
from bluekoi.fitting.trial_effects import sample_trial_effects
from bluekoi.integrate import Stage, compile_system
from mass_model import SYSTEM

STEP_S = 0.05
WHITE_STD = 0.004


def make_series(seen: np.ndarray, step_s: float = STEP_S) -> TrialSeries:
    n = len(seen)
    return TrialSeries(
        name="T", group="g", condition="c", times=step_s * np.arange(n), inputs=np.zeros((n, 1)),
        constants=np.zeros(0), seen=seen[:, None], noise=np.full((n, 1, 1), WHITE_STD**2),
        mean=np.zeros(4), cov=np.diag([0.01**2, 0.02**2, 0.0, 0.0]),
    )  # fmt: skip


def first_order_covariance(sigma: float, tau: float, times: np.ndarray) -> np.ndarray:
    """Covariance of a first-order process: sigma^2 exp(-|t - t'| / tau)."""
    return sigma**2 * np.exp(-np.abs(times[:, None] - times) / tau)


@pytest.mark.parametrize("step_s", [0.02, 0.1, 0.3])
def test_lasting_errors_have_the_exact_likelihood(step_s: float) -> None:
    rng = np.random.default_rng(1)
    kernel, values = compile_system(SYSTEM), SYSTEM.parameter_vector({"c": 0.0})
    times = step_s * np.arange(40)
    noise = Noise(np.array([0.0, 0.01]), np.array([0.3, 0.2]), np.ones(1))
    cov = first_order_covariance(0.01, 0.2, times) + WHITE_STD**2 * np.eye(40)
    cov += 0.01**2 + 0.02**2 * np.outer(times, times)
    seen = rng.multivariate_normal(np.zeros(40), cov)
    found = filter_series(kernel, make_series(seen, step_s), values, noise)
    exact = multivariate_normal(np.zeros(40), cov).logpdf(seen)
    assert found.log_likelihood == pytest.approx(exact, abs=0.02)


def test_whitened_errors_are_white() -> None:
    rng = np.random.default_rng(2)
    kernel, values = compile_system(SYSTEM), SYSTEM.parameter_vector({"c": 0.0})
    noise = Noise(np.array([0.0, 0.01]), np.array([0.3, 0.2]), np.ones(1))
    n = 4000
    root = np.linalg.cholesky(first_order_covariance(0.01, 0.2, STEP_S * np.arange(n)))
    seen = root @ rng.standard_normal(n) + WHITE_STD * rng.standard_normal(n)
    e = filter_series(kernel, make_series(seen), values, noise).innovations[:, 0]
    assert np.std(e) == pytest.approx(1, abs=0.03)
    assert abs(np.mean(e[1:] * e[:-1])) < 0.04


def test_fit_noise_finds_force_error_and_white_noise() -> None:
    rng = np.random.default_rng(3)
    kernel, values = compile_system(SYSTEM), SYSTEM.parameter_vector({"c": 0.5})
    n, true = 400, Noise(np.array([0.05, 0.012]), np.array([0.5, 0.15]), np.ones(1))
    trials = [make_series(_randomly_pushed(rng, n, true)) for _ in range(12)]
    first = Noise(np.array([0.15, 0.004]), np.array([0.5, 0.3]), np.full(1, 2.0))
    found = estimate_noise_model(kernel, trials, [values] * 12, first, rounds=20).noise

    def likelihood(noise: Noise) -> float:
        return sum(filter_series(kernel, t, values, noise).log_likelihood for t in trials)

    assert likelihood(found) > likelihood(true) - 0.5
    assert likelihood(found) < likelihood(true) + 10  # five numbers cannot gain more by chance
    strength, known = (n.disturbance * np.sqrt(n.tau) for n in (found, true))
    assert strength == pytest.approx(known, rel=0.25)
    assert found.scale == pytest.approx(true.scale, rel=0.15)


def four_times(x: float) -> tuple[float, float, float, float]:
    """The place, seen by four instruments."""
    return x, x, x, x


@pytest.mark.parametrize(("stated", "expected"), [((), [1.0, 1.0, 1.0, 3.0]),
                                                  ((3,), [1.0, 1.0, 1.0, 1.0])])  # fmt: skip
def test_the_noise_of_every_observation_is_estimated_but_where_it_is_stated(
    stated: tuple[int, ...], expected: list[float]
) -> None:
    """The deviation of the fourth instrument is stated three times too small."""
    names, rng, n = ("seen_1", "seen_2", "seen_3", "seen_4"), np.random.default_rng(8), 300
    stages = (*SYSTEM.stages[:2], Stage("observe", names, four_times, open=True))
    system = replace(SYSTEM, name="mass_seen_four_times", stages=stages, observations=names,
                     effects=SYSTEM.effects[:1])  # fmt: skip
    one = replace(
        make_series(np.zeros(n)), mean=np.zeros(3), cov=np.diag([0.01**2, 0.02**2, 0.0]),
        seen=WHITE_STD * rng.standard_normal((n, 4)) * [1.0, 1.0, 1.0, 3.0],
        noise=np.tile(WHITE_STD**2 * np.eye(4), (n, 1, 1)),
    )  # fmt: skip
    first = Noise(np.array([1e-3]), np.array([0.5]), np.ones(4), fixed_scales=stated)
    kernel = compile_system(system)
    found = estimate_noise_model(
        kernel, [one], [system.parameter_vector({})], first, rounds=20
    ).noise
    assert found.scale == pytest.approx(expected, rel=0.15)


def test_likelihood_around_a_path_is_that_of_a_new_pass() -> None:
    """The one-mass model is linear, so both agree but for steps of integration."""
    rng = np.random.default_rng(4)
    kernel, values = compile_system(SYSTEM), SYSTEM.parameter_vector({"c": 0.5})
    path = Noise(np.array([0.05, 0.012]), np.array([0.5, 0.15]), np.ones(1))
    trials = [make_series(_randomly_pushed(rng, 100, path)) for _ in range(3)]
    trials[1].seen[20:30] = np.nan
    trials[2] = replace(trials[2], force_size=1.7)
    linear = linearised_filter(kernel, trials, [values] * 3, path)

    def passed(noise: Noise) -> float:
        return sum(filter_series(kernel, t, values, noise).log_likelihood for t in trials)

    assert log_likelihood(linear, path) == pytest.approx(passed(path), abs=1e-4)
    for strengths, memories, scale in (([0.1, 0.012], [0.5, 0.15], 1.0),
                                       ([0.05, 0.006], [0.25, 0.15], 1.2),
                                       ([0.02, 0.02], [1.0, 0.3], 0.8)):  # fmt: skip
        other = Noise(np.array(strengths), np.array(memories), np.full(1, scale))
        assert log_likelihood(linear, other) == pytest.approx(passed(other), abs=0.3)
        assert abs(passed(other) - passed(path)) > 3


def test_the_force_size_of_a_trial_scales_its_random_forces_alone() -> None:
    rng = np.random.default_rng(4)
    kernel, values = compile_system(SYSTEM), SYSTEM.parameter_vector({"c": 0.5})
    force, error = 0.05, 0.012
    tau, scale = np.array([0.5, 0.15]), np.ones(1)
    trial = make_series(_randomly_pushed(rng, 100, Noise(np.array([force, error]), tau, scale)))
    larger = filter_series(
        kernel, replace(trial, force_size=2.0), values, Noise(np.array([force, error]), tau, scale)
    )
    stated = filter_series(kernel, trial, values, Noise(np.array([2 * force, error]), tau, scale))
    assert larger.log_likelihood == pytest.approx(stated.log_likelihood, rel=1e-12)
    noise = Noise(np.array([force, 0.0]), tau, scale)
    count, starts = 400, np.zeros((400, 4))
    still = replace(trial, noise=1e-12 * trial.noise)
    spreads = [
        np.std([one.seen[1:, 0] for one in parametric_bootstrap(
            kernel, [replace(still, force_size=size)] * count, [values] * count, [noise] * count,
            starts, np.random.default_rng(1))])
        for size in (1.0, 2.0)
    ]  # fmt: skip
    assert spreads[1] == pytest.approx(2 * spreads[0], rel=1e-6)


def test_slopes_of_the_likelihood_are_its_differences() -> None:
    rng = np.random.default_rng(14)
    kernel, values = compile_system(SYSTEM), SYSTEM.parameter_vector({"c": 0.5})
    path = Noise(np.array([0.05, 0.012]), np.array([0.5, 0.15]), np.ones(1))
    trials = [make_series(_randomly_pushed(rng, n, path)) for n in (60, 100, 80)]
    trials[1].seen[20:30] = np.nan
    trials[2] = replace(trials[2], force_size=1.7)
    linear = linearised_filter(kernel, trials, [values] * 3, path)
    numbers = np.array([0.07, 0.009, 0.4, 0.2, 1.2])

    def noise(x: np.ndarray) -> Noise:
        return Noise(x[:2], x[2:4], x[4:])

    found = log_likelihood_gradient(linear, noise(numbers))
    assert found.log_likelihood == pytest.approx(log_likelihood(linear, noise(numbers)), rel=1e-12)
    steps = 1e-5 * np.diag(numbers)
    differences = [log_likelihood(linear, noise(numbers + step))
                   - log_likelihood(linear, noise(numbers - step)) for step in steps]  # fmt: skip
    slopes = np.concatenate([found.disturbance, found.tau, found.scale])
    assert slopes == pytest.approx(np.array(differences) / (2e-5 * numbers), rel=1e-6)


def test_whitened_products_are_those_of_matrices() -> None:
    """A trial of one block and one of two, whose columns stand at places of their own."""
    rng = np.random.default_rng(15)
    observed, seen = rng.normal(size=(3, 90, 2, 16)), rng.normal(size=(2, 90, 2))
    roots = np.tril(rng.normal(size=(2, 90, 2, 2)))
    roots[0, 10:20] = 0.0
    places = np.zeros((2, 18), dtype=np.int64)
    places[0, 1:4], places[1, 1:18] = [2, 5, 19], np.arange(1, 18)
    frames, out = np.array([70, 90]), np.zeros((2, 20, 20))
    add_whitened_column_products(observed, seen, roots, frames, np.array([0, 1, 3]), places,
                          np.array([4, 18]), (0, 2), out)  # fmt: skip
    for t, blocks in enumerate((observed[:1], observed[1:])):
        n, count = frames[t], (4, 18)[t]
        change = np.concatenate([b[..., 1:] - b[..., :1] for b in blocks], axis=-1)
        columns = np.concatenate([(seen[t] - blocks[0, ..., 0])[..., None], change], axis=-1)
        J = (roots[t, :n] @ columns[:n, :, :count]).reshape(-1, count)
        expected = np.zeros((20, 20))
        expected[np.ix_(places[t, :count], places[t, :count])] = J.T @ J
        assert out[t] == pytest.approx(expected, abs=1e-10)


def test_what_is_plausible_beforehand_counts_once_for_all_trials() -> None:
    """Where no data bear on a number, a fit leaves it at its start with the stated spread."""
    known = replace(SYSTEM.coefficients[0], spread=0.2)
    system = replace(SYSTEM, coefficients=(known,))
    kernel = compile_system(system)
    unseen = [replace(make_series(np.full(20, np.nan)), name=str(k)) for k in range(5)]
    noise = Noise(np.array([0.05, 0.012]), np.array([0.5, 0.15]), np.ones(1))
    found = fit_parameters_jointly(
        kernel, unseen, system.parameter_vector({}), [FreeParameter("c")], noise, start={"c": 0.8}
    )
    assert found.values[0] == pytest.approx(known.start, abs=1e-3 * 0.2)
    assert found.naive_cov[0, 0] == pytest.approx(0.2**2, rel=1e-6)


def test_a_fit_takes_its_last_step_and_reports_its_gain() -> None:
    rng = np.random.default_rng(5)
    true = Noise(np.array([0.05, 0.0]), np.array([0.5, 0.15]), np.ones(1))
    kernel = compile_system(SYSTEM)
    trials = [replace(make_series(_randomly_pushed(rng, 200, true)), name=str(k)) for k in range(6)]
    base, free = SYSTEM.parameter_vector({}), [FreeParameter("c")]
    held = filter_all(kernel, trials, [base] * 6, true)
    exact = fit_parameters_jointly(kernel, trials, base, free, true, tolerance=1e-6, predictor=held)
    std = exact.naive_cov[0, 0] ** 0.5
    near = {"c": float(exact.values[0]) + 0.3 * std}
    rough = fit_parameters_jointly(
        kernel, trials, base, free, true, start=near, tolerance=0.5, predictor=held
    )
    assert rough.iterations == 1
    assert rough.values[0] == pytest.approx(exact.values[0], abs=0.02 * std)
    assert rough.log_likelihood == pytest.approx(exact.log_likelihood, abs=0.01)
    assert abs(rough.normal.gradient.sum()) < 0.02 / std


def test_the_slope_of_the_likelihood_holds_where_trials_differ_widely() -> None:
    """Linearised about the trials' common value, it had the wrong sign near the optimum."""
    rng = np.random.default_rng(6)
    noise = Noise(np.array([0.05, 0.0]), np.array([0.5, 0.15]), np.ones(1),
                  trial_effects=(TrialEffect("c", 0.1),))  # fmt: skip
    kernel, base = compile_system(SYSTEM), SYSTEM.parameter_vector({})
    trials = [replace(make_series(_randomly_pushed(rng, 100, noise, drag)), name=str(k))
              for k, drag in enumerate([0.1, 0.3, 0.6, 1.5])]  # fmt: skip
    held = filter_all(kernel, trials, [base] * 4, noise)

    def at(c: float) -> NormalEquationsByTrial:
        return trial_normal_equations(
            kernel, trials, base, [FreeParameter("c")], np.array([c]), noise=noise, predictor=held
        )

    difference = at(0.501).log_likelihood - at(0.499).log_likelihood
    found = at(0.5)
    assert np.abs(found.effects.values).max() > 0.02
    assert found.gradient[:, 0] == pytest.approx(difference / 0.002, rel=0.02, abs=0.02)


@pytest.mark.parametrize("radius", [np.inf, 0.3])
@given(seed=st.integers(0, 2**32 - 1))
@example(seed=104034031)  # a number returns from its bound
def test_a_bounded_step_is_the_best_within_its_bounds(radius: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    p = int(rng.integers(1, 8))
    J, g = rng.normal(size=(p + 3, p)) * np.exp(rng.normal(size=p)), 5 * rng.normal(size=p)
    H = J.T @ J
    lower, upper = -rng.exponential(size=p), rng.exponential(size=p)
    lower[rng.random(p) < 0.3] = 0.0
    step = bounded_step(H, g, lower, upper, radius)
    limits = radius / np.sqrt(np.diag(H))
    least, most = np.maximum(lower, -limits), np.minimum(upper, limits)
    assert np.all((step >= least - 1e-12) & (step <= most + 1e-12))
    slope = g - H @ step
    free = (step > least + 1e-9) & (step < most - 1e-9)
    size = np.abs(g) + np.abs(H) @ np.abs(step) + 1e-9
    assert np.all(np.abs(slope[free]) < 1e-5 * size[free])
    assert np.all(slope[step <= least + 1e-9] < 1e-5 * size[step <= least + 1e-9])
    assert np.all(slope[step >= most - 1e-9] > -1e-5 * size[step >= most - 1e-9])


def test_numbers_without_information_stay() -> None:
    H, g = np.diag([4.0, 0.0]), np.array([2.0, 0.0])
    step = bounded_step(H, g, np.full(2, -1.0), np.full(2, 1.0))
    assert step == pytest.approx([0.5, 0.0])


def _randomly_pushed(
    rng: np.random.Generator, n: int, noise: Noise, drag: float = 0.5
) -> np.ndarray:
    fine = 10
    dt = STEP_S / fine
    keep = np.exp(-dt / noise.tau)
    g, e = noise.disturbance * rng.standard_normal(2)
    x, v, seen = 0.0, 0.0, np.empty(n)
    for k in range(n):
        seen[k] = x + e + WHITE_STD * rng.standard_normal()
        for _ in range(fine):
            x, v = x + dt * v, v + dt * (g - drag * v)
            g, e = keep * np.array([g, e]) + noise.disturbance * np.sqrt(
                1 - keep**2
            ) * rng.standard_normal(2)
    return seen


def test_block_averaging_does_not_bias_a_curve() -> None:
    times = np.arange(0, 6, 1 / 30)
    one = replace(make_series(0.2 * times**2, 1 / 30))
    few = block_averaged(one)
    assert 55 < len(few.times) < 65
    assert few.seen[:, 0] == pytest.approx(0.2 * few.times**2, abs=1e-12)
    assert few.times[0] == 0
    assert few.noise[1:-1, 0, 0] == pytest.approx(WHITE_STD**2 / 3)


def test_no_block_reaches_over_frames_that_are_absent() -> None:
    """Six rows missing: a block over them lay 2 mm off its curve, as if displaced."""
    times = np.delete(np.arange(0, 6, 1 / 30), range(60, 66))
    one = replace(make_series(0.2 * times**2, 1 / 30), times=times)
    few = block_averaged(one)
    assert few.seen[:, 0] == pytest.approx(0.2 * few.times**2, abs=3e-4)
    assert not np.any((few.times > times[59] + 1e-9) & (few.times < times[60] - 1e-9))


def test_thinning_keeps_gaps_and_spreads_what_is_constant() -> None:
    seen = np.ones(180)
    seen[60:75] = np.nan
    one = make_series(seen, 1 / 30)
    few = block_averaged(one, constant=(0,))
    assert np.isnan(few.seen[:, 0]).sum() in (4, 5)
    assert np.sum(1 / few.noise[:, 0, 0]) == pytest.approx(np.sum(1 / one.noise[:, 0, 0]))


def test_a_constant_observation_is_as_certain_with_the_first_frame_unseen() -> None:
    seen = np.ones(180)
    seen[0] = np.nan
    one = make_series(seen, 1 / 30)
    one.noise[0] = np.eye(1)
    few = block_averaged(one, constant=(0,))
    assert few.noise[-1, 0, 0] == pytest.approx(one.noise[-1, 0, 0] * len(few.times) / 180)


def test_thinning_leaves_slow_series_alone() -> None:
    one = make_series(np.ones(100), 0.1)
    assert block_averaged(one) is one


def test_noise_must_be_positive() -> None:
    with pytest.raises(ValueError, match="positive"):
        Noise(np.array([0.1]), np.array([0.5]), np.zeros(1))


def test_drawn_trial_effects_are_those_of_fitted_trials_and_one_for_each_trial() -> None:
    known, rng = np.array([[0.1, 1.0], [-0.2, 2.0], [0.3, 3.0]]), np.random.default_rng(2)
    drawn = sample_trial_effects(known, ["A", "A", "B"] * 50, rng)
    assert {tuple(row) for row in drawn} <= {tuple(row) for row in known}
    assert len({tuple(row) for row in drawn[0::3]}) == 1
    assert np.array_equal(drawn[0::3], drawn[1::3])
    many = sample_trial_effects(known, [f"T{i}" for i in range(60)], rng)
    assert len({tuple(row) for row in many}) == len(known)
