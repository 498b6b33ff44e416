"""A folder of videos and logs makes the rows of trials.csv and a study.yaml to fill in."""

from __future__ import annotations

import pytest
import yaml

from bluekoi.preparation.prefill import (
    StudyFiles,
    blank_study_yaml,
    condition_from_file_name,
    prefilled_trial_rows,
    study_files,
    trials_csv_text,
    usable_study_files,
)
from bluekoi.study.study_yaml import read_study_settings
from bluekoi.study.trials_csv import read_trials

MOTOR_LOG = "time_s,angle_deg\n0,0\n0.005,3\n"


def make_folder(tmp_path, names):
    for name in names:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(MOTOR_LOG if name.endswith(".csv") else "", encoding="utf-8")
    return tmp_path


def test_files_are_distinguished_and_ordered_as_people_count(tmp_path):
    folder = make_folder(tmp_path, [
        "videos/T10.mp4", "videos/T2.mp4", "motor/T2.csv", "notes.txt", ".hidden/T3.mp4",
        "results/report.html", "results/overlays/T2.mp4", "tracked/T2.h5",
    ])  # fmt: skip
    (folder / "tracked/T4.csv").write_text("scorer,a,a,a\n", encoding="utf-8")
    found = study_files(folder)
    assert found.videos == ("videos/T2.mp4", "videos/T10.mp4")
    assert found.motor_logs == ("motor/T2.csv",)
    assert found.keypoints == ("tracked/T2.h5", "tracked/T4.csv")


def test_rows_have_source_log_and_condition_where_they_are_known(tmp_path):
    names = ["p50_phi-20.mp4", "70pct.mov", "logs/motor_70pct.csv", "a/T1.mp4", "b/T1.mp4"]
    rows = prefilled_trial_rows(study_files(make_folder(tmp_path, names)), 0.12)
    found = {row["source"]: row for row in rows}
    assert found["p50_phi-20.mp4"]["power_pct"] == "50"
    assert found["p50_phi-20.mp4"]["head_angle_deg"] == "-20"
    assert found["70pct.mov"]["motor_log"] == "logs/motor_70pct.csv"
    assert "head_angle_deg" not in found["70pct.mov"]
    assert [found[f"{k}/T1.mp4"]["trial_id"] for k in "ab"] == ["T1", "b_T1"]
    assert {row["head_length_m"] for row in rows} == {"0.12"}


def test_one_motor_log_is_not_given_to_two_recordings_of_one_name():
    files = StudyFiles(("a/p50.mp4", "b/p50.mp4", "b/p70.mp4"), (), ("p50.csv", "p70.csv"))
    assert [row.get("motor_log") for row in prefilled_trial_rows(files)] == [None, None, "p70.csv"]


def test_numbers_that_no_trial_has_are_not_taken_from_a_name():
    assert condition_from_file_name("p999_phi-500") == {}
    assert condition_from_file_name("p300_phi-120") == {
        "power_pct": "300",
        "head_angle_deg": "-120",
    }


def test_chapters_of_one_recording_make_one_row(tmp_path):
    names = ["GX020007.MP4", "GX010007.MP4", "GX010008.MP4"]
    rows = prefilled_trial_rows(study_files(make_folder(tmp_path, names)))
    assert [row["source"] for row in rows] == ["GX010007.MP4;GX020007.MP4", "GX010008.MP4"]


@pytest.mark.parametrize(
    ("name", "power", "angle"),
    [("P40_head_angle_m15", "40", "-15"), ("50pct_a30_2", "50", "30"), ("GX010034", None, None),
     ("power-60", "60", None), ("phi+10_p5", "5", "10"), ("T01", None, None)],
)  # fmt: skip
def test_names_that_state_power_and_head_angle(name, power, angle):
    found = condition_from_file_name(name)
    assert (found.get("power_pct"), found.get("head_angle_deg")) == (power, angle)


def test_the_csv_is_one_that_the_study_reads(tmp_path):
    path = tmp_path / "trials.csv"
    row = {"trial_id": "T1", "source": "T1.mp4", "power_pct": "50", "head_angle_deg": "0",
           "head_length_m": "0.12", "end_s": "4"}  # fmt: skip
    path.write_text(trials_csv_text([row], ["source", "trial_id"]), encoding="utf-8")
    assert path.read_text(encoding="utf-8").startswith("source,trial_id,power_pct")
    findings = []
    trials = read_trials(path, findings)
    assert findings == []
    assert trials[0].end_s == 4


def test_the_blank_study_lacks_only_what_must_be_measured(tmp_path):
    path = tmp_path / "study.yaml"
    path.write_text(blank_study_yaml(), encoding="utf-8")
    findings = []
    assert read_study_settings(path, findings) is None
    missing = {finding.where for finding in findings}
    assert missing >= {"pool.length_m", "robot.mass_kg", "camera.pool_corners_px"}
    assert not any("unknown" in finding.found for finding in findings)
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert content["water"]["refractive_index"] == 1.333


def test_a_folder_of_many_pictures_is_a_recording_and_one_of_few_is_not(tmp_path):
    names = [f"T1/{i}.png" for i in range(60)] + [f"board/{i}.jpg" for i in range(20)]
    found = study_files(make_folder(tmp_path, names))
    assert found.pictures == ("T1/",)
    assert [(r["trial_id"], r["source"]) for r in prefilled_trial_rows(found)] == [("T1", "T1/")]


def test_a_recording_that_trials_csv_cannot_name_is_left_out_with_a_note(tmp_path):
    files, notes = usable_study_files(
        make_folder(tmp_path, ["w\n.mp4", "x;y.mp4", "z.mp4", "l;og.csv"])
    )
    assert (files.videos, files.motor_logs) == (("z.mp4",), ("l;og.csv",))
    assert notes == (
        "w .mp4 is left out: a name in trials.csv has no line break, tab or double blank."
        " Rename it.",
        "x;y.mp4 is left out: ';' separates the files of one recording in trials.csv. Rename it.",
    )
