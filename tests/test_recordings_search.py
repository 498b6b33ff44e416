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


def test_the_compass_says_that_the_gyro_reads_beside_zero(spindowns):
    beyond = np.array([one.evidence["compass"][0] for one in spindowns])
    assert np.mean(beyond) == pytest.approx(-0.017, abs=0.003)
    assert np.all(beyond < 0)


def test_a_spindown_is_foretold_from_the_others_to_a_hundredth(spindowns):
    given = yaw.withheld(spindowns, "linear_yaw_damping")
    effects = ("quadratic_yaw_damping", "gyro_bias")
    assert yaw.error_rad_s(given, spindowns, effects) <= 0.010


def test_the_pendulums_rate_is_recorded_too_small_and_coulomb_fits_worst(swings):
    outcome = engine.investigate(pendulum.searched(swings))
    assert outcome.chosen.effects[0] == "rate_scale"
    assert outcome.chosen.fit.by_label()["rate_scale.k"] == pytest.approx(-0.046, abs=0.005)
    viscous, quadratic, coulomb, none = (
        pendulum.rms(swings, effects)[0]
        for effects in (("viscous_friction",), ("quadratic_friction",), ("coulomb_friction",), ())
    )
    assert viscous < 0.026
    assert viscous < quadratic < coulomb < 0.1 * none
