"""`bluekoi watch`: what has changed is analysed, and the end leaves nothing half-written."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from click.testing import CliRunner

from bluekoi.cli import main
from bluekoi.cli.watch import study_file_states
from small_studies import edit_trials_csv, small_study


def wait_for(condition: Callable[[], bool], what: str, seconds: float = 400) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.2)


@contextmanager
def run_watch(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """`bluekoi watch study`, ended with the block."""
    words = [sys.executable, "-m", "bluekoi", "watch", "study", "--every", "0.3"]
    with subprocess.Popen(words, cwd=folder, stderr=subprocess.PIPE, text=True) as watching:
        try:
            yield watching
        finally:
            watching.terminate()


@pytest.mark.long
def test_a_new_trial_and_a_changed_row_are_analysed_and_the_end_is_clean(tmp_path):
    study = small_study(tmp_path / "study")
    shutil.copy(study / "trials.csv", tmp_path / "all.csv")
    rows = (study / "trials.csv").read_text().splitlines()
    (study / "trials.csv").write_text("\n".join(rows[:-1]) + "\n")
    results = tmp_path / "results/study"
    with run_watch(tmp_path) as watching:
        wait_for((results / "report.html").is_file, "no first report")
        wait_for(lambda: "count: 1" in (results / "watch.js").read_text(), "no first state")
        assert "T11" not in (results / "steady.csv").read_text()
        shutil.copy(tmp_path / "all.csv", study / "trials.csv")
        wait_for(lambda: "count: 2" in (results / "watch.js").read_text(), "no second run")
        assert "T11" in (results / "steady.csv").read_text()
        edit_trials_csv(study, T10={"fps": "15"})
        wait_for(lambda: "count: 3" in (results / "watch.js").read_text(), "no third run")
        edit_trials_csv(study, T10={"fps": "14"})
        wait_for(lambda: "Analysing" in (results / "watch.js").read_text(), "no fourth run")
        time.sleep(2)
        watching.send_signal(signal.SIGINT)
        assert watching.wait(120) == 0
        assert watching.stderr is not None
        assert "Traceback" not in watching.stderr.read()
    assert not list(results.rglob(".*-*"))
    assert not (results / "watch.html").exists()
    statuses = (results / "status").glob("*.json")
    assert {json.loads(path.read_text())["trial_id"] for path in statuses} == {"T09", "T10", "T11"}


@pytest.mark.long
def test_an_error_in_the_study_is_reported_and_the_next_change_waited_for(tmp_path):
    study = small_study(tmp_path / "study")
    good = (study / "trials.csv").read_text()
    (study / "trials.csv").write_text("trial_id\n")
    results = tmp_path / "results/study"
    with run_watch(tmp_path) as watching:
        script = results / "watch.js"
        wait_for(lambda: script.is_file() and "see the terminal" in script.read_text(), "no error")
        (study / "trials.csv").write_text(good)
        wait_for((results / "status/keypoints/T09.json").is_file, "no run after the error")
        watching.terminate()
        assert watching.wait(120) == 0


def test_a_folder_that_is_not_there_is_not_waited_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = sys.modules["bluekoi.cli.watch"]
    monkeypatch.setattr(module, "study_file_states", lambda *_: pytest.fail("it waits"))
    done = CliRunner().invoke(main, ["watch", str(tmp_path / "missing")])
    assert done.exit_code == 1
    assert f"{tmp_path / 'missing'}: found no such folder" in done.output
    assert list(tmp_path.iterdir()) == []


def test_the_state_of_a_study_leaves_its_results_and_hidden_files_out(tmp_path):
    study = small_study(tmp_path / "study")
    before = study_file_states(study, study / "results")
    (study / "results").mkdir()
    (study / "results/report.html").touch()
    (study / ".trials.csv.swp").touch()
    assert study_file_states(study, study / "results") == before
    os.utime(study / "trials.csv", (1e9, 1e9))
    assert study_file_states(study, study / "results") != before
