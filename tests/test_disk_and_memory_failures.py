"""Full disk, read-only results folder, too little memory: a clear message, and nothing is lost."""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from bluekoi.errors import InputError
from bluekoi.files import write_text
from bluekoi.preparation.draft import read_draft
from bluekoi.preparation.draft_saving import save_draft
from bluekoi.stages.status import run_with_status
from bluekoi.workflow.plan import make_plan
from bluekoi.workflow.provenance import source_files
from small_studies import small_study

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    return small_study(tmp_path_factory.mktemp("machine") / "study")


@pytest.fixture
def mounted(tmp_path):
    """Mounts a small file system on a folder; skipped where that is not allowed."""
    folders = []

    def mount(size: str) -> Path:
        folder = tmp_path / f"disk{len(folders)}"
        folder.mkdir()
        options = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
        if shutil.which("mount") is None or subprocess.run(options, check=False).returncode:
            pytest.skip("file systems cannot be mounted here")
        folders.append(folder)
        return folder

    yield mount
    for folder in folders:
        subprocess.run(["umount", "-l", str(folder)], check=False)


def run_stage(name: str, study: Path, results: Path, *further: str, limit=None):
    command = [sys.executable, "-m", "bluekoi", "stage", name, "--study", str(study)]
    return subprocess.run(
        [*command, "--results", str(results), *further],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        preexec_fn=limit,
    )


def test_a_full_disk_is_said_and_leaves_no_half_file(study, mounted):
    disk = mounted("64k")
    results = disk / "results"
    (disk / "filler").write_bytes(b"x" * 40_000)
    done = run_stage("keypoints", study, results, "--trial", "T09")
    words = done.stderr + "".join(p.read_text() for p in results.rglob("status/keypoints/*.json"))
    assert "No space left on device" in words
    assert "Traceback" not in words
    assert not list(results.rglob("keypoints/*.csv"))
    assert not list(results.rglob(".*.csv"))
    (disk / "filler").unlink()
    subprocess.run(["mount", "-o", "remount,size=8m", str(disk)], check=True)
    assert run_stage("keypoints", study, results, "--trial", "T09").returncode == 0
    assert json.loads((results / "status/keypoints/T09.json").read_text())["ok"]


def test_what_stood_before_the_disk_was_full_stands_after(mounted):
    disk = mounted("64k")
    write_text(disk / "a.json", "whole")
    (disk / "filler").write_bytes(b"x" * 50_000)
    with pytest.raises(InputError, match=r"a\.json.*No space left on device"):
        write_text(disk / "a.json", "y" * 40_000)
    assert (disk / "a.json").read_text() == "whole"
    assert sorted(path.name for path in disk.iterdir()) == ["a.json", "filler"]


def test_a_file_size_limit_is_said_like_a_full_disk(study, tmp_path):
    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

    done = run_stage("keypoints", study, tmp_path / "r", "--trial", "T09", limit=small_files)
    reported = json.loads((tmp_path / "r/status/keypoints/T09.json").read_text())
    assert done.returncode == 0
    assert not reported["ok"]
    assert "File too large" in reported["message"]
    assert not list((tmp_path / "r").rglob("keypoints/*.csv"))


def test_results_that_are_read_only_are_reported_at_the_door(study, mounted, monkeypatch):
    disk = mounted("1m")
    (disk / "results").mkdir()
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    settings = {"study": str(study), "results": str(disk / "results"), "demo_folder": "d"}
    with pytest.raises(InputError, match=r"Read-only file system.*can be written to"):
        make_plan({**settings, "overlays": "none"})
    done = run_stage("keypoints", study, disk / "results", "--trial", "T09")
    assert done.returncode == 1
    assert "Read-only file system" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_study_in_a_read_only_folder_is_not_saved_and_says_so(mounted):
    disk = mounted("1m")
    new = read_draft(disk)
    (disk / "lab").mkdir()
    (disk / "lab/study.yaml").write_text("pool:\n  length_m: 2.6\n", encoding="utf-8")
    saved = read_draft(disk / "lab")
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    for draft, folder in ((new, disk), (replace(saved, values={}), disk / "lab")):
        with pytest.raises(InputError, match=r"Read-only file system.*nothing was saved"):
            save_draft(draft, folder)


