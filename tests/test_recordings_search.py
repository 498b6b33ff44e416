"""The search on recordings of others: bars that were reached, figures from docs/evidence.md."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from pipeline.fitting import Series

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
engine = import_module("examples.engine")
yaw = import_module("examples.yaw_coastdown.__main__")
yaw_reading = import_module("examples.yaw_coastdown.reading")
pendulum = import_module("examples.pendulum.__main__")
pendulum_reading = import_module("examples.pendulum.reading")

pytestmark = pytest.mark.recordings


@pytest.fixture(scope="module")
def spindowns(recordings) -> tuple[Series, ...]:
    return yaw_reading.read_folder(recordings / "yaw_coastdown")


@pytest.fixture(scope="module")
def swings(recordings) -> Series:
    return pendulum_reading.read_folder(recordings / "pendulum")


@pytest.mark.parametrize(
    ("known", "withheld"),
    [
        ("linear_yaw_damping", "quadratic_yaw_damping"),
        ("quadratic_yaw_damping", "linear_yaw_damping"),
    ],
)
def test_the_withheld_part_of_the_damping_is_found(spindowns, known, withheld):
    outcome = engine.investigate(yaw.withheld(spindowns, known))
    assert withheld in outcome.chosen.effects
    values = outcome.chosen.fit.by_label()
    assert values["quadratic_yaw_damping.N_rr"] == pytest.approx(3.3, abs=0.7)
    assert values["linear_yaw_damping.N_r"] == pytest.approx(0.35, abs=0.2)


def test_the_compass_says_that_the_gyro_reads_beside_zero(spindowns):
    beyond = np.array([one.evidence["compass"][0] for one in spindowns])
    assert np.mean(beyond) == pytest.approx(-0.017, abs=0.003)
    assert np.all(beyond < 0)


def test_a_spindown_is_foretold_from_the_others_to_a_hundredth(spindowns):
    given = yaw.withheld(spindowns, "linear_yaw_damping")
    effects = ("quadratic_yaw_damping", "gyro_bias")
    assert yaw.error_rad_s(given, spindowns, effects) <= 0.010


def test_viscous_friction_and_not_coulombs_stops_the_pendulum(swings):
    outcome = engine.investigate(pendulum.searched(swings))
    assert "viscous_friction" in outcome.chosen.effects
    assert "coulomb_friction" not in outcome.chosen.effects
    viscous, coulomb = (pendulum.rms(swings, (f"{n}_friction",))[0] for n in ("viscous", "coulomb"))
    assert viscous < 0.0125
    assert coulomb > 2 * viscous
