"""Mistakes in study.yaml and trials.csv whose message names their own place, not another one."""

from __future__ import annotations

import pytest
import yaml
from test_study import SETUP, changed_setup, findings_of, only_finding, write_study

from bluekoi.study import load_study, missing_files


def test_a_skew_in_the_camera_matrix_is_refused(tmp_path):
    matrix = [[1130.0, 50, 955.0], [0, 1130.0, 542.0], [0, 0, 1]]
    finding = only_finding(write_study(tmp_path / "s", changed_setup(camera={"matrix": matrix})))
    assert finding.where == "camera.matrix"
    assert finding.found == "a first row [1130.0, 50.0, 955.0]"
    assert finding.expected == "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]"


@pytest.mark.parametrize(("mass_kg", "key"), [(1e-300, "mass_kg"), (6.8e-4, "mass_kg")])
def test_a_mass_too_small_for_the_body_is_named_and_not_the_inertia(tmp_path, mass_kg, key):
    finding = only_finding(write_study(tmp_path / "s", changed_setup(robot={"mass_kg": mass_kg})))
    assert finding.where == f"robot.{key}"
    assert "yaw_inertia_kg_m2 0.0095 is possible" in finding.expected


def test_a_decimal_comma_in_braces_is_recognised(tmp_path):
    braces = yaml.safe_dump({"robot": SETUP["robot"]}, default_flow_style=True, width=1000)
    text = yaml.safe_dump({k: v for k, v in SETUP.items() if k != "robot"})
    text += braces.strip()[1:-1].replace("mass_kg: 0.68", "mass_kg: 0,68") + "\n"
    found = findings_of(write_study(tmp_path / "s", text))
    assert any(
        "robot.68: found the key 68; expected a name before each colon. Decimals are written"
        in str(finding)
        for finding in found
    )


@pytest.mark.parametrize(("key", "hint"), [("1", True), ("true", False)])
def test_a_key_that_is_no_text_is_named(tmp_path, key, hint):
    finding = only_finding(write_study(tmp_path / "s", yaml.safe_dump(SETUP) + f"{key}: x\n"))
    assert finding.expected == "a name before each colon"
    assert ("with a point" in finding.remedy) is hint


def test_a_quotation_mark_is_named_in_the_row_that_opens_it(tmp_path):
    rows = [f"T0{i},k/T0{i}.csv,100,30,0.12,30,,,," for i in range(1, 6)]
    rows[1] = '"' + rows[1]
    finding = only_finding(write_study(tmp_path / "s", rows=rows))
    assert finding.where == "row 3"
    assert "a quotation mark that is not closed" in finding.found


@pytest.mark.parametrize("first", [b"PK\x03\x04" + bytes(40), b"PK\x03\x04\x14\x00\xe9\xff"])
def test_a_workbook_named_csv_is_recognised(tmp_path, first):
    folder = write_study(tmp_path / "s")
    (folder / "trials.csv").write_bytes(first)
    finding = only_finding(folder)
    assert finding.found.startswith("a workbook (xlsx or ods)")
    assert finding.remedy == "Save it as CSV UTF-8."


@pytest.mark.parametrize(
    ("content", "found"),
    [(None, "an empty folder 'T01'"), ("notes.txt", "a folder without pictures: 'T01'")],
)
def test_a_folder_without_pictures_is_named_as_such(tmp_path, content, found):
    folder = write_study(tmp_path / "s", rows=["T01,T01/,100,30,0.12,30,,,,"])
    (folder / "T01").mkdir()
    if content:
        (folder / "T01" / content).touch()
    (finding,) = missing_files(load_study(folder))
    assert finding.where == "trial T01, source"
    assert finding.found == found
    assert ".png" in finding.expected


@pytest.mark.parametrize(
    ("cell", "hint"),
    [("12", "12 cm are 0.12 m"), ("120", "120 mm are 0.12 m"), ("6", "6 cm are 0.06 m")],
)
def test_a_head_length_of_a_trial_in_cm_or_mm_is_asked_about(tmp_path, cell, hint):
    folder = write_study(tmp_path / "s", rows=[f"T01,k/T01.csv,100,30,{cell},30,,,,"])
    finding = only_finding(folder)
    assert "head_length_m" in finding.where
    assert hint in finding.remedy