def test_want_of_memory_is_a_word_on_the_trial_and_stops_nothing_else(tmp_path):
    (tmp_path / "half.csv").write_text("x")

    def hungry() -> dict:
        raise MemoryError

    status, products = tmp_path / "T1.json", (tmp_path / "half.csv",)
    run_with_status(status, "T1", hungry, source="videos/T1.mp4", products=products)
    reported = json.loads(status.read_text())
    assert not reported["ok"]
    assert reported["message"].startswith("videos/T1.mp4: not enough memory; run fewer jobs")
    assert not (tmp_path / "half.csv").exists()


@pytest.mark.skipif(not hasattr(resource, "RLIMIT_AS"), reason="no memory limits here")
@pytest.mark.long
def test_a_stage_in_too_little_memory_ends_and_can_be_done_again(study, tmp_path):
    def little() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (300 * 2**20, 300 * 2**20))

    done = run_stage("tracks", study, tmp_path / "r", "--trial", "T09", limit=little)
    assert done.returncode != 0 or (tmp_path / "r/status/T09.json").is_file()
    assert not list((tmp_path / "r").rglob("tracks/*.csv"))
    assert run_stage("keypoints", study, tmp_path / "r", "--trial", "T09").returncode == 0
    assert run_stage("tracks", study, tmp_path / "r", "--trial", "T09").returncode == 0
    assert json.loads((tmp_path / "r/status/T09.json").read_text())["ok"]


def test_the_overlays_do_not_depend_on_the_pages_code():
    found = source_files("stages.overlay")
    assert "report/overlay.py" in found
    assert "report/overlay_frame.py" in found
    pages = {"page.py", "page.html", "story.py", "tables.py", "trials.py", "media.py"}
    assert not [name for name in found if name.startswith("report/") and Path(name).name in pages]


def test_geometry_does_not_hang_on_smoothing_nor_tracks_on_the_check_of_distances():
    assert "smoothing/linear_gaussian.py" not in source_files("stages.geometry")
    assert "camera/rigid_length_check.py" not in source_files("stages.tracks")
    assert os.path.exists(ROOT / "pipeline/bluekoi/stages/geometry.py")


@pytest.mark.parametrize("results", [".", "keypoints", "motor", "../linked"])
def test_results_are_not_written_among_the_files_of_the_study(tmp_path, monkeypatch, results):
    study = small_study(tmp_path / "study")
    (tmp_path / "linked").symlink_to(study)
    monkeypatch.chdir(tmp_path)
    settings = {"study": "study", "demo_folder": "demo", "overlays": "none"}
    before = {path: path.read_bytes() for path in study.rglob("*") if path.is_file()}
    with pytest.raises(InputError, match="a folder of its own for the results"):
        make_plan({**settings, "results": str(study / results)})
    assert {path: path.read_bytes() for path in study.rglob("*") if path.is_file()} == before
    for fine in (".", "study/results"):
        make_plan({**settings, "results": fine})


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux alone")
@pytest.mark.parametrize("threads", [0, 1])
def test_several_trials_are_forked_unless_another_thread_might_hold_a_lock(
    study, tmp_path, threads
):
    words = ["keypoints", "--study", str(study), "--results", str(tmp_path)]
    words += [word for trial in ("T09", "T10") for word in ("--trial", trial)]
    program = f"""
import os, threading, time
forks = []
fork = os.fork
os.fork = lambda: forks.append(1) or fork()
from bluekoi.workflow.forkserver_client import limit_blas_to_one_thread
limit_blas_to_one_thread()
from bluekoi.workflow.stage_call import run_stage
for _ in range({threads}):
    threading.Thread(target=time.sleep, args=(60,), daemon=True).start()
assert run_stage({words!r}) == 0
print(len(forks))
"""
    run = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True,
                         check=True, timeout=120)  # fmt: skip
    assert int(run.stdout) == (0 if threads else 2)
    assert {p.stem for p in (tmp_path / "keypoints").glob("T??.csv")} == {"T09", "T10"}
