"""The paper's nine radii and three speeds (Tables I and II), and one coefficient set for all."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.design_space import steady_states
from bluekoi.model import FLAP_HZ, TABLE_1, plates
from bluekoi.tuning import growth_per_s
from nine_numbers import POWERS, TURNS, conditions, fitted, geometries, radii_and_speeds
from robots import SETUP

FIN = {"tail_fin_lift": {"lift_area": 0.012, "arm": 0.15}}


@pytest.fixture(scope="module")
def seen():
    return radii_and_speeds(SETUP)


def test_radii_and_speeds_rebuilt_from_tables_1_and_2(seen) -> None:
    assert seen.speeds_m_s == pytest.approx([0.225, 0.381, 0.552], abs=0.001)
    assert np.all((seen.radii_m > 0.3) & (seen.radii_m < 1.2))
    assert np.all(np.diff(seen.radii_m, axis=0) < 0), "radius falls with power in every turn"
    thirty, tight = seen.radii_m[:, 1], seen.radii_m[:, 0]
    assert np.all(thirty > tight)


def test_one_set_makes_the_radius_independent_of_power() -> None:
    values = plates().values(TABLE_1[75])[None]
    radii = steady_states(conditions(SETUP)[:9], values).radius_m.reshape(3, 3)
    assert np.ptp(radii, axis=0) / radii.mean(axis=0) == pytest.approx([0, 0, 0], abs=1e-3)


def test_one_set_misses_by_more_than_a_tenth(seen) -> None:
    """No coefficients whatever can follow radii that change with power: mean and spread by turn."""
    best = fitted(seen, SETUP)
    assert best.speeds_m_s == pytest.approx(seen.speeds_m_s, rel=0.02)
    floor = 100 * np.sqrt(np.mean((seen.radii_m / _middle(seen.radii_m) - 1) ** 2))
    assert best.misfit_pct >= 0.98 * floor
    assert 9 < best.misfit_pct < 18


def _middle(radii: np.ndarray) -> np.ndarray:
    """For each turn the one radius with the least squared relative error over the powers."""
    return np.sum(1 / radii, axis=0) / np.sum(1 / radii**2, axis=0)


def test_one_effect_of_another_power_of_speed_removes_much_of_it(seen) -> None:
    alone, with_it = fitted(seen, SETUP), fitted(seen, SETUP, "linear_yaw_damping")
    assert with_it.misfit_pct < 0.6 * alone.misfit_pct
    assert with_it.speeds_m_s == pytest.approx(seen.speeds_m_s, rel=0.01)


@pytest.mark.parametrize("effect", ["tail_fin_lift", "crossflow_drag", "thrust_loss_with_speed"])
def test_effects_that_are_quadratic_too_remove_nothing_of_the_dependence_on_power(
    seen, effect: str
) -> None:
    best = fitted(seen, SETUP, effect)
    assert np.ptp(best.radii_m, axis=0) / best.radii_m.mean(axis=0) == pytest.approx(0, abs=2e-3)


@pytest.mark.parametrize("power", POWERS)
def test_straight_swimming_without_and_with_the_second_plate(power: int) -> None:
    alone = growth_per_s(TABLE_1[power], setup=SETUP, flap_hz=FLAP_HZ[power])
    with_fin = growth_per_s(TABLE_1[power], setup=SETUP, flap_hz=FLAP_HZ[power], effects=FIN)
    assert alone > 1.4
    assert with_fin < 0


def test_geometries_are_ours_and_others_that_are_plausible() -> None:
    found = geometries(4, np.random.default_rng(2))
    assert found[0] is SETUP
    assert len({g.robot.hinge_to_com_m for g in found}) == 4
    assert len(TURNS) * len(POWERS) == 9
