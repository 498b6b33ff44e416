"""Commands around a run: init, report, completion; and what importing the package costs."""

from __future__ import annotations

import json
import subprocess
import sys

import cv2
import numpy as np
import pytest
import yaml
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from bluekoi.cli import main
from bluekoi.files import write_json
from bluekoi.footage import encode_h264
from bluekoi.study import load_incomplete_study, load_study
from small_studies import small_study

MOTOR_LOG = "time_s,angle_deg\n" + "".join(f"{k / 200},{(k * 9) % 360}\n" for k in range(400))


def bluekoi(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture
def lab_folder(tmp_path):
    """A folder with two short films and the motor log of one."""
    for name in ("p50_phi-20", "p100_phi30"):
        pictures = [np.full((48, 64, 3), 40 + k, np.uint8) for k in range(12)]
        (tmp_path / "lab/videos").mkdir(parents=True, exist_ok=True)
        encode_h264(tmp_path / f"lab/videos/{name}.mp4", pictures, fps=30.0, size=(64, 48))
    (tmp_path / "lab/motor").mkdir()
    (tmp_path / "lab/motor/p50_phi-20.csv").write_text(MOTOR_LOG)
    return tmp_path / "lab"


def test_init_fills_in_what_the_files_say_and_check_lists_the_rest(lab_folder):
    done = bluekoi("init", lab_folder, "--head-length-m", "0.12")
    assert done.exit_code == 0, done.output
    assert "0.4 s, 30 frames/s, 64 x 48; motor/p50_phi-20.csv: 5 Hz" in done.output
    rows = (lab_folder / "trials.csv").read_text().splitlines()
    assert rows[0] == "trial_id,source,power_pct,head_angle_deg,head_length_m,motor_log"
    assert rows[2] == "p100_phi30,videos/p100_phi30.mp4,100,30,0.12,"
    text = (lab_folder / "study.yaml").read_text()
    assert text.startswith("# Recordings found:\n#   p50_phi-20: videos/p50_phi-20.mp4: 0.4 s")
    assert yaml.safe_load(text)["camera"]["image_size_px"] == [64, 48]
    missing = bluekoi("check", lab_folder)
    assert missing.exit_code == 1
    assert "pool.length_m" in missing.output
    assert "unknown" not in missing.output
    assert "pool.length_m: found nothing; expected a number" in missing.output
    assert "`bluekoi pool STUDY` draws a frame with ruled lines" in missing.output


def test_the_same_empty_cell_in_all_rows_is_one_line(lab_folder):
    bluekoi("init", lab_folder)
    table = lab_folder / "trials.csv"
    head, row, _ = table.read_text().splitlines()
    rows = [row.replace("p100_phi30,", f"T{k},", 1).replace("p50_phi-20,", f"T{k},", 1)
            for k in range(9)]  # fmt: skip
    table.write_text("\n".join([head, *rows]) + "\n")
    lines = [
        line for line in bluekoi("check", lab_folder).output.splitlines() if "trials.csv" in line
    ]
    assert len(lines) == 1
    assert "rows 2 to 10 (T0 to T8), head_length_m: found nothing" in lines[0]
    rows[4] = rows[4].replace(",50,", ",50,").replace(",,", ",0.12,", 1)
    table.write_text("\n".join([head, *rows]) + "\n")
    assert "8 rows (T0 to T8), head_length_m" in bluekoi("check", lab_folder).output


def test_corners_are_read_off_before_anything_else_is_filled_in(lab_folder, monkeypatch):
    """With the key left empty, as `init` writes it, and a frame in the folder of the study."""
    monkeypatch.chdir(lab_folder.parent)
    bluekoi("init", lab_folder)
    for words in ((), ("videos/p100_phi30.mp4",)):
        done = bluekoi("pool", "lab", *words, "--out", "grid.png")
        assert done.exit_code == 0, done.output
        assert "pool_corners_px: [[u, v]" in done.output


@pytest.fixture
def unmarked_study(tmp_path):
    """A study without corners: T01 is ten pictures, most of 640 x 360 px, T02 a brighter video."""
    study = small_study(tmp_path / "study")
    setup = yaml.safe_load((study / "study.yaml").read_text())
    del setup["camera"]["pool_corners_px"]
    (study / "study.yaml").write_text(yaml.safe_dump(setup))
    (study / "T01").mkdir()
    for k in range(10):
        cv2.imwrite(str(study / f"T01/{k}.png"), np.full((360, 640, 3), 60, np.uint8))
    cv2.imwrite(str(study / "T01/0.png"), np.full((90, 160, 3), 90, np.uint8))
    light = [np.full((360, 640, 3), 120, np.uint8)] * 3
    encode_h264(study / "T02.mp4", light, fps=30.0, size=(640, 360))
    rows = ["T01,T01,,,,30", "T02,T02.mp4,,,,", "T03,keypoints/T10.csv,,,,"]
    header = "trial_id,source,power_pct,head_angle_deg,head_length_m,fps"
    (study / "trials.csv").write_text("\n".join([header, *rows]) + "\n")
    return study


@pytest.mark.parametrize(("words", "brightness"), [
    ((), 60), (("--trial", "T01"), 60), (("--trial", "T02"), 120),
])  # fmt: skip
def test_the_ruled_frame_is_that_of_the_trial(unmarked_study, tmp_path, words, brightness):
    out = tmp_path / "pool.png"
    done = bluekoi("pool", unmarked_study, *words, "--out", out)
    assert done.exit_code == 0, done.output
    assert abs(np.median(cv2.imread(str(out))) - brightness) < 5


@pytest.mark.parametrize(("name", "message"), [
    ("NOPE", "no trial 'NOPE'; expected a known trial. Known: T01, T02, T03."),
    ("T03", "no footage to draw on"),
])  # fmt: skip
def test_a_trial_without_a_frame_is_refused_also_without_corners(
    unmarked_study, tmp_path, name, message
):
    done = bluekoi("pool", unmarked_study, "--trial", name, "--out", tmp_path / "pool.png")
    assert done.exit_code == 1
    assert message in done.output
    assert not (tmp_path / "pool.png").exists()


def test_a_picture_of_a_study_is_not_written_over_without_corners(unmarked_study):
    before = (unmarked_study / "T01/5.png").read_bytes()
    done = bluekoi("pool", unmarked_study, "T01/0.png", "--out", unmarked_study / "T01/5.png")
    assert done.exit_code == 1
    assert "a file of the study" in done.output
    assert (unmarked_study / "T01/5.png").read_bytes() == before


def test_the_lines_are_labelled_in_the_pixels_of_image_size_px(unmarked_study, tmp_path):
    """A frame of a third of the size, 1920 x 1080: u lies at (u + 1/2) / 3 - 1/2."""
    done = bluekoi("pool", unmarked_study, "--out", tmp_path / "pool.png")
    assert "a line every 100 px" in done.output
    assert "the frame has 640 x 360 px, image_size_px says 1920 x 1080" in done.output
    drawn = cv2.imread(str(tmp_path / "pool.png"))
    assert drawn.shape == (360, 640, 3)
    columns = np.flatnonzero(drawn[208, :, 0] > 200)
    np.testing.assert_array_equal(columns, np.round((np.arange(100, 1920, 100) + 0.5) / 3 - 0.5))


@pytest.mark.parametrize(("size", "message"), [
    ([1000, 1000], "1000 x 1000, but the frame has 640 x 360"),
    ([1920], "width and height in pixels"),
])  # fmt: skip
def test_a_frame_that_is_not_the_picture_of_study_yaml_is_not_ruled(
    unmarked_study, tmp_path, size, message
):
    setup = yaml.safe_load((unmarked_study / "study.yaml").read_text())
    setup["camera"]["image_size_px"] = size
    (unmarked_study / "study.yaml").write_text(yaml.safe_dump(setup))
    done = bluekoi("pool", unmarked_study, "--out", tmp_path / "pool.png")
    assert done.exit_code == 1
    assert message in done.output
    assert not (tmp_path / "pool.png").exists()


def test_sources_of_an_incomplete_study_are_read_as_they_are(tmp_path):
    long = "x" * 300
    rows = ["trial_id,source,fps", f"A,{long}.mp4,x", "B,a\0b.mp4", "C,a.mp4;b.mp4,nan", "D"]
    (tmp_path / "trials.csv").write_text("\n".join(rows) + "\n")
    trials = load_incomplete_study(tmp_path).trials
    assert [trial.sources for trial in trials] == [(), (), ("a.mp4", "b.mp4"), ()]
    assert [trial.fps for trial in trials] == [None] * 4
    assert load_incomplete_study(tmp_path / "none").trials == ()


def test_init_takes_the_files_that_are_named_and_overwrites_nothing(lab_folder):
    film = lab_folder / "videos/p100_phi30.mp4"
    assert bluekoi("init", film, "--study", lab_folder).exit_code == 0
    assert [
        line.split(",")[0] for line in (lab_folder / "trials.csv").read_text().splitlines()
    ] == ["trial_id", "p100_phi30"]
    before = (lab_folder / "study.yaml").read_bytes()
    again = bluekoi("init", lab_folder)
    assert again.exit_code == 1
    assert "nothing is overwritten" in again.output
    assert (lab_folder / "study.yaml").read_bytes() == before


@pytest.mark.parametrize("error", [PermissionError(13, "Permission denied", "lab/kp/T01.csv")])
def test_a_file_that_may_not_be_read_is_named_without_a_traceback(lab_folder, monkeypatch, error):
    def refused(*_):
        raise error

    monkeypatch.setattr("bluekoi.study.load_study", refused)
    done = bluekoi("check", lab_folder)
    assert done.exit_code == 1
    assert "lab/kp/T01.csv: found 'Permission denied'" in done.output
    assert "Change its permissions" in done.output


def test_init_passes_over_an_empty_csv_file(lab_folder):
    (lab_folder / "notes.csv").write_text("")
    (lab_folder / "secret.csv").symlink_to(lab_folder / "nowhere.csv")
    assert bluekoi("init", lab_folder).exit_code == 0


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("linked", ["folder", "files"])
def test_init_follows_links_to_recordings_elsewhere(lab_folder, linked, named):
    study = lab_folder.parent / "study"
    study.mkdir()
    if linked == "folder":
        (study / "films").symlink_to(lab_folder / "videos")
        (lab_folder / "videos/again").symlink_to(study)  # a link in a circle
    else:
        (study / "films").mkdir()
        for film in (lab_folder / "videos").iterdir():
            (study / "films" / film.name).symlink_to(film)
    films = sorted((study / "films").glob("*.mp4")) if named else [study]
    done = bluekoi("init", *films, "--study", study)
    assert done.exit_code == 0, done.output
    sources = {line.split(",")[1] for line in (study / "trials.csv").read_text().splitlines()[1:]}
    assert sources == {"films/p50_phi-20.mp4", "films/p100_phi30.mp4"}


@pytest.mark.parametrize(
    ("words", "message"),
    [(["nowhere.mp4"], "nothing there"), (["empty"], "no video and no keypoint file"),
     (["lab/videos/p100_phi30.mp4", "--study", "empty"], "outside of the study's folder")],
)  # fmt: skip
def test_init_says_what_it_cannot_use(lab_folder, monkeypatch, words, message):
    monkeypatch.chdir(lab_folder.parent)
    (lab_folder.parent / "empty").mkdir()
    done = bluekoi("init", *words)
    assert done.exit_code == 1
    assert message in done.output
    assert not (lab_folder / "study.yaml").exists()


def test_a_film_that_cannot_be_read_is_listed_with_its_reason(lab_folder):
    (lab_folder / "videos/broken.mp4").write_bytes(b"\0\1no video" * 9)
    done = bluekoi("init", lab_folder)
    assert done.exit_code == 0
    assert "broken: videos/broken.mp4: cannot be used: no readable video" in done.output


def test_report_shows_verdict_causes_and_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab").mkdir()
    assert "no results; expected the results of a run" in bluekoi("report", "lab").output
    results = tmp_path / "results/lab"
    results.mkdir(parents=True)
    rate = {"value": 3.0, "std": 0.012, "unit": "1", "meaning": "how much faster true time runs"}
    cause = {"name": "clock_error", "weight": 0.9, "parameters": {"rate_error": rate}}
    found = {"sentence": "The clock is wrong.", "causes": [cause], "warnings": ["Look here."]}
    (results / "mismatch.json").write_text(json.dumps(found))
    assert bluekoi("report", "lab").exit_code == 1
    (results / "report.html").write_text("<p>")
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda page: bool(opened.append(page)) or True)
    done = bluekoi("report", "lab", "--open")
    assert done.exit_code == 0
    assert "Verdict: The clock is wrong." in done.output
    assert "clock_error (probability 0.90)" in done.output
    assert "rate_error = 3 +- 0.012  (how much faster true time runs)" in done.output
    assert "one standard deviation" in done.output
    assert "Warning: Look here." in done.output
    (results / "outcome.json").write_text(json.dumps({"warnings": ["T04: another's log?"]}))
    assert "Warning: T04: another's log?" in bluekoi("report", "lab").output
    assert opened == [(results / "report.html").resolve().as_uri()]
    assert bluekoi("report", results).exit_code == 0


