"""The command `bluekoi`: quick, plain, its exit codes as documented."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import click
import cv2
import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from snakemake.cli import parse_config

from bluekoi.cli import main
from bluekoi.cli.outputs import refuse_outputs_over_study_files
from bluekoi.cli.run import (
    _exit_code,
    _failed_trial_lines,
    _requested_results_folder,
    _trial_warnings,
    snakemake_command,
    workflow_folder,
)
from bluekoi.errors import InputError, input_error
from bluekoi.files import write_json
from bluekoi.footage import encode_h264
from bluekoi.workflow.plan import make_plan
from bluekoi.workflow.stage_call import parse_options
from small_studies import edit_trials_csv, small_study

ROOT = Path(__file__).resolve().parents[1]
HEAVY_MODULES = {
    "numpy",
    "cv2",
    "scipy",
    "pandas",
    "matplotlib",
    "numba",
    "filterpy",
    "snakemake",
    "av",
}
HEAVY_MODULES |= {"h5py", "jinja2", "pydantic", "rich", "yaml"}


def bluekoi(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_help_imports_nothing_heavy():
    """What makes `bluekoi --help` come at once; every command's own help as well."""
    words = [["--help"], *([name, "--help"] for name in main.commands)]
    code = (
        "import sys\nfrom bluekoi.cli import main\n"
        f"for words in {words!r}:\n"
        "    try:\n        main(words)\n    except SystemExit as end:\n"
        "        assert end.code == 0, words\n"
        f"    heavy = {HEAVY_MODULES!r} & set(sys.modules)\n    assert not heavy, (words, heavy)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("Usage:") == len(words)


def test_help_names_every_command_and_the_exit_codes():
    text = bluekoi("--help").output
    for name, known in main.commands.items():
        assert (f"  {name} " in text) is not known.hidden
    assert "Exit codes: 0 done; 1 an error" in text


def test_every_command_has_a_sentence():
    for name, known in main.commands.items():
        assert known.help, name
        assert known.help.rstrip().endswith("."), name


def test_a_wrong_use_exits_with_2():
    assert bluekoi("check").exit_code == 2
    assert bluekoi("chek", ".").exit_code == 2
    assert bluekoi("stage", "nothing", "--study", ".", "--results", ".").exit_code == 2


def test_a_misspelt_option_is_not_handed_on_to_snakemake():
    result = bluekoi("run", "demo", "--resluts", "x")
    assert result.exit_code == 2
    assert "--resluts" in result.output
    assert "--results" in result.output


def test_commands_that_no_robot_can_follow_are_refused(tmp_path):
    study = small_study(tmp_path / "study")
    assert bluekoi("simulate", study, "--flap-hz", "1e9").exit_code == 2
    assert bluekoi("simulate", study, "--flap-hz", "5", "--head-angle-deg", "400").exit_code == 2


def test_a_fault_is_its_message_alone_and_exits_with_1(monkeypatch):
    @click.command()
    def broken():
        raise input_error("a\x1b[31m.csv", "row 1", "x", "y")

    monkeypatch.setitem(main.commands, "broken", broken)
    result = bluekoi("broken")
    assert result.exit_code == 1
    assert result.output == "a?[31m.csv: row 1: found x; expected y.\n"


def test_ctrl_c_exits_with_130(monkeypatch):
    @click.command()
    def endless():
        raise KeyboardInterrupt

    monkeypatch.setitem(main.commands, "endless", endless)
    result = bluekoi("endless")
    assert (result.exit_code, result.output) == (130, "Interrupted.\n")


def test_check_of_a_good_study_says_what_is_in_it(tmp_path):
    result = bluekoi("check", small_study(tmp_path / "study"))
    assert result.exit_code == 0
    assert "3 trials (0 filmed, 3 keypoint files) in 3 conditions; no error found" in result.output
    assert "Not checked here" in result.output


def test_check_says_what_it_cannot_check_of_a_film(tmp_path):
    study = small_study(tmp_path / "study")
    (study / "videos").mkdir()
    encode_h264(study / "videos/T10.mp4", [np.full((1080, 1920, 3), 90, np.uint8)] * 8, fps=30,
                size=(1920, 1080))  # fmt: skip
    edit_trials_csv(study, T10={"source": "videos/T10.mp4", "fps": ""})
    result = bluekoi("check", study)
    assert "(1 filmed, 2 keypoint files)" in result.output
    assert "Not checked here" in result.output
    assert "the sign of the head angles" in result.output


def test_check_reports_corners_that_miss_the_best_pose(tmp_path):
    study = small_study(tmp_path / "study")
    setup = yaml.safe_load((study / "study.yaml").read_text())
    setup["camera"]["pool_corners_px"][1][0] += 30.0
    (study / "study.yaml").write_text(yaml.safe_dump(setup))
    result = bluekoi("check", study)
    assert result.exit_code == 0
    assert "study.yaml: the pool corners miss the best pose by" in result.output
    assert "no other error found" in result.output


def test_check_opens_what_a_run_would_open(tmp_path):
    study = small_study(tmp_path / "study")
    (study / "motor/T09.csv").write_text("")
    keypoints = (study / "keypoints/T10.csv").read_text().splitlines()
    (study / "keypoints/T10.csv").write_text("\n".join(keypoints[2:]))
    edit_trials_csv(study, T11={"start_s": "100", "end_s": "200"})
    result = bluekoi("check", study)
    assert result.exit_code == 1
    for words in ("motor/T09.csv", "keypoints/T10.csv", "found 100 s to 200 s"):
        assert words in result.output


def test_check_reports_a_file_that_two_trials_take_whole(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T11={"source": "keypoints/T10.csv"})
    result = bluekoi("check", study)
    assert result.exit_code == 1
    assert "trial T11: found T10.csv, whole, as trial T10 has it" in result.output
    edit_trials_csv(study, T10={"end_s": "1.5"}, T11={
        "start_s": "1.5", "head_angle_deg": "30", "head_length_m": "0.12",
    })  # fmt: skip
    assert bluekoi("check", study).exit_code == 0


@pytest.mark.parametrize("cores", ["0", "-1", "two", "1.5"])
def test_a_number_of_jobs_that_is_none_is_wrong_use(tmp_path, cores):
    result = bluekoi("run", small_study(tmp_path / "study"), "--cores", cores)
    assert result.exit_code == 2
    assert "expected 1 or more, or 'all'" in result.output


def test_bad_trials_are_named_where_a_run_ends_before_its_last_word(tmp_path, monkeypatch):
    status = tmp_path / "status"
    (status / "keypoints").mkdir(parents=True)
    bad, good = {"ok": False, "message": "no frames"}, {"ok": True, "message": ""}
    (status / "keypoints/T1.json").write_text(json.dumps(bad))
    (status / "keypoints/T2.json").write_text(json.dumps(bad))
    (status / "T2.json").write_text(json.dumps(good))
    (status / "T3.json").write_text(json.dumps(bad))
    module = sys.modules["bluekoi.cli.run"]
    monkeypatch.setattr(
        module, "_study_trial_ids", lambda study: {"T1", "T2"} if study == "lab" else set()
    )
    assert _failed_trial_lines(tmp_path, "lab") == ["T1: no frames"]
    assert _failed_trial_lines(tmp_path, "demo") == ["T1: no frames", "T3: no frames"]


def test_doubts_on_trials_are_named_where_a_run_ends_before_its_last_word(tmp_path):
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    flapping = {"flap_hz": 0.0, "video_hz": 2.4, "agrees": False, "ratio": None}
    write_json(results / "status/T09.json", {"ok": True, "flapping": flapping})
    (text,) = _trial_warnings(results, str(study))
    assert text.startswith("trial T09: flap_hz is 0, but the tail beats at 2.4 Hz")


def test_check_refuses_a_path_that_no_file_system_holds(tmp_path):
    study = small_study(tmp_path / "study")
    edit_trials_csv(study, T10={"source": "x" * 300 + ".mp4"})
    result = bluekoi("check", study)
    assert result.exit_code == 1
    assert "source: found a path of 304 characters; expected names of 255 bytes" in result.output


def test_check_names_missing_files(tmp_path):
    study = small_study(tmp_path / "study")
    (study / "motor/T10.csv").unlink()
    result = bluekoi("check", study)
    assert result.exit_code == 1
    assert "trial T10: found no file 'motor/T10.csv'" in result.output


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda text: {**text, "detection": {"source": "silhouete"}},
            "study.yaml: detection.source: found 'silhouete'; expected a keypoint source. Did you",
        ),
        (
            lambda text: {**text, "camera": {**text["camera"], "pool_corners_px": [
                *text["camera"]["pool_corners_px"][1:], text["camera"]["pool_corners_px"][0]]}},
            "study.yaml: camera.pool_corners_px: found corners that miss the best pose",
        ),
    ],
    ids=["source", "corners begin elsewhere"],
)  # fmt: skip
def test_check_looks_further_than_each_value(tmp_path, change, words):
    study = small_study(tmp_path / "study")
    content = yaml.safe_load((study / "study.yaml").read_text())
    (study / "study.yaml").write_text(yaml.safe_dump(change(content)))
    result = bluekoi("check", study)
    assert result.exit_code == 1
    assert f"{study}/{words}" in result.output


