"""Every key of a study explains itself: meaning, unit, default, allowed values."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from bluekoi.cli import main
from bluekoi.study.key_reference import explain_key, setting_keys

UNITS = {"_m": "m", "_kg": "kg", "_s": "s", "_hz": "Hz", "_deg": "deg", "_px": "px", "_pct": "%"}


@pytest.mark.parametrize("key", setting_keys(), ids=lambda key: key.name)
def test_every_key_has_a_meaning_and_the_unit_of_its_name(key):
    assert key.meaning.endswith(".")
    stated = {unit for suffix, unit in UNITS.items() if key.name.endswith(suffix)}
    assert not stated or key.unit in stated | {"kg/m3", "kg m2"}


def test_a_key_is_explained_by_its_bare_name_or_with_its_section():
    text = explain_key("robot.keypoint_depth_m")
    assert text == explain_key("keypoint_depth_m")
    for words in ("study.yaml", "unit:    m", "default: 0.04", "at least 0"):
        assert words in text
    assert "pinhole or fisheye" in explain_key("model")
    assert "at least -120, at most 120" in explain_key("head_angle_deg")


def test_a_section_is_explained_with_all_that_stands_in_it():
    text = explain_key("pool")
    assert all(name in text for name in ("pool.length_m", "pool.width_m", "pool.depth_m"))


def test_the_name_of_both_files_shows_both():
    assert {"robot.head_length_m (study.yaml)", "head_length_m (trials.csv)"} <= set(
        explain_key("head_length_m").splitlines()
    )


def test_the_command_explains_without_a_study_and_suggests_the_nearest_key():
    found = CliRunner().invoke(main, ["check", "--explain", "fps"])
    assert found.exit_code == 0
    assert "required for keypoint files" in found.output
    wrong = CliRunner().invoke(main, ["check", "--explain", "fsp"])
    assert wrong.exit_code == 1
    assert "Did you mean 'fps'?" in wrong.output