def test_report_repeats_the_warnings_of_a_run_in_which_trials_failed(tmp_path):
    """Such a run leaves no outcome.json."""
    study, results = small_study(tmp_path / "lab"), tmp_path / "results"
    write_json(results / "geometry.json", {"tail_end_seen": False})
    (results / "report.html").write_text("<p>")
    done = bluekoi("report", study, "--results", results)
    assert done.exit_code == 0
    assert "measure body_length_m" in done.output
    write_json(results / "status/T10.json", {"ok": False, "message": "no robot", "remarks": []})
    assert "T10: no robot" in bluekoi("report", study, "--results", results).output.splitlines()


def test_a_run_that_ends_early_says_what_is_wrong_with_its_trials(tmp_path, monkeypatch):
    """Its last stage knows only that too few trials are left."""
    monkeypatch.chdir(tmp_path)
    small_study(tmp_path / "lab")
    status = tmp_path / "results/lab/status"
    status.mkdir(parents=True)
    for name, ok in (("T10", False), ("T11", True), ("gone", False)):
        message, remark = f"the head of {name} is on the other side", f"{name} hardly moved"
        text = json.dumps({"ok": ok, "message": message, "remarks": [remark]})
        (status / f"{name}.json").write_text(text)
    run_module = sys.modules["bluekoi.cli.run"]
    monkeypatch.setattr(run_module, "_run_process", lambda words: 1)
    done = bluekoi("run", "lab")
    assert done.exit_code == 1
    assert done.output.splitlines() == [
        "T10: the head of T10 is on the other side",
        "T11: T11 hardly moved",
    ]
    monkeypatch.setattr(run_module, "MAX_FAILED_TRIALS_SHOWN", 0)
    assert bluekoi("run", "lab").output == "... and 2 more trials\n"
    (tmp_path / "lab/trials.csv").write_text("")
    assert bluekoi("run", "lab").output == ""


