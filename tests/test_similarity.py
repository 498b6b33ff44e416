"""Similar robots: parameters, effects and fits of a robot of another size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.fitting import TrialSeries
from bluekoi.integrate import LANES, Effect, System, compile_system
from bluekoi.integrate.batch import repeat_over_lanes, simulate_batch
from bluekoi.model import (
    TABLE_1,
    RobotScaleRatios,
    constants_of_robot_trial,
    two_plate_system,
)
from bluekoi.model.similarity import robot_scale_ratios, unit_dimensions
from bluekoi.observation import CameraErrorInputs
from bluekoi.tuning import fit_all_trials
from paper_robot import PAPER_SETUP
from simulated_campaigns import ErrorModel, simulate_campaigns, trial_plans

LARGE = RobotScaleRatios(mass=20.0, length=2.56, time=1.6)
CONSTANT_UNITS = dict.fromkeys(
    ("l", "h", "span", "length", "x_hinge", "x_tail", "l_tail", "L_pool", "W_pool", "x_cam",
     "y_cam", "x_lens", "y_lens", "ahead", "length_unit"), "m",
) | {
    "rho": "kg/m3", "A": "m2", "A_ref": "m2", "m": "kg", "I": "kg m2", "t_start": "s",
    "bend": "1/m2", "Q_lens": "m2", "ax_lens": "m3", "ay_lens": "m3", "t_shift": "s",
    "speed_unit": "m/s", "time_unit": "s",
}  # fmt: skip
"""Units of the constants of a trial; the others are numbers."""
STATE_UNITS = ("m", "m", "rad", "m/s", "m/s", "rad/s")


@pytest.mark.parametrize(
    ("unit", "expected"),
    [("1", (0, 0, 0)), ("kg m2", (1, 2, 0)), ("N", (1, 1, -2)), ("N s2/m", (1, 0, 0)),
     ("1/m2", (0, -2, 0)), ("rad/s", (0, 0, -1)), ("N m/s", (1, 2, -3)),
     ("N (s/m)^1.5", (1, -0.5, -0.5)), ("N (s/m)^4", (1, -3, 2)), ("N s3/m3", (1, -2, 1))],
)  # fmt: skip
def test_dimensions_of_a_unit(unit: str, expected: tuple[float, ...]) -> None:
    assert unit_dimensions(unit) == pytest.approx(expected)


def test_unknown_unit_is_an_error() -> None:
    with pytest.raises(KeyError):
        unit_dimensions("furlong")


def trial_constants() -> np.ndarray:
    """A trial of the paper's robot seen by a camera with every error of its view."""
    view = CameraErrorInputs(1.2, 0.7, 0.05, 0.1, -0.1, 0.3, 0.02, 0.01, 2.0, 0.9, 0.1, 0.03, 1.0)
    return constants_of_robot_trial(PAPER_SETUP, 0.175, heading_rad=0.3, start_s=0.4, view=view)


def similar_constants(constants: np.ndarray, units: RobotScaleRatios) -> np.ndarray:
    names = two_plate_system().constants
    return constants * [units.scale_ratio_for_unit(CONSTANT_UNITS.get(name, "1")) for name in names]


def observed_path(system: System, effect: Effect, units: RobotScaleRatios) -> np.ndarray:
    """What is seen of a turn with one effect at its starting values, in units of the robot."""
    values = system.parameter_vector(
        {name: value * units.scale_ratio_for_unit(unit) for (name, value), unit in
         zip(TABLE_1[75].items(), ("m2", "1", "1", "1", "m", "kg m2"), strict=True)},
        {effect.name: {p.name: p.start for p in effect.parameters}},
    )  # fmt: skip
    state = np.zeros((1, len(system.all_states), LANES))
    state[0, :2] = (units.length * np.array([1.1, 0.6]))[:, None]
    times = units.time * np.linspace(0.0, 6.0, 61)
    inputs = np.tile([0.6, 4.0 / units.time], (1, len(times), 1))
    constants = similar_constants(trial_constants(), units)
    seen, _ = simulate_batch(
        compile_system(system), state, *(repeat_over_lanes(v[None]) for v in (values, constants)),
        times=times[None], inputs=inputs,
    )  # fmt: skip
    return seen[0, :, :, 0] / [units.length, units.length, 1.0, 1.0]


@pytest.mark.parametrize("name", [e.name for e in two_plate_system().effects])
def test_every_effect_moves_a_similar_robot_along_a_similar_path(name: str) -> None:
    small, large = two_plate_system(), two_plate_system(LARGE)
    of_small = observed_path(small, small.effect(name), RobotScaleRatios())
    of_large = observed_path(large, large.effect(name), LARGE)
    assert np.ptp(of_small[:, 0]) > 0.1
    assert of_large == pytest.approx(of_small, abs=1e-7)


def similar_series(one: TrialSeries, units: RobotScaleRatios) -> TrialSeries:
    """A trial of a similar robot."""
    seen = np.array([units.length, units.length, 1.0, 1.0])
    state = np.ones(len(one.mean))
    state[:6] = [units.scale_ratio_for_unit(unit) for unit in STATE_UNITS]
    return replace(
        one, times=one.times * units.time, inputs=one.inputs / [1.0, units.time],
        constants=similar_constants(one.constants, units), seen=one.seen * seen,
        noise=one.noise * np.outer(seen, seen), mean=one.mean * state,
        cov=one.cov * np.outer(state, state),
    )  # fmt: skip


def test_a_fit_to_trials_of_a_similar_robot_gives_similar_coefficients() -> None:
    """All of it: starts, bounds, noise, steps; C_Md 24 times larger is within its bounds."""
    plans = trial_plans((75, 100))
    series = simulate_campaigns(plans, ErrorModel(), np.random.default_rng(3), count=1)[0]
    small = fit_all_trials(series)
    large = fit_all_trials([similar_series(s, LARGE) for s in series])
    size = np.array([LARGE.scale_ratio_for_unit(p.unit) for p in small.fit.definitions])
    assert [p.upper for p in large.fit.definitions] == pytest.approx(
        size * [p.upper for p in small.fit.definitions]
    )
    assert large.fit.values == pytest.approx(size * small.fit.values, rel=1e-4)
    assert large.std == pytest.approx(size * small.std, rel=1e-2)
    assert large.noise.tau == pytest.approx(LARGE.time * small.noise.tau, rel=1e-2)


def test_units_of_the_published_robot_are_one() -> None:
    assert robot_scale_ratios(PAPER_SETUP.robot) == RobotScaleRatios()
    assert two_plate_system(RobotScaleRatios()) is two_plate_system(RobotScaleRatios())