def test_doctor_looks_at_every_dependency():
    result = bluekoi("doctor")
    for name in ("Python", "numpy", "snakemake", "H.264", "OpenCV", "GB free"):
        assert name in result.output
    assert result.exit_code == (1 if "FAIL" in result.output else 0)


def test_doctor_states_what_to_install(monkeypatch):
    module = sys.modules["bluekoi.cli.doctor"]
    monkeypatch.setattr(module, "requires", lambda name: ["no-such-package>=3"])
    result = bluekoi("doctor")
    assert result.exit_code == 1
    assert "FAIL no-such-package is missing: pip install 'no-such-package>=3'" in result.output


def test_without_a_place_for_compiled_code_it_is_said_with_the_cure(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("BLUEKOI_CACHE", str(tmp_path / "file"))
    said = bluekoi("doctor")
    assert said.exit_code == 1
    (line,) = (line for line in said.output.splitlines() if line.startswith("FAIL"))
    assert "'Not a directory'" in line
    assert "BLUEKOI_CACHE=FOLDER" in line


def test_run_finds_the_workflow_and_quotes_what_the_person_wrote():
    assert (workflow_folder() / "Snakefile").is_file()
    found = snakemake_command("my = study", Path("out"), "2", ("--dry-run",))
    assert 'study= "my = study" ' in found
    assert 'results= "out" ' in found
    assert found[-1] == "--dry-run"


def test_folders_keep_the_letters_they_are_named_with():
    words = snakemake_command("studé x", Path("/lab/res é out"), "2", ())
    assert 'study= "studé x" ' in words
    assert 'results= "/lab/res é out" ' in words


@pytest.mark.parametrize(
    "words", [["run", ""], ["run", "study", "--results", ""], ["check", ""], ["export", ""]]
)
def test_an_empty_name_is_no_folder(words):
    found = CliRunner().invoke(main, words)
    assert found.exit_code == 2
    assert "is empty; expected a folder" in found.output


def test_a_request_to_terminate_is_handed_on_and_waited_for():
    """The child says when it is there, and again when it is asked to end."""
    child = (
        "import signal, sys, time; signal.signal(signal.SIGTERM, "
        "lambda *_: (print('asked', flush=True), sys.exit(1))); "
        "print('there', flush=True); time.sleep(60)"
    )
    parent = (
        "import sys; from bluekoi.cli.run import _run_process; "
        f"sys.exit(_run_process([sys.executable, '-c', {child!r}]))"
    )
    with subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == "there\n"
        run.terminate()
        assert run.stdout.readline() == "asked\n"
        assert run.wait() == 143


def test_keys_given_to_snakemake_do_not_make_it_forget_the_study():
    given = ("--dry-run", "--config", "overlays=none", "demo_folder=d", "--quiet", "-C", "x=1")
    words = snakemake_command("lab", Path("out"), "2", given)
    assert words.count("--config") == 1
    at = words.index("--config")
    keys = ['study= "lab" ', 'results= "out" ', "overlays=none", "demo_folder=d", "x=1"]
    assert words[at + 1 :] == [*keys, "--dry-run", "--quiet"]
    assert snakemake_command("lab", None, "2", ("--config=overlays=all",))[-1] == "overlays=all"


def test_bad_trials_are_looked_for_where_the_results_are():
    assert _requested_results_folder("labs/koi", None, ()) == Path("results/koi")
    assert _requested_results_folder("labs/koi", Path("out"), ("--dry-run",)) == Path("out")
    assert _requested_results_folder(
        "labs/koi", None, ("--config", "results=there", "x=1")
    ) == Path("there")


@pytest.mark.parametrize(
    ("returned", "present", "code"),
    [
        (0, (), 0),
        (1, ("steady.csv", "coefficients.json", "report.html"), 3),
        (1, ("steady.csv",), 1),
    ],
)
def test_exit_codes_of_run(tmp_path, returned, present, code):
    for name in present:
        (tmp_path / name).touch()
    assert _exit_code(returned, tmp_path) == code


def test_run_hands_on_to_snakemake(tmp_path, monkeypatch):
    study = small_study(tmp_path / "study")
    monkeypatch.chdir(tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "bluekoi", "run", str(study), "--cores", "1", "--", "--dry-run"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "keypoints" in done.stdout + done.stderr


def test_simulate_gives_the_speed_of_table_1_by_its_formula(tmp_path):
    study = small_study(tmp_path / "study")
    out = tmp_path / "path.csv"
    result = bluekoi("simulate", study, "--flap-hz", "5.82", "--out", out, "--seconds", "2")
    assert result.exit_code == 0, result.output
    assert "steady: 0.552 m/s, straight" in result.output  # f sqrt(C_T / C_D0)
    assert out.read_text().splitlines()[0].startswith("time_s,x_m,y_m,theta_rad")
    assert len(out.read_text().splitlines()) == 122


def test_pool_without_footage_is_reported(tmp_path):
    result = bluekoi("pool", small_study(tmp_path / "study"))
    assert result.exit_code == 1
    assert "no footage to draw on" in result.output


def test_pool_draws_corners_on_a_frame(tmp_path):
    study = small_study(tmp_path / "study")
    picture = np.full((1080, 1920, 3), 90, np.uint8)
    (study / "videos").mkdir()
    encode_h264(study / "videos/T10.mp4", [picture] * 3, fps=30, size=(1920, 1080))
    edit_trials_csv(study, T10={"source": "videos/T10.mp4", "fps": ""})
    result = bluekoi("pool", study, "--out", tmp_path / "pool.png")
    assert result.exit_code == 1, "no edge confirms the corners"
    assert "The corners given are not confirmed" in result.output
    assert (tmp_path / "pool.png").stat().st_size > 1000


def test_pool_without_corners_rules_a_picture_to_read_them_off(tmp_path):
    study = small_study(tmp_path / "study")
    setup = yaml.safe_load((study / "study.yaml").read_text())
    del setup["camera"]["pool_corners_px"]
    (study / "study.yaml").write_text(yaml.safe_dump(setup))
    frame, out = tmp_path / "frame.png", tmp_path / "pool.png"
    cv2.imwrite(str(frame), np.full((1080, 1920, 3), 90, np.uint8))
    result = bluekoi("pool", study, frame, "--out", out)
    assert result.exit_code == 0, result.output
    assert "a line every 100 px" in result.output
    assert "pool_corners_px: [[u, v]" in result.output
    drawn = cv2.imread(str(out))
    assert drawn.shape == (1080, 1920, 3)
    assert drawn[550, 100].mean() > 200
    assert drawn[550, 150].mean() == 90
    nothing = bluekoi("pool", study, "--out", out)
    assert nothing.exit_code == 1
    assert "bluekoi pool STUDY FRAME" in nothing.output


def test_pool_takes_a_picture_of_ones_own(tmp_path):
    study = small_study(tmp_path / "study")
    frame = tmp_path / "frame.png"
    cv2.imwrite(str(frame), np.full((1080, 1920, 3), 90, np.uint8))
    result = bluekoi("pool", study, frame, "--out", tmp_path / "pool.png")
    assert "the corners given" in result.output
    assert (tmp_path / "pool.png").stat().st_size > 1000


def test_calibrate_takes_a_missing_picture_as_a_fault(tmp_path):
    result = bluekoi("calibrate", tmp_path / "none.jpg", "--out", tmp_path / "c.yaml")
    assert result.exit_code == 1
    assert "none.jpg" in result.output
    assert not (tmp_path / "c.yaml").exists()


def test_pool_prints_corners_in_the_pixels_of_study_yaml(tmp_path):
    study, frame = small_study(tmp_path / "study"), tmp_path / "frame.png"
    cv2.imwrite(str(frame), np.full((720, 1280, 3), 90, np.uint8))
    result = bluekoi("pool", study, frame, "--out", tmp_path / "pool.png")
    assert "the frame has 1280 x 720 px, image_size_px says 1920 x 1080" in result.output


def test_nothing_that_is_there_is_written_over(tmp_path):
    study, frame = small_study(tmp_path / "study"), tmp_path / "frame.png"
    cv2.imwrite(str(frame), np.full((1080, 1920, 3), 90, np.uint8))
    before = {path: path.read_bytes() for path in (study / "study.yaml", frame)}
    for arguments in (
        ("calibrate", frame, "--out", study / "study.yaml"),
        ("calibrate", frame, "--out", tmp_path / "frame.yaml"),
        ("calibrate", frame, "--out", tmp_path / "o.png"),
        ("pool", study, frame, "--out", frame),
        ("pool", study, frame, "--out", study / "study.yaml"),
    ):
        result = bluekoi(*arguments)
        assert result.exit_code == 1, arguments
        assert "Nothing was written" in result.output
    assert all(path.read_bytes() == content for path, content in before.items())
    assert bluekoi("calibrate", frame, "--model", "plate").exit_code == 2


def test_check_reports_a_film_of_another_shape_and_of_keypoints_never_sure(tmp_path):
    study = small_study(tmp_path / "study")
    (study / "videos").mkdir()
    encode_h264(study / "videos/T10.mp4", [np.full((480, 640, 3), 90, np.uint8)] * 3, fps=30,
           size=(640, 480))  # fmt: skip
    edit_trials_csv(study, T10={"source": "videos/T10.mp4", "fps": ""})
    path = study / "keypoints/T11.csv"
    rows = [line.split(",") for line in path.read_text().splitlines()]
    kept = [",".join("0" if i and i % 3 == 0 else c for i, c in enumerate(r)) for r in rows[3:]]
    path.write_text("\n".join([*(",".join(r) for r in rows[:3]), *kept]) + "\n")
    result = bluekoi("check", study)
    assert result.exit_code == 1
    assert "but videos/T10.mp4 (trial T10) has 640 x 480" in result.output
    assert "T11.csv: found 0 of" in result.output


def test_files_in_the_working_directory_are_never_imported(tmp_path):
    """A lab's own `pipeline.py`, `bluekoi.py` or `yaml.py` beside its study must not run."""
    for name in ("pipeline", "bluekoi", "yaml"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('shadowed')\n")
    interpreter = snakemake_command("study", None, "1", ())[:4]
    done = subprocess.run(
        [*interpreter, "--version"], cwd=tmp_path, check=False, capture_output=True, text=True
    )
    assert "shadowed" not in done.stdout + done.stderr
    assert done.returncode == 0


def test_a_pipe_a_device_and_nested_brackets_are_refused_at_once(tmp_path):
    study = small_study(tmp_path / "study")
    (study / "study.yaml").unlink()
    os.mkfifo(study / "study.yaml")
    result = bluekoi("check", study)
    assert result.exit_code == 1
    assert "a pipe or a device, not a file" in result.output
    study = small_study(tmp_path / "other")
    result = bluekoi("simulate", study, "--schedule", "/dev/urandom")
    assert result.exit_code == 1
    assert "a pipe or a device, not a file" in result.output
    (tmp_path / "nested.json").write_text("[" * 100_000)
    for source in ("/dev/zero", tmp_path / "nested.json"):
        result = bluekoi("calibrate", source, "--out", tmp_path / "camera.yaml")
        assert result.exit_code == 1, result.output
        assert "Traceback" not in result.output
        assert str(source) in result.output


def test_a_million_rows_are_refused_at_once(tmp_path):
    study = small_study(tmp_path / "study")
    lines = (study / "trials.csv").read_text().splitlines()
    for rows, found in ((20_000, "rows; expected 10000 trials"), (1_000_000, "bytes, more than")):
        (study / "trials.csv").write_text("\n".join([lines[0], *[lines[1]] * rows]))
        start = time.monotonic()
        result = bluekoi("check", study)
        assert result.exit_code == 1
        assert found in result.output
        assert time.monotonic() - start < 10


@pytest.mark.parametrize("name", ["trials.csv", "study.yaml", "motor/T09.csv", "keypoints/T10.csv"])
def test_no_command_replaces_a_file_of_the_study(tmp_path, name):
    study = small_study(tmp_path / "study")
    (study / "linked.csv").symlink_to(study / name)
    before = (study / name).read_bytes()
    for out in (study / name, study / "linked.csv"):
        result = bluekoi("simulate", study, "--flap-hz", "5", "--seconds", "1", "--out", out)
        assert result.exit_code == 1
        assert "a file of the study" in result.output
    assert (study / name).read_bytes() == before


def test_an_export_does_not_replace_a_file_of_the_study(tmp_path):
    study = small_study(tmp_path / "study")
    (study / "motor/T09.csv").rename(study / "motor/coefficients.csv")
    edit_trials_csv(study, T09={"motor_log": "motor/coefficients.csv"})
    with pytest.raises(InputError, match="a file of the study"):
        refuse_outputs_over_study_files(study, [study / "motor/coefficients.csv"])


@pytest.mark.parametrize("name", ["lab {1}", "<b>", "new\nline"])
def test_check_refuses_names_that_a_run_cannot_use(tmp_path, name):
    result = bluekoi("check", small_study(tmp_path / name))
    assert result.exit_code == 1
    assert "Name another one with --results" in result.output


@pytest.mark.parametrize(
    "name", ["20261123", "007", "[1]", "null", "a: b", "trail ", "a\\b", 'q"q']
)
def test_names_that_look_like_other_values_reach_snakemake_as_they_are(name):
    (entry,) = (w for w in snakemake_command(name, None, "1", ()) if w.startswith("study="))
    assert parse_config([entry]) == {"study": name}


def test_a_run_says_nothing_before_its_answer(tmp_path, monkeypatch):
    study = small_study(tmp_path / "study")
    monkeypatch.chdir(tmp_path)
    words = [sys.executable, "-m", "bluekoi", "run", str(study), "--", "--until", "keypoints"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("[0/")
    assert done.stdout == ""


def test_a_run_imports_no_numerics_in_the_process_that_waits(tmp_path):
    """It starts Snakemake and reads how the trials went."""
    program = ("import sys; from pathlib import Path;"
               "from bluekoi.cli.run import _failed_trial_lines;"
               "print(_failed_trial_lines(Path(sys.argv[1]), 'x'), *sys.modules)")  # fmt: skip
    status = tmp_path / "status"
    status.mkdir()
    (status / "T01.json").write_text('{"ok": true, "message": ""}')
    run = subprocess.run([sys.executable, "-c", program, str(tmp_path)], capture_output=True,
                         text=True, check=True, cwd=tmp_path)  # fmt: skip
    assert not {"numpy", "scipy", "cv2"} & set(run.stdout.split())
    assert run.stdout.startswith("[]")


def test_a_second_study_or_an_option_that_snakemake_lacks_is_one_line(tmp_path):
    found = CliRunner().invoke(main, ["run", "one", "two"])
    assert found.exit_code == 2
    assert "Got a second study 'two'" in found.output
    command = snakemake_command(str(tmp_path), tmp_path / "out", "1", ("--nosuchflag",))
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "Options after --: unrecognized arguments: --nosuchflag. `snakemake --help` lists them."
    ]


def test_a_file_as_results_folder_is_refused_also_where_it_is_the_studys_own(tmp_path):
    study = small_study(tmp_path / "study")
    settings = {"study": str(study), "results": str(study / "study.yaml"), "demo_folder": "demo",
                "overlays": "all"}  # fmt: skip
    with pytest.raises(InputError, match=r"study\.yaml: found a file; expected a folder"):
        make_plan(settings)


def test_a_trial_may_have_the_name_of_an_option():
    options = parse_options(
        ["keypoints", "--study", "s", "--results", "r", "--trial=-rf", "--trial=T2"]
    )
    assert options.trials == ["-rf", "T2"]


def test_a_study_that_is_not_there_is_reported_once_by_a_run(tmp_path, monkeypatch, capfd):
    """The run itself says so; a search for bad trials in its results must not say it again."""
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, ["run", "nosuch"])
    assert done.exit_code == 1
    printed = capfd.readouterr().err + done.output
    assert printed.count("found no such folder; expected a study folder") == 1
