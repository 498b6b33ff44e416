"""The paper's nine radii and three speeds (Tables I and II), and one coefficient set for all."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.design_space import steady_states
from bluekoi.model import PUBLISHED_FLAP_HZ, TABLE_1, two_plate_system
from bluekoi.tuning import straight_swimming_growth_per_s
from paper_robot import PAPER_SETUP
from published_radii import (
    POWERS_PCT,
    TURN_CONDITIONS,
    fit_one_coefficient_set,
    plausible_geometries,
    published_radii_and_speeds,
    turn_and_straight_conditions,
)

FIN_PARAMETERS = {"tail_fin_lift": {"lift_area": 0.012, "arm": 0.15}}


@pytest.fixture(scope="module")
def published():
    return published_radii_and_speeds(PAPER_SETUP)


def test_radii_and_speeds_rebuilt_from_tables_1_and_2(published) -> None:
    assert published.speeds_m_s == pytest.approx([0.225, 0.381, 0.552], abs=0.001)
    assert np.all((published.radii_m > 0.3) & (published.radii_m < 1.2))
    assert np.all(np.diff(published.radii_m, axis=0) < 0), "radius falls with power in every turn"
    thirty, tight = published.radii_m[:, 1], published.radii_m[:, 0]
    assert np.all(thirty > tight)


def test_one_set_makes_the_radius_independent_of_power() -> None:
    values = two_plate_system().parameter_vector(TABLE_1[75])[None]
    radii = steady_states(turn_and_straight_conditions(PAPER_SETUP)[:9], values).radius_m.reshape(
        3, 3
    )
    assert np.ptp(radii, axis=0) / radii.mean(axis=0) == pytest.approx([0, 0, 0], abs=1e-3)


def test_one_set_misses_by_more_than_a_tenth(published) -> None:
    """No coefficients whatever can follow radii that change with power: mean and spread by turn."""
    best = fit_one_coefficient_set(published, PAPER_SETUP)
    assert best.speeds_m_s == pytest.approx(published.speeds_m_s, rel=0.02)
    floor = 100 * np.sqrt(
        np.mean((published.radii_m / _best_common_radius(published.radii_m) - 1) ** 2)
    )
    assert best.misfit_pct >= 0.98 * floor
    assert 9 < best.misfit_pct < 18


def _best_common_radius(radii: np.ndarray) -> np.ndarray:
    """For each turn the one radius with the least squared relative error over the powers."""
    return np.sum(1 / radii, axis=0) / np.sum(1 / radii**2, axis=0)


def test_one_effect_of_another_power_of_speed_removes_much_of_it(published) -> None:
    alone, with_it = (
        fit_one_coefficient_set(published, PAPER_SETUP),
        fit_one_coefficient_set(published, PAPER_SETUP, "linear_yaw_damping"),
    )
    assert with_it.misfit_pct < 0.6 * alone.misfit_pct
    assert with_it.speeds_m_s == pytest.approx(published.speeds_m_s, rel=0.01)


@pytest.mark.parametrize("effect", ["tail_fin_lift", "crossflow_drag", "thrust_loss_with_speed"])
def test_effects_that_are_quadratic_too_remove_nothing_of_the_dependence_on_power(
    published, effect: str
) -> None:
    best = fit_one_coefficient_set(published, PAPER_SETUP, effect)
    assert np.ptp(best.radii_m, axis=0) / best.radii_m.mean(axis=0) == pytest.approx(0, abs=2e-3)


@pytest.mark.parametrize("power", POWERS_PCT)
def test_straight_swimming_without_and_with_the_second_plate(power: int) -> None:
    alone = straight_swimming_growth_per_s(
        TABLE_1[power], setup=PAPER_SETUP, flap_hz=PUBLISHED_FLAP_HZ[power]
    )
    with_fin = straight_swimming_growth_per_s(
        TABLE_1[power],
        setup=PAPER_SETUP,
        flap_hz=PUBLISHED_FLAP_HZ[power],
        effects=FIN_PARAMETERS,
    )
    assert alone > 1.4
    assert with_fin < 0


def test_geometries_are_ours_and_others_that_are_plausible() -> None:
    found = plausible_geometries(4, np.random.default_rng(2))
    assert found[0] is PAPER_SETUP
    assert len({g.robot.hinge_to_com_m for g in found}) == 4
    assert len(TURN_CONDITIONS) * len(POWERS_PCT) == 9
