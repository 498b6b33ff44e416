"""Truths are sealed before the analysis and denied to the processes that analyse."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from bluekoi.errors import InputError
from validation import study_runs
from validation.sealing import open_truth, published_hashes, seal_truth

ROOT = Path(__file__).parents[2]


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    """One study without trials, and its truth under seal."""
    (tmp_path / "studies" / "S1").mkdir(parents=True)
    (tmp_path / "truth").mkdir()
    (tmp_path / "truth" / "S1.json").write_text('{"causes": []}')
    seal_truth(tmp_path, "S1")
    return tmp_path


def test_published_hashes_are_kept_when_another_truth_is_sealed(directory):
    (directory / "truth" / "S2.json").write_text('{"causes": [1]}')
    first = published_hashes(directory)["S1"]
    seal_truth(directory, "S2")
    assert list(published_hashes(directory)) == ["S1", "S2"]
    assert published_hashes(directory)["S1"] == first
    done = subprocess.run(["sha256sum", "-c", "truth.sha256"], cwd=directory, check=False)
    assert done.returncode == 0


def test_a_truth_changed_after_it_was_sealed_is_refused(directory):
    assert open_truth(directory, "S1") == {"causes": []}
    (directory / "truth" / "S1.json").write_text('{"causes": [1]}')
    with pytest.raises(InputError, match="as published"):
        open_truth(directory, "S1")


def test_a_process_and_its_children_cannot_read_a_denied_folder(directory):
    code = (
        "import subprocess, sys; from pathlib import Path\n"
        "from validation.isolation import deny_reading\n"
        "truth = Path(sys.argv[1]); print(deny_reading(truth))\n"
        "try:\n    (truth / 'S1.json').read_text(); print('read')\n"
        "except PermissionError: print('refused')\n"
        "cat = ['cat', str(truth / 'S1.json')]\n"
        "print(subprocess.run(cat, capture_output=True).returncode)\n"
        "print((truth.parent / 'studies').exists())\n"
    )
    command = [sys.executable, "-c", code, str(directory / "truth")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    kind, own, child, other = done.stdout.split()
    assert (own, other) == ("refused", "True")
    assert kind == "interpreter" or child != "0"


def read_truth(directory: Path, _name: str) -> str:
    """A task that reads what it must not."""
    try:
        return (directory / "truth" / "S1.json").read_text()
    except PermissionError:
        return "refused"


def test_workers_cannot_read_the_truths(directory):
    assert list(study_runs.map_in_isolated_processes(read_truth, directory, ["S1"], workers=1)) == [
        "refused"
    ]


def test_a_study_that_fails_does_not_stop_the_others(directory):
    line = next(iter(study_runs.measure_all(directory, 1)))
    assert "InputError" in line
    stored = json.loads((directory / "tracks/S1/measured.json").read_text())
    assert "study.yaml" in stored["failure"]
