"""Mistakes that `bluekoi check` names by their cause rather than by what follows from them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from bluekoi.cli import main
from bluekoi.files import read_json
from bluekoi.footage import encode_h264
from bluekoi.preparation.input_check import check_files, file_findings, recording_warnings
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


def film_trials(study, fps, *trials):
    """Make trials videos of twelve grey pictures at 30 frames/s, with another rate stated."""
    size = load_study(study).setup.camera.image_size_px
    for first, trial in enumerate(trials, 90):
        levels = range(first, first + 12)
        grey = [np.full((size[1], size[0], 3), level, np.uint8) for level in levels]
        encode_h264(study / f"{trial}.mp4", grey, fps=30, size=size)
        row = {"source": f"{trial}.mp4", "fps": fps, "motor_log": ""}
        edit_trials_csv(study, **{trial: row})


def warnings_of_check(study):
    loaded = load_study(study)
    findings, _, remarks = check_files(loaded)
    assert findings == []
    return recording_warnings(loaded, remarks)


@pytest.mark.parametrize(("trials", "named"), [
    (("T10",), "trial T10"), (("T09", "T10"), "trials T09, T10"),
])  # fmt: skip
def test_a_rate_that_replaces_the_file_s_own_is_a_warning(study, trials, named):
    film_trials(study, "60", *trials)
    expected = "fps 60 from trials.csv replaces the file's own 30"
    assert warnings_of_check(study) == [f"{named}: {expected}"]
    shown = CliRunner().invoke(main, ["check", str(study)])
    assert shown.exit_code == 0
    assert f"Warning: {named}: {expected}" in shown.output


def test_a_rate_that_is_the_file_s_own_is_no_warning(study):
    film_trials(study, "30", "T10")
    assert warnings_of_check(study) == []


def test_a_status_of_detection_has_the_remarks_on_the_recording(study, tmp_path):
    film_trials(study, "60", "T10")
    keypoints(study, tmp_path / "results", "T10")
    status = read_json(tmp_path / "results/status/keypoints/T10.json")
    assert status["ok"]
    assert status["remarks"][0] == "fps 60 from trials.csv replaces the file's own 30"


def test_a_video_that_was_cut_short_is_reported_once(study, tmp_path):
    rng, path = np.random.default_rng(1), study / "T10.avi"
    width, height = load_study(study).setup.camera.image_size_px
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 30.0, (width, height))
    for _ in range(40):
        noise = rng.integers(80, 100, (height // 8, width // 8, 3)).astype(np.uint8)
        video.write(cv2.resize(noise, (width, height)))
    video.release()
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    edit_trials_csv(study, T10={"source": "T10.avi", "fps": "", "motor_log": ""})
    (warning,) = warnings_of_check(study)
    assert warning.startswith("trial T10: cut short: ")
    keypoints(study, tmp_path / "results", "T10")
    status = read_json(tmp_path / "results/status/keypoints/T10.json")
    assert "of 40 declared frames" in status["cut_short"]
    assert not any("cut short" in text for text in status["remarks"])


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


def test_a_log_shorter_than_half_of_a_video_is_a_warning(study):
    size = load_study(study).setup.camera.image_size_px
    grey = [np.full((size[1], size[0], 3), 90 + k % 9, np.uint8) for k in range(40)]
    encode_h264(study / "T10.mp4", grey, fps=2, size=size)  # 20 s; the log covers 6 s
    edit_trials_csv(study, T10={"source": "T10.mp4", "fps": ""})
    shown = CliRunner().invoke(main, ["check", str(study)])
    assert "trial T10: the motor log covers" in shown.output
    edit_trials_csv(study, T10={"end_s": "999"})
    assert "the motor log covers" in CliRunner().invoke(main, ["check", str(study)]).output


def test_an_exchanged_root_and_tip_of_the_tail_are_no_wrong_body_length(study):
    path = study / "study.yaml"
    exchanged = {"tail_base": "tail_tip", "tail_tip": "tail_base"}
    content = yaml.safe_load(path.read_text()) | {"bodyparts": exchanged}
    path.write_text(yaml.safe_dump(content))
    finding = only_finding(study)
    assert finding.where == "robot.body_length_m"
    assert "are tail_base and tail_tip exchanged, in the file or in `bodyparts:`?" in finding.remedy


@pytest.mark.parametrize(("body_length_m", "sentences"), [(0.331, 0), (0.397, 1)])
def test_a_body_length_to_the_tip_of_the_tail_shows_without_its_root(
    study, body_length_m, sentences
):
    change_robot(study, body_length_m=body_length_m)
    for path in (study / "keypoints").glob("*.csv"):
        rows = [line.split(",") for line in path.read_text().splitlines()]
        kept = [i for i, name in enumerate(rows[1]) if name != "tail_base"]
        path.write_text("\n".join(",".join(row[i] for i in kept) for row in rows) + "\n")
    shown = CliRunner().invoke(main, ["check", str(study)])
    assert shown.exit_code == 0
    assert shown.output.count("core_center to tail_tip measures 23") == sentences
    assert shown.output.count("303 mm are stated") == sentences


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
