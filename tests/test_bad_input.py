"""Bad input: one clear message with file and remedy, a non-zero exit, nothing half-written."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from bluekoi.cli import main
from bluekoi.errors import InputError
from bluekoi.workflow.plan import make_plan
from small_studies import edit_trials_csv, small_study

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def good_study(tmp_path_factory):
    return small_study(tmp_path_factory.mktemp("bad_input") / "study")


@pytest.fixture
def study(good_study, tmp_path):
    return Path(shutil.copytree(good_study, tmp_path / "study"))


def bluekoi(*arguments):
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert "Traceback" not in result.output
    return result


def stage(name, study, results, *further):
    return bluekoi("stage", name, "--study", study, "--results", results, *further)


def run_trials(study, results):
    """Stages of every trial and the outcome; the outcome's result."""
    ids = [line.split(",")[0] for line in (study / "trials.csv").read_text().splitlines()[1:]]
    for trial in ids:
        assert stage("keypoints", study, results, "--trial", trial).exit_code == 0
        assert stage("tracks", study, results, "--trial", trial).exit_code == 0
    return stage("outcome", study, results)


def assert_only_bad(results, bad):
    """The bad trial left a status alone; every other trial left all its results."""
    for path in (results / "status").glob("*.json"):
        good = path.stem != bad
        assert json.loads(path.read_text())["ok"] is good
        for folder in ("poses", "tracks", "steady"):
            assert (results / folder / f"{path.stem}.csv").is_file() is good
    assert not list(results.rglob(".*"))


def keep_two_parts(path):
    lines = path.read_text().splitlines()
    path.write_text("\n".join(",".join(line.split(",")[:7]) for line in lines))


def write_all_nan(path):
    lines = path.read_text().splitlines()
    nan = [",".join([line.split(",")[0], *["nan"] * line.count(",")]) for line in lines[3:]]
    path.write_text("\n".join([*lines[:3], *nan]))


def reverse_rows(path):
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], *lines[:2:-1]]))


def leave_quote_open(path):
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], f'"{lines[3]}', *lines[4:]]))


def repeat_first_frame(path):
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:4], *lines[3:]]))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (reverse_rows, ["keypoints/T10.csv: row 5: found frame", "Sort the rows"]),
        (repeat_first_frame, ["row 5: ", "frame 0 after 0"]),
        (leave_quote_open, ["keypoints/T10.csv: row 4", "quotation mark that is not closed"]),
        (keep_two_parts, ["keypoints/T10.csv", "expected"]),
        (write_all_nan, ["keypoints/T10.csv", "expected"]),
        (lambda path: path.write_text(""), ["keypoints/T10.csv", "empty"]),
        (lambda path: path.write_text("hello\nworld\n"), ["keypoints/T10.csv", "expected"]),
        (lambda path: path.unlink(), ["trials.csv", "no file 'keypoints/T10.csv'"]),
    ],
)
def test_a_bad_keypoint_file_stops_its_own_trial_alone(study, tmp_path, spoil, words):
    spoil(study / "keypoints/T10.csv")
    results = tmp_path / "results"
    last = run_trials(study, results)
    assert last.exit_code == 3
    assert last.output.count("\n") == 1
    assert last.output.startswith("T10: ")
    assert all(word in last.output for word in words), last.output
    assert_only_bad(results, "T10")
    assert not (results / "outcome.json").exists()


def swap_columns(path):
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([head, *(",".join(row.split(",")[::-1]) for row in rows)]))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (swap_columns, ["motor/T10.csv", "swapped"]),
        (lambda path: path.write_text("time_s,angle_deg\n"), ["motor/T10.csv"]),
        (
            lambda path: path.write_text(path.read_text().replace("angle_deg", "angle")),
            ["angle_deg"],
        ),
        (lambda path: path.unlink(), ["no file 'motor/T10.csv'"]),
    ],
)
def test_a_bad_motor_log_stops_its_own_trial_alone(study, tmp_path, spoil, words):
    spoil(study / "motor/T10.csv")
    last = run_trials(study, tmp_path / "results")
    assert last.exit_code == 3
    assert all(word in last.output for word in words), last.output
    assert_only_bad(tmp_path / "results", "T10")


def test_results_of_an_earlier_good_run_are_taken_away_with_the_bad_one(study, tmp_path):
    results = tmp_path / "results"
    assert run_trials(study, results).exit_code == 0
    assert (results / "outcome.json").is_file()
    write_all_nan(study / "keypoints/T10.csv")
    assert run_trials(study, results).exit_code == 3
    assert_only_bad(results, "T10")
    assert not (results / "outcome.json").exists()
    assert stage("steady", study, results).exit_code == 0
    assert "T10" not in (results / "steady.csv").read_text()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ["videos/T10.mp4", "empty file (0 bytes)", "Copy it again"]),
        (b"this is no video\n" * 50, ["videos/T10.mp4", "expected"]),
        (None, ["no file 'videos/T10.mp4'"]),
    ],
)
def test_a_bad_video_stops_its_own_trial_alone(study, tmp_path, content, words):
    (study / "videos").mkdir()
    if content is not None:
        (study / "videos/T10.mp4").write_bytes(content)
    edit_trials_csv(study, T10={"source": "videos/T10.mp4", "fps": ""})
    last = run_trials(study, tmp_path / "results")
    assert last.exit_code == 3
    assert last.output.startswith("T10: ")
    assert all(word in last.output for word in words), last.output
    assert_only_bad(tmp_path / "results", "T10")


