"""Mistakes that `bluekoi check` names by their cause rather than by what follows from them."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from bluekoi.files import read_json
from bluekoi.footage import encode_h264
from bluekoi.preparation.input_check import file_findings
from bluekoi.stages.keypoints import keypoints
from bluekoi.study import load_study
from small_studies import edit_trials_csv, small_study


@pytest.fixture
def study(tmp_path):
    return small_study(tmp_path / "study")


def only_finding(study):
    (finding,) = file_findings(load_study(study))
    return finding


def test_a_part_of_two_frames_is_named_and_not_the_likelihoods(study):
    edit_trials_csv(study, T10={"start_s": "1", "end_s": "1.05"})
    finding = only_finding(study)
    assert finding.file == str(study / "trials.csv")
    assert finding.where == "trial T10, start_s, end_s"
    assert finding.found == "a part of keypoints/T10.csv with 2 frames (start_s 1, end_s 1.05)"
    assert finding.expected.startswith("8 at least, 0.27 s at 29.97 frames/s")


def test_a_start_beyond_the_recording_is_named_with_its_row_and_the_recording_s_length(study):
    edit_trials_csv(study, T10={"start_s": "1000"})
    finding = only_finding(study)
    assert finding.file == str(study / "trials.csv")
    assert finding.where == "trial T10, start_s"
    assert finding.found == "1000 s"
    assert "T10.csv, whose frames are from 0 to " in finding.expected


@pytest.mark.parametrize("log", ["motor/T10.csv", ""])
def test_a_video_of_one_frame_is_named_and_not_its_motor_log(study, log):
    size = load_study(study).setup.camera.image_size_px
    picture = np.full((size[1], size[0], 3), 90, np.uint8)
    encode_h264(study / "T10.mp4", [picture], fps=30, size=size)
    edit_trials_csv(study, T10={"source": "T10.mp4", "fps": "", "motor_log": log})
    finding = only_finding(study)
    assert finding.file == str(study / "T10.mp4")
    assert finding.found == "a recording of 1 frame"
    assert finding.expected.startswith("8 at least, 0.27 s at 30 frames/s")


def test_a_start_outside_of_the_pictures_is_named_with_their_size(study):
    size = load_study(study).setup.camera.image_size_px
    pictures = [np.full((size[1], size[0], 3), grey, np.uint8) for grey in range(90, 102)]
    encode_h264(study / "T10.mp4", pictures, fps=30, size=size)
    start = {"start_x_px": "5000", "start_y_px": "10"}
    edit_trials_csv(study, T10={"source": "T10.mp4", "fps": "", "motor_log": "", **start})
    finding = only_finding(study)
    assert finding.where == "trial T10, start_x_px, start_y_px"
    assert finding.found == "(5000, 10)"
    assert finding.expected.endswith(f"{size[0]} x {size[1]}")


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ({"start_s": "1", "end_s": "1.05"}, "start_s, end_s: found a part of keypoints/T10.csv"),
        ({"start_s": "1000"}, "trials.csv: trial T10, start_s: found 1000 s; expected a part of k"),
    ],
)
def test_a_run_says_of_a_part_what_check_says(study, tmp_path, cells, words):
    edit_trials_csv(study, T10=cells)
    keypoints(study, tmp_path / "results", "T10")
    message = read_json(tmp_path / "results/status/keypoints/T10.json")["message"]
    assert words in message
    assert not message.startswith("keypoints")


def change_robot(study, **lengths):
    path = study / "study.yaml"
    content = yaml.safe_load(path.read_text())
    content["robot"] |= lengths
    path.write_text(yaml.safe_dump(content))


@pytest.mark.parametrize(
    ("key", "value", "measured", "fitting"),
    [
        ("hinge_to_com_m", 0.08, "hinge to core_center measures 0.040 m in 3 of 3", "same"),
        ("body_length_m", 0.397, "it measures 0.171 m in 3 of 3", "0.331 m (or robot.head_"),
        ("head_length_m", 0.175, "it measures 0.171 m in 3 of 3", "0.120 m (or robot.body_"),
    ],
)
def test_a_length_that_all_trials_contradict_is_named_once(study, key, value, measured, fitting):
    change_robot(study, **{key: value})
    finding = only_finding(study)
    assert finding.file == str(study / "study.yaml")
    assert finding.where == f"robot.{key}"
    assert finding.found.startswith(f"{value:g} m")
    assert measured in finding.found
    assert fitting in finding.expected


def test_a_head_length_that_one_trial_has_wrong_is_that_trial_s(study):
    edit_trials_csv(study, T10={"head_length_m": "0.175"})
    finding = only_finding(study)
    assert finding.where == "trial T10"
    assert finding.file == str(study / "trials.csv")


def test_head_angles_in_radians_are_one_message(study):
    edit_trials_csv(study, T10={"head_angle_deg": "0.5236"}, T11={"head_angle_deg": "-0.7854"})
    finding = only_finding(study)
    assert finding.where == "head_angle_deg"
    assert finding.found.startswith("0.5236 where the head is turned by 30 degrees (trial T10)")
    assert "multiply the column by 180/pi" in finding.remedy


def test_one_head_angle_in_radians_is_asked_for_in_its_own_trial(study):
    edit_trials_csv(study, T10={"head_angle_deg": "0.5236"})
    finding = only_finding(study)
    assert finding.where == "trial T10"
    assert "Is it in radians?" in finding.remedy
