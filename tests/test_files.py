"""Files are there whole or not at all."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bluekoi.errors import InputError, did_you_mean, escape_control_characters, input_error
from bluekoi.files import atomic_write, read_json, to_json_types, write_json, write_text


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def fail_halfway():
        with atomic_write(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_halfway()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_write_makes_its_folder_and_keeps_the_usual_permissions(tmp_path):
    path = tmp_path / "new" / "b.txt"
    write_text(path, "x")
    (tmp_path / "plain").touch()
    assert path.read_text() == "x"
    assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_folder_that_cannot_be_made_is_a_fault_with_a_cure(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="choose another results folder"):
        write_text(tmp_path / "file" / "b.txt", "x")


def test_a_full_disk_is_a_fault_and_leaves_nothing(tmp_path, monkeypatch):
    def full(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("bluekoi.files.os.replace", full)
    with pytest.raises(InputError, match="No space left on device"):
        write_text(tmp_path / "a.txt", "x")
    assert list(tmp_path.iterdir()) == []


def test_json_goes_round_with_numpy_and_without_nan(tmp_path):
    path = tmp_path / "a.json"
    write_json(path, {"a": np.float64(1.5), "b": np.array([1, 2]), "c": math.nan, "d": (1, "x")})
    assert read_json(path) == {"a": 1.5, "b": [1, 2], "c": None, "d": [1, "x"]}
    assert to_json_types({1: math.inf}) == {"1": None}


@pytest.mark.parametrize("text", ["", "{", "[1]", "\x00"])
def test_unreadable_json_is_a_fault_that_names_the_file(tmp_path, text):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(InputError, match=r"a\.json"):
        read_json(tmp_path / "a.json")


def test_a_fault_says_place_found_expected_and_cure():
    error = input_error("trials.csv", "row 3", "'x'", "a number", "Mend it.")
    assert str(error) == "trials.csv: row 3: found 'x'; expected a number. Mend it."


def test_the_nearest_name_or_all_names():
    assert did_you_mean("mas_kg", ["mass_kg", "head"]) == "Did you mean 'mass_kg'?"
    assert did_you_mean("zzz", ["b", "a"]) == "Known: a, b."


def test_control_characters_of_hostile_input_do_not_reach_the_terminal():
    assert escape_control_characters("a\x1b[31mb\nc\x07") == "a?[31mb\nc?"
