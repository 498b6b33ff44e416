"""The search on recordings of others: bars that were reached, figures from docs/recordings.md."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi.fitting import Series

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
engine = import_module("examples.engine")
yaw = import_module("examples.yaw_coastdown.__main__")
yaw_reading = import_module("examples.yaw_coastdown.reading")
balls = import_module("examples.ball_drops.__main__")
balls_errors = import_module("examples.ball_drops.errors")
balls_reading = import_module("examples.ball_drops.reading")
fish = import_module("examples.robotic_fish.__main__")
fish_errors = import_module("examples.robotic_fish.errors")
fish_reading = import_module("examples.robotic_fish.reading")
pendulum = import_module("examples.pendulum.__main__")
pool_edge = import_module("examples.fish_robot_pool.edge")
pool_reading = import_module("examples.fish_robot_pool.reading")
pendulum_laws = import_module("examples.pendulum.laws")
pendulum_reading = import_module("examples.pendulum.reading")
ship = import_module("examples.ship_zigzag.__main__")
ship_reading = import_module("examples.ship_zigzag.reading")

pytestmark = pytest.mark.recordings


@pytest.fixture(scope="module")
def spindowns(recordings) -> tuple[Series, ...]:
    return yaw_reading.read_folder(recordings / "yaw_coastdown")


@pytest.fixture(scope="module")
def swings(recordings) -> Series:
    return pendulum_reading.read_folder(recordings / "pendulum")


def test_the_compass_says_that_the_gyro_reads_beside_zero(spindowns):
    beyond = np.array([one.evidence["compass"][0] for one in spindowns])
    assert np.mean(beyond) == pytest.approx(-0.017, abs=0.003)
    assert np.all(beyond < 0)


def test_a_spindown_is_foretold_from_the_others_to_a_hundredth(spindowns):
    given = yaw.withheld(spindowns, "linear_yaw_damping")
    effects = ("quadratic_yaw_damping", "gyro_bias")
    assert yaw.error_rad_s(given, spindowns, effects) <= 0.010


def test_the_pendulums_friction_and_its_recorded_rate_are_found_by_stretches(swings):
    outcome = engine.investigate(pendulum.searched(swings))
    assert set(outcome.chosen.effects) == {"viscous_friction", "rate_scale"}
    assert outcome.chosen.fit.by_label()["rate_scale.k"] == pytest.approx(-0.044, abs=0.006)


def test_over_the_whole_run_the_pendulums_friction_is_viscous(swings):
    names = ("viscous", "Coulomb", "quadratic")
    laws = [pendulum_laws.law(swings, (*pendulum.MEASURED, *pendulum.FRICTIONS[n])) for n in names]
    assert laws[0].rms[0] < 0.0118  # published for viscous friction
    assert pendulum_laws.weights(laws)[0] > 0.95
    assert np.all(laws[0].worth > laws[1].worth)


@pytest.fixture(scope="module")
def falls(recordings):
    return balls_reading.read_folder(recordings / "ball_drops")


@pytest.fixture(scope="module")
def fallen(falls):
    given = balls.together(falls)
    return given, engine.investigate(given)


def test_balls_are_held_back_by_the_drag_of_spheres_and_seen_from_below(fallen):
    _, outcome = fallen
    assert outcome.chosen.effects == ("air_drag", "perspective")
    assert all(outcome.weights(name)[name] > 0.95 for name in outcome.chosen.effects)
    assert 0.25 < outcome.chosen.fit.by_label()["air_drag.C"] < 0.5


def test_falls_after_two_seconds_err_by_what_is_expected(fallen, falls):
    given, outcome = fallen
    errors, expected, better = [], [], 0
    for name, drops in falls.items():
        model = balls_errors.others(given, outcome.chosen.effects, outcome.chosen, name)
        rest = balls_errors.rest_of_fall(given, model, drops[0])
        errors.append(rest.mean_square)
        expected.append(rest.expected)
        better += rest.mean_square < balls_errors.PUBLISHED_M2[name]
    assert better >= 7  # the bar is 9: docs/recordings.md says why it is not reached
    assert 0.3 < np.mean(np.array(errors) / expected) < 3.0


def test_every_command_of_the_fish_robot_is_slower_at_the_edge(recordings):
    runs = pool_reading.read_folder(recordings / "fish_robot_pool")
    ratios = [ratio for ratio, _, _ in pool_edge.near_over_far(runs).values()]
    assert len(ratios) == 6
    assert max(ratios) < 1.0
    assert 0.75 < np.median(ratios) < 0.95


def test_the_balls_command_tells_what_it_found(recordings):
    result = CliRunner().invoke(balls.main, [str(recordings / "ball_drops")])
    assert result.exit_code == 0, result.output
    assert "`air_drag`" in result.output
    assert "share foretold" in result.output


def test_the_ship_lacks_its_loss_of_speed_and_is_foretold_a_minute_ahead(recordings):
    trials = ship_reading.read_folder(recordings / "ship_zigzag")
    given = engine.case(ship.SYSTEM, trials, ship_reading.FIRST_NOISE)
    outcome = engine.searched_on(given, engine.investigate(given))
    laws = {"speed_loss", "slipstream", "rudder_drag", "crossflow_drag", "drift_and_turn"}
    assert laws <= set(outcome.chosen.effects)
    assert all(outcome.weights(name)[name] > 0.95 for name in laws)
    ahead = [f.path_rms for one in ship.left_out(given, outcome.chosen) for f in one.minutes]
    assert ship.rms(ahead) < 2.5  # 5.1 by the linear ship
