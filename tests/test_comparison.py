"""Two runs side by side, and the manifest that says what each was made from."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import re
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from bluekoi.cli import main
from bluekoi.cli.results_warnings import warn_of_outdated_results
from bluekoi.comparison import comparison_figure, list_run_differences, read_run
from bluekoi.data import SteadyState
from bluekoi.errors import InputError
from bluekoi.stages.manifest import RUN_ENVIRONMENT_VARIABLE, write_manifest
from bluekoi.stages.study_changes import changes_since_run, outdated_results_message
from bluekoi.steady import write_steady
from bluekoi.study import load_study
from small_studies import edit_trials_csv, small_study

UNITS = {"C_T": "m2", "C_D0": "1"}


def write_results(folder: Path, thrust: float, cause: str, **manifest) -> Path:
    """A results folder with two coefficients and one cause."""
    folder.mkdir(parents=True)
    cells = {"C_T": {"value": thrust, "std": 1e-4, "unit": "m2"},
             "C_D0": {"value": 0.5, "std": None, "unit": "1"}}  # fmt: skip
    errors = {"path_rmse_m": 0.01, "radius_error_pct": None, "speed_error_pct": 2.0}
    found = {"verdict": "physics", "sentence": "", "probabilities": {cause: 0.9, "stall": 0.01},
             "causes": [{"name": cause, "weight": 0.9,
                         "parameters": {"rate_error": {"value": 1.0, "std": 0.1, "unit": "1"}}}],
             "held_out": {"baseline": errors, "extended": errors,
                          "noise_floor_path_rmse_m": 0.002}}  # fmt: skip
    (folder / "coefficients.json").write_text(json.dumps({"joint": {"coefficients": cells}}))
    (folder / "mismatch.json").write_text(json.dumps(found))
    rows = {f"T{i}": SteadyState(4.0, 0.3 + i * thrust, 0.01, 0.5, 0.01, 90.0, 1.0, 3.0, "good", "")
            for i in range(3)}  # fmt: skip
    write_steady(folder / "steady.csv", rows)
    if manifest:
        (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


@pytest.fixture
def two_results(tmp_path) -> tuple[Path, Path]:
    same = {
        "study": {"robot": {"mass_kg": 0.68}},
        "settings": {"overlays": "none"},
        "versions": {"numpy": "2.0"},
        "inputs": {"study.yaml": {"sha256": "a" * 64}},
    }
    other = {**same, "study": {"robot": {"mass_kg": 0.70}},
             "inputs": {"study.yaml": {"sha256": "b" * 64}}}  # fmt: skip
    return (write_results(tmp_path / "a", 0.0045, "wave_drag", **same),
            write_results(tmp_path / "b", 0.0051, "added_mass", **other))  # fmt: skip


def test_differences_are_listed_with_their_size_in_standard_deviations(two_results):
    found = {(d.section, d.name): d for d in list_run_differences(*map(read_run, two_results))}
    thrust = found["coefficient", "C_T"]
    assert thrust.difference == pytest.approx(6e-4)
    assert thrust.sigmas == pytest.approx(6e-4 / (2**0.5 * 1e-4))
    assert found["coefficient", "C_D0"].same
    assert found["probability of cause", "wave_drag"].second == "0.00"
    assert ("probability of cause", "stall") not in found
    assert found["study.yaml", "robot.mass_kg"].second == "0.7"
    assert found["input file", "study.yaml"].first == "a" * 12
    assert ("version", "numpy") not in found
    assert found["error on held-out trials", "baseline path_rmse"].first == "10 mm"


def test_the_command_prints_writes_and_draws(two_results, tmp_path):
    done = CliRunner().invoke(
        main, ["compare", *map(str, two_results), "--out", str(tmp_path / "out")]
    )
    assert done.exit_code == 0, done.output
    assert "C_T: 0.0045 +- 0.0001 m2 -> 0.0051 +- 0.0001 m2  (+4.2 sd) *" in done.output
    assert "C_D0" not in done.output
    with (tmp_path / "out/comparison.csv").open(newline="") as lines:
        rows = {row["name"]: row for row in csv.DictReader(lines)}
    assert float(rows["C_T"]["standard_deviations"]) == pytest.approx(4.24, abs=0.01)
    assert (tmp_path / "out/comparison.pdf").read_bytes().startswith(b"%PDF")
    figure = comparison_figure(read_run(two_results[0]), read_run(two_results[1]), ("a", "b"))
    assert [axes.get_title() for axes in figure.axes] == [
        "Coefficients, first run = 1", "Probability of each cause",
        "Path error on held-out trials", "Steady speed of each trial"]  # fmt: skip


def test_a_run_is_the_same_as_itself_and_a_folder_without_results_is_refused(two_results, tmp_path):
    done = CliRunner().invoke(main, ["compare", str(two_results[0]), str(two_results[0])])
    assert done.output.strip() == "No difference."
    with pytest.raises(InputError, match="neither coefficients"):
        read_run(tmp_path)


@pytest.mark.parametrize("command", ["compare", "report"])
def test_a_path_that_is_not_there_is_named_as_given(tmp_path, command):
    missing = str(tmp_path / "missing")
    done = CliRunner().invoke(main, [command, missing, missing][: 3 if command == "compare" else 2])
    assert done.exit_code == 1
    assert f"{missing}: found no such folder" in done.output
    assert "results/missing" not in done.output


def test_runs_without_a_manifest_are_compared_in_their_results_alone(two_results):
    (two_results[1] / "manifest.json").unlink()
    done = CliRunner().invoke(main, ["compare", *map(str, two_results)])
    assert f"No manifest.json in {two_results[1]}" in done.output
    assert "mass_kg" not in done.output


@pytest.mark.parametrize("name", ["coefficients.json", "mismatch.json", "steady.csv"])
def test_a_run_that_lacks_results_is_named_and_the_rest_compared(two_results, name):
    (two_results[1] / name).unlink()
    done = CliRunner().invoke(main, ["compare", *map(str, two_results)])
    assert done.exit_code == 1
    assert f"No {name} in {two_results[1]}" in done.output
    assert "robot.mass_kg: 0.68 -> 0.7" in done.output


def test_commands_on_results_name_what_has_changed_in_the_study(tmp_path):
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    write_manifest(study, results)
    assert changes_since_run(load_study(study), results) == []
    settings = yaml.safe_load((study / "study.yaml").read_text())
    settings["robot"]["mass_kg"] = 0.34
    (study / "study.yaml").write_text(yaml.safe_dump(settings))
    edit_trials_csv(study, T09={"head_angle_deg": "-20"})
    path = load_study(study).paths(load_study(study).trial("T10"))[0]
    path.write_text(path.read_text().replace("1", "2"))
    mass, angle, content = changes_since_run(load_study(study), results)
    assert mass.startswith("robot.mass_kg was ")
    assert mass.endswith(", now 0.34")
    assert angle.startswith("head_angle_deg of trial T09 was ")
    assert content == f"{path.relative_to(study)} has another content"
    (results / "report.html").touch()
    said = CliRunner().invoke(main, ["report", f"{study}/study.yaml", "--results", str(results)])
    assert f"made from another state of {study}: {mass}; {angle}" in said.stderr
    path.unlink()
    (study / "trials.csv").write_text("nonsense")
    said = CliRunner().invoke(main, ["report", str(study), "--results", str(results)])
    assert "The study has changed and cannot be read: " in said.stderr


def test_files_that_kept_size_and_date_are_not_read_again(tmp_path, monkeypatch):
    """A study of videos would take minutes to hash at each `bluekoi report`."""
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    write_manifest(study, results)
    read: list[Path] = []
    monkeypatch.setattr("bluekoi.stages.manifest.file_sha256", read.append)
    assert changes_since_run(load_study(study), results) == []
    assert read == []


def test_results_of_the_demo_are_compared_with_the_files_of_its_study(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    study, results = small_study(tmp_path / "studies/demo"), tmp_path / "results"
    write_manifest(study, results)
    warn_of_outdated_results(Path("demo"), results)
    assert capsys.readouterr().err == ""
    text = (study / "study.yaml").read_text()
    (study / "study.yaml").write_text(re.sub(r"mass_kg: [\d.]+", "mass_kg: 0.9", text))
    warn_of_outdated_results(Path("demo"), results)
    assert "mass_kg" in capsys.readouterr().err


def test_a_trial_that_was_added_or_removed_is_a_change(tmp_path):
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    write_manifest(study, results)
    manifest = json.loads((results / "manifest.json").read_text())
    manifest["trials"]["T99"] = manifest["trials"].pop("T09")
    (results / "manifest.json").write_text(json.dumps(manifest))
    message = outdated_results_message(load_study(study), results)
    assert "trial T99 was removed; trial T09 was added" in message


@pytest.mark.parametrize(("content", "key"), [({"settings": 3}, "settings"),
                                              ({"trials": {"T1": "x"}}, "trials.T1"),
                                              ({"inputs": [1]}, "inputs")])  # fmt: skip
def test_a_damaged_manifest_is_named_with_its_entry(two_results, content, key):
    path = two_results[1] / "manifest.json"
    path.write_text(json.dumps(content))
    done = CliRunner().invoke(main, ["compare", *map(str, two_results)])
    assert done.exit_code != 0
    assert f"{path}: {key}: found " in str(done.exception) + done.output


def test_the_manifest_says_what_a_run_was_made_from(tmp_path, monkeypatch):
    study, results = small_study(tmp_path / "study"), tmp_path / "results"
    expected = {"command": "bluekoi run study", "settings": {"overlays": "none"}, "code": "abc"}
    monkeypatch.setenv(RUN_ENVIRONMENT_VARIABLE, json.dumps(expected))
    write_manifest(study, results)
    found = json.loads((results / "manifest.json").read_text())
    assert {key: found[key] for key in expected} == expected
    assert found["study"]["robot"]["mass_kg"] > 0
    assert set(found["trials"]) == {"T09", "T10", "T11"}
    assert found["versions"]["numpy"]
    for name, entry in found["inputs"].items():
        content = (study / name).read_bytes()
        assert entry == {"sha256": hashlib.sha256(content).hexdigest(), "bytes": len(content)}
    assert len(found["inputs"]) == 2 + 3 + 3
    before = found["inputs"]["trials.csv"]
    edit_trials_csv(study, T09={"fps": "30"})
    os.utime(study / "trials.csv", ns=(1, 1))
    write_manifest(study, results)
    after = json.loads((results / "manifest.json").read_text())["inputs"]
    assert after["trials.csv"] != before
    assert after["study.yaml"] == found["inputs"]["study.yaml"]
