"""What the recordings' examples share: forecasts with their deviations, side measurements."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi.fitting import Free, Noise, Series, normal_equations
from bluekoi.integrate import compiled
from one_mass import SYSTEM

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
forecasting = import_module("examples.forecasting")
yaw = import_module("examples.yaw_coastdown.model")

WHITE, LASTING, START_V = 0.01, 0.05, 0.3
NOISE = Noise(np.array([0.0, LASTING]), np.array([0.3, 0.5]), np.ones(1))


def slowing(rng: np.random.Generator) -> Series:
    """x' = v, v' = -0.5 v from a speed not known well, seen with errors that last."""
    times = 0.05 * np.arange(60)
    cov = LASTING**2 * np.exp(-np.abs(times[:, None] - times) / 0.5) + WHITE**2 * np.eye(60)
    v = 1.0 + START_V * rng.standard_normal()
    seen = 2.0 * v * (1.0 - np.exp(-0.5 * times)) + rng.multivariate_normal(np.zeros(60), cov)
    return Series(
        name="T", group="g", condition="c", times=times, inputs=np.zeros((60, 1)),
        constants=np.zeros(0), seen=seen[:, None], noise=np.full((60, 1, 1), WHITE**2),
        mean=np.array([0.0, 1.0, 0.0, 0.0]), cov=np.diag([1e-9, START_V, 1e-9, LASTING]) ** 2,
    )  # fmt: skip


def test_forecasts_err_by_what_they_state():
    rng = np.random.default_rng(4)
    kernel, values = compiled(SYSTEM), SYSTEM.values({"c": 0.5})
    told = [forecasting.forecast(kernel, slowing(rng), values, NOISE, 1.0) for _ in range(200)]
    last = [((f.seen - f.foretold) / np.hypot(f.std, WHITE))[-1, 0] for f in told]
    assert np.std(last) == pytest.approx(1.0, abs=0.15)
    assert abs(np.mean(last)) < 0.2
    errors = np.mean([f.mean_square for f in told])
    assert errors == pytest.approx(np.mean([f.expected for f in told]) + WHITE**2, rel=0.25)


def test_a_forecast_takes_nothing_from_what_comes_after():
    one = slowing(np.random.default_rng(5))
    kernel, values = compiled(SYSTEM), SYSTEM.values({"c": 0.5})
    later = Series(**(one.__dict__ | {"seen": np.where(one.times[:, None] > 1.0, 9.0, one.seen)}))
    a, b = (forecasting.forecast(kernel, s, values, NOISE, 1.0) for s in (one, later))
    assert np.array_equal(a.foretold, b.foretold)


def test_a_side_measurement_moves_the_number_of_its_own_group_alone():
    kernel = compiled(yaw.SYSTEM)
    n = 20
    trials = [
        Series(
            name=g, group=g, condition=g, times=0.1 * np.arange(n), inputs=np.zeros((n, 0)),
            constants=np.array([5.0]), seen=np.zeros((n, 1)), noise=np.full((n, 1, 1), 1e6),
            mean=np.zeros(3), cov=1e-6 * np.eye(3), evidence={"compass": (value, 0.01)},
        )
        for g, value in (("a", 0.02), ("b", -0.05))
    ]  # fmt: skip
    free = [Free("gyro_bias.b", "a"), Free("gyro_bias.b", "b")]
    noise = Noise(np.zeros(2), np.ones(2), np.ones(1))
    normal = normal_equations(kernel, trials, yaw.SYSTEM.values({}), free, np.zeros(2), noise=noise)
    step = np.linalg.solve(normal.hessian.sum(axis=0), normal.gradient.sum(axis=0))
    assert step == pytest.approx([0.02, -0.05], rel=1e-3)


def test_a_missing_folder_is_told_in_one_line():
    command = import_module("examples.pendulum.__main__").main
    result = CliRunner().invoke(command, ["nowhere"])
    assert result.exit_code == 1
    assert "expected the pendulum's recording" in result.output
    assert "Traceback" not in result.output


def test_near_and_far_from_the_edge_are_compared_without_lost_light():
    edge = import_module("examples.fish_robot_pool.edge")
    reading = import_module("examples.fish_robot_pool.reading")
    times = np.arange(0.0, 20.0, 1 / 16)
    x = np.where(times < 10.0, 1.0 + 0.1 * times, 2.0 + 0.2 * (times - 10.0))
    y = np.interp(times, [9.0, 11.0], [0.05, 0.5])
    places = np.column_stack([x, y])
    run = reading.Run("r", "c", 1.0, times, places, 0, 0.0)
    ratio, near, far = edge.near_over_far([run])["c"]
    assert ratio == pytest.approx(0.5, abs=0.06)  # a beat crosses over
    kept = (times < 4.0) | (times > 6.0)
    lost = edge.beats(reading.Run("r", "c", 1.0, times[kept], places[kept], 0, 2.0))
    assert 1 <= lost.gaps.sum() <= 4
    assert near > 5 < far
