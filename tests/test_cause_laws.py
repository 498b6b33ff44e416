"""The law of a cause is its own force over the variable that describes it, with its band."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.fitting import FreeParameter, missing_force
from bluekoi.integrate import compile_system
from bluekoi.mismatch.laws import (
    PARTS_PER_TRIAL,
    VARIABLES_OF_EFFECT,
    cause_force_curves,
    equal_count_bins,
    partial_residuals,
)
from bluekoi.model import HYDRODYNAMIC_COEFFICIENTS, two_plate_system
from bluekoi.study import Trial
from bluekoi.tuning import downsampled, fit_all_trials
from simulated_campaigns import ErrorModel, simulate_campaigns
from simulated_campaigns import trial_plans as plans_of

N_R = 0.02


@pytest.fixture(scope="module")
def damped_model():
    """Trials of the bare model; a model with a damping N_r = 0.02 +- 0.001 N m s put into it."""
    wanted = plans_of((100,), ((0.0, 0.12), (30.0, 0.12), (-45.0, 0.12)))
    series = downsampled(
        simulate_campaigns(wanted, ErrorModel(), np.random.default_rng(3), count=1)[0]
    )
    free = (
        *(FreeParameter(p.name) for p in HYDRODYNAMIC_COEFFICIENTS),
        FreeParameter("linear_yaw_damping.N_r"),
    )
    found = fit_all_trials(series, free)
    values, cov = found.fit.values.copy(), np.zeros((7, 7))
    values[-1], cov[-1, -1] = N_R, 0.001**2
    found = replace(found, fit=replace(found.fit, values=values), cov=cov, df=None)
    kernel = compile_system(two_plate_system())
    forces = missing_force(
        kernel, series, found.parameter_vectors_by_trial(kernel, series), found.noise
    )
    trials = {p.name: Trial(trial_id=p.name, source="a.csv", power_pct=100, fps=30.0,
                            head_angle_deg=p.angle_deg, head_length_m=p.head_length_m)
              for p in wanted}  # fmt: skip
    return kernel, series, forces, found, trials


@pytest.fixture(scope="module")
def damping_laws(damped_model):
    return cause_force_curves(*damped_model)


def test_a_damping_is_a_moment_against_the_yaw_rate_with_the_band_of_its_number(damping_laws):
    law = damping_laws["linear_yaw_damping"]
    assert (law["channel"], law["y_unit"]) == ("yaw", "N m")
    assert law["variable"] == "yaw_rate_rad_s"
    assert law["explained"] > 0.95
    assert law["y"] == pytest.approx(-N_R * law["x"], rel=0.05, abs=1e-4)
    half = 0.5 * (law["high"] - law["low"])
    fast = np.abs(law["x"]) > 0.5
    assert half[fast] == pytest.approx(1.96 * 0.001 * np.abs(law["x"][fast]), rel=0.1)


def test_a_law_is_drawn_in_a_channel_that_its_effect_names(damped_model):
    """Where hardly any random force acts in surge, the fin's small drag looks large there."""
    kernel, series, forces, found, trials = damped_model
    free = (*found.fit.free[:-1], FreeParameter("tail_fin_lift.lift_area"))
    values, disturbance = found.fit.values.copy(), found.noise.disturbance.copy()
    base = found.base.copy()
    values[-1], disturbance[0] = 0.02, 1e-6
    base[kernel.system.parameter_index["tail_fin_lift.axial_share"]] = 1.0
    fin = replace(found, base=base, fit=replace(found.fit, free=free, values=values),
                  noise=replace(found.noise, disturbance=disturbance))  # fmt: skip
    law = cause_force_curves(kernel, series, forces, fin, trials)["tail_fin_lift"]
    assert law["channel"] in kernel.system.effect("tail_fin_lift").channels == ("sway", "yaw")


def test_partial_residuals_of_a_damping_that_the_trials_do_not_have_show_none(
    damped_model, damping_laws
):
    _, series, _, found, _ = damped_model
    loose = replace(found.noise, disturbance=10 * found.noise.disturbance)
    points = partial_residuals(*damped_model, laws=damping_laws, noise=loose)["linear_yaw_damping"]
    assert points.keys() == {one.name for one in series}
    assert {len(one["x"]) for one in points.values()} == {PARTS_PER_TRIAL}
    # At the ends of a trial the smoother knows less and draws forces to zero.
    x, y = (np.concatenate([one[k][2:-2] for one in points.values()]) for k in "xy")
    own = np.concatenate([one["cause_force"][2:-2] for one in points.values()])
    assert own == pytest.approx(-N_R * x, rel=0.005)
    turning = np.abs(x) > 0.5
    assert turning.sum() == 2 * (PARTS_PER_TRIAL - 4)
    assert np.abs(y[turning]).max() < 0.3 * N_R * np.abs(x[turning]).min()


def test_variables_of_effects_are_known_or_none():
    effects = two_plate_system().effects
    names = {v for e in effects if e.kind == "physics" for v in e.variables}
    assert names - set(VARIABLES_OF_EFFECT) == {"current"}
    residual = {v for e in effects if e.kind == "residual" for v in e.variables}
    assert residual - set(VARIABLES_OF_EFFECT) == {"heading"}


def test_bins_have_about_equal_counts_and_a_constant_has_none():
    x = np.random.default_rng(0).normal(size=300)
    found = equal_count_bins(x)
    assert np.bincount(found.index).tolist() == 15 * [20]
    assert found.means(x) == pytest.approx(found.x)
    few = equal_count_bins(np.repeat([0.12, 0.18], 20))
    assert few.x == pytest.approx([0.12, 0.18])
    assert equal_count_bins(np.zeros(50)) is None