def test_a_video_shorter_than_declared_is_used_and_reported(study, tmp_path):
    results = tmp_path / "results"
    assert run_trials(study, results).exit_code == 0
    path = results / "status/T10.json"
    status = json.loads(path.read_text())
    path.write_text(json.dumps(status | {"cut_short": "videos/T10.mp4: found 43 of 90 frames"}))
    last = stage("outcome", study, results)
    assert last.exit_code == 3
    assert "T10: videos/T10.mp4: found 43 of 90 frames" in last.output


def change_yaml(study, section, key, value):
    path = study / "study.yaml"
    content = yaml.safe_load(path.read_text())
    content[section][key] = value
    path.write_text(yaml.safe_dump(content))


BAD_STUDIES = {
    "missing column": (
        lambda s: (s / "trials.csv").write_text(
            (s / "trials.csv").read_text().replace("power_pct", "powr_pct")
        ),
        ["trials.csv", "Did you mean 'power_pct'?", "no column 'power_pct'"],
    ),
    "misspelt key": (
        lambda s: change_yaml(s, "robot", "mas_kg", 0.68),
        ["study.yaml", "robot.mas_kg", "Did you mean 'mass_kg'?"],
    ),
    "empty csv": (lambda s: (s / "trials.csv").write_text(""), ["trials.csv", "an empty file"]),
    "negative mass": (
        lambda s: change_yaml(s, "robot", "mass_kg", -0.68),
        ["study.yaml", "robot.mass_kg", "-0.68", "greater than 0"],
    ),
    "corners in the wrong order": (
        lambda s: change_yaml(
            s,
            "camera",
            "pool_corners_px",
            [yaml.safe_load((s / "study.yaml").read_text())["camera"]["pool_corners_px"][i]
             for i in (0, 3, 2, 1)],
        ),
        ["study.yaml", "swap the second and the fourth"],
    ),
    "duplicate ids": (
        lambda s: edit_trials_csv(s, T10={"trial_id": "T09"}),
        ["trials.csv", "'T09' 2 times"],
    ),
    "an id that leaves the folder": (
        lambda s: edit_trials_csv(s, T10={"trial_id": "../T10"}),
        ["trials.csv", "../T10", "letters, digits, _ and -"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_STUDIES)
def test_a_bad_study_is_refused_before_any_work(study, tmp_path, name, monkeypatch):
    spoil, words = BAD_STUDIES[name]
    spoil(study)
    monkeypatch.chdir(tmp_path)
    result = bluekoi("check", study)
    assert result.exit_code == 1
    with pytest.raises(InputError) as refused:  # what Snakefile and `bluekoi run` begin with
        make_plan({"study": str(study), "results": None, "overlays": "none"})
    for shown in (result.output, str(refused.value)):
        assert all(word in shown for word in words), shown
    assert not (tmp_path / "results").exists()


def test_a_run_of_a_bad_study_ends_with_the_message_alone(study, tmp_path, capfd, monkeypatch):
    spoil, words = BAD_STUDIES["missing column"]
    spoil(study)
    monkeypatch.chdir(tmp_path)
    assert bluekoi("run", study).exit_code == 1
    shown = capfd.readouterr().err  # of the workflow's own process
    assert all(word in shown for word in words), shown
    assert not (tmp_path / "results").exists()


def snakemake(folder, *configuration):
    command = [sys.executable, "-m", "snakemake", "--snakefile", ROOT / "Snakefile", "--cores", "1"]
    return subprocess.run(
        [*command, "--config", *configuration],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_plain_snakemake_reports_a_bad_study_without_a_traceback(study, tmp_path):
    change_yaml(study, "robot", "mass_kg", -0.68)
    done = snakemake(tmp_path, f"study={study}")
    assert done.returncode == 1
    assert "robot.mass_kg: found -0.68; expected greater than 0" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "results").exists()


def test_a_misspelt_configuration_key_is_reported_with_the_nearest(study, tmp_path):
    done = snakemake(tmp_path, f"study={study}", "result=out")
    assert done.returncode == 1
    assert "configuration: result: found an unknown key" in done.stderr
    assert "Did you mean 'results'?" in done.stderr


def test_a_picture_of_half_the_size_stops_its_trial(study, tmp_path):
    path = study / "keypoints/T10.csv"
    lines = path.read_text().splitlines()
    names = lines[2].split(",")
    cells = [[f"{float(c) / 2}" if n in "xy" else c for n, c in zip(names, row, strict=True)]
             for row in (line.split(",") for line in lines[3:])]  # fmt: skip
    path.write_text("\n".join([*lines[:3], *(",".join(row) for row in cells)]))
    results = tmp_path / "results"
    last = run_trials(study, results)
    assert last.exit_code == 3
    assert "times as long as stated, in all its parts" in last.output
    assert_only_bad(results, "T10")