def completions(words, start):
    found = ShellComplete(main, {}, "bluekoi", "_BLUEKOI_COMPLETE")
    return [item.value for item in found.get_completions(words, start)]


def test_a_shell_completes_studies_and_trials(tmp_path, monkeypatch):
    small_study(tmp_path / "work/lab")
    (tmp_path / "work/.hidden").mkdir()
    monkeypatch.chdir(tmp_path)
    assert completions(["run"], "") == ["demo", "work/"]
    assert completions(["check"], "work/") == ["work/lab", "work/truth/"]
    assert completions(["check"], "work/.") == ["work/.hidden/"]
    ids = [trial.trial_id for trial in load_study(tmp_path / "work/lab").trials]
    assert completions(["export", "work/lab", "--trial"], "") == ids
    assert completions(["pool", "work/lab", "--trial"], "T1") == ids[1:]
    assert completions(["export", "nowhere", "--trial"], "") == []
    assert "compare" in completions([], "comp") or "completion" in completions([], "comp")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_prints_a_script_for_each_shell(shell):
    done = bluekoi("completion", shell)
    assert done.exit_code == 0
    assert "_BLUEKOI_COMPLETE" in done.output
    if shell == "bash":
        assert (
            subprocess.run(["bash", "-n"], input=done.output, text=True, check=False).returncode
            == 0
        )


def test_importing_the_package_imports_next_to_nothing():
    """Fewer than 20 modules beyond those of a bare interpreter, and none of them heavy."""
    code = ("import sys; before = set(sys.modules); import bluekoi; "
            "print(*sorted(set(sys.modules) - before))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    names = done.stdout.split()
    assert "bluekoi" in names
    assert len(names) < 20
    assert not {"numpy", "scipy", "matplotlib", "cv2", "pandas", "numba"} & set(names)
