"""The Snakefile: which jobs run and run again, effects of a failed trial, and messages."""

from __future__ import annotations

import contextlib
import io
import json
import logging
import math
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner
from snakemake_interface_logger_plugins.common import LogEvent

from bluekoi.cli import main
from bluekoi.errors import InputError
from bluekoi.files import atomic_write
from bluekoi.integrate import compiled_system
from bluekoi.stages.compiling import precompile_model, precompile_model_with_effects
from bluekoi.stages.manifest import record_file_sizes_and_times
from bluekoi.stages.outcome import outcome
from bluekoi.stages.result_paths import ResultPaths
from bluekoi.study import load_study
from bluekoi.workflow import figure_sources, provenance
from bluekoi.workflow.figure_sources import figure_names
from bluekoi.workflow.forkserver_client import (
    EXIT_RUN_ENDED,
    FORKSERVER_SOCKET_VARIABLE,
    request_stage,
)
from bluekoi.workflow.lock import acquire_lock, remove_stale_locks, remove_temporary_files
from bluekoi.workflow.plan import make_plan
from bluekoi.workflow.progress import (
    SnakemakeMessageFilter,
    SnakemakeProgressHandler,
    killing_signal_name,
)
from bluekoi.workflow.remaining_time import (
    RemainingTimeEstimator,
    duration_text,
    durations_of_last_run_s,
)
from bluekoi.workflow.run_start import remove_job_rate_limit
from forked_snakemake import snakemake
from small_studies import edit_trials_csv, small_study

ROOT = Path(__file__).resolve().parents[1]
SETTINGS = {"results": None, "demo_folder": "studies/demo", "overlays": "none"}
JOBS_AFTER_TRACKS = {
    "steady": 1,
    "tuning": 1,
    "mismatch": 1,
    "figure": len(figure_names()),
    "report": 1,
}


class WorkflowCopy:
    """The workflow and its package, with a small study and its results."""

    took_s = math.nan  # of the run that made the results

    def __init__(self, root: Path) -> None:
        self.root = root
        shutil.copytree(ROOT / "config", root / "config")
        shutil.copy(ROOT / "Snakefile", root)
        (root / "pipeline").symlink_to(ROOT / "pipeline")  # what a run compiles serves other tests
        self.study = small_study(root / "study")

    def keep_package(self) -> None:
        """A copy of the package, compiled code included, but for files that are being written."""
        unfinished = shutil.ignore_patterns("*.tmp.*", "*.pyc.*")
        (self.root / "pipeline").unlink()
        shutil.copytree(ROOT / "pipeline", self.root / "pipeline", ignore=unfinished)

    def words(self, *arguments: str, results: str = "") -> list[str]:
        profile = ["--workflow-profile", "config/profiles/default"]
        named = [f"results={results}"] if results else []
        return ["--cores", "2", *profile, *arguments, "--config", "study=study", *named]

    def command(self, *arguments: str) -> list[str]:
        return [sys.executable, "-m", "snakemake", *self.words(*arguments)]

    def environment(self) -> dict[str, str]:
        return {**os.environ, "PYTHONPATH": str(self.root / "pipeline")}

    def snakemake(self, *arguments: str, results: str = "") -> subprocess.CompletedProcess[str]:
        return snakemake(self.words(*arguments, results=results), self.root, self.environment())

    def planned(self) -> dict[str, int]:
        """How many trials, or jobs, of each rule a run would process now, except `outcome`."""
        run = self.snakemake("--dry-run")
        rows = dict(re.findall(r"^(\w+) +(\d+)$", run.stdout + run.stderr, re.M))
        rows |= dict(re.findall(r"^(\w+) is due for (\d+)", run.stderr, re.M))
        return {rule: int(n) for rule, n in rows.items() if rule not in ("all", "total", "outcome")}


@pytest.mark.parametrize(
    ("load", "general"), [(precompile_model, False), (precompile_model_with_effects, True)]
)
def test_two_loaders_share_the_kernels_of_the_model(load, general, monkeypatch):
    """Two processes compile at the same time, each its own kernel."""
    asked, loaded = set(), compiled_system._load_compiled
    monkeypatch.setattr(
        compiled_system,
        "_load_compiled",
        lambda system, more: asked.add(more) or loaded(system, more),
    )
    compiled_system.compile_system.cache_clear()  # which keeps the kernels that it has loaded
    load()
    assert asked == {general}


@pytest.fixture(scope="module")
def finished_workflow(tmp_path_factory):
    """A home whose study has been run, with what was said."""
    home = WorkflowCopy(tmp_path_factory.mktemp("home"))
    start = time.monotonic()
    run = home.snakemake()
    home.took_s = time.monotonic() - start
    home.keep_package()
    return home, run


def copy_workflow(workflow: WorkflowCopy, root: Path) -> WorkflowCopy:
    """A home with the same study, results and records of Snakemake's."""
    fresh = WorkflowCopy.__new__(WorkflowCopy)
    fresh.root = Path(shutil.copytree(workflow.root, root))
    fresh.study = fresh.root / "study"
    return fresh


@pytest.fixture
def workflow(finished_workflow, tmp_path):
    """A fresh copy of that home."""
    return copy_workflow(finished_workflow[0], tmp_path / "home")


def modification_times(workflow: WorkflowCopy, pattern: str) -> dict[str, int]:
    """When each file of the results that matches a pattern was written, by name."""
    found = (workflow.root / "results/study").glob(pattern)
    return {path.name: path.stat().st_mtime_ns for path in found}


def append(path: Path, text: str) -> None:
    path.write_text(path.read_text() + text)


def test_a_study_runs_to_its_figures_and_says_little(finished_workflow):
    home, run = finished_workflow
    assert run.returncode == 0, run.stderr
    results = home.root / "results/study"
    tables = ("steady.csv", "coefficients.json", "table1.csv", "table2.csv")
    for name in ("geometry.json", *tables, "mismatch.json"):
        assert (results / name).is_file(), name
    for name in figure_names():
        assert (results / "figures" / f"{name}.pdf").is_file()
    assert "Traceback" not in run.stderr
    assert len(run.stderr.splitlines()) < 30
    assert re.search(r"^\[\d+/\d+\] keypoints", run.stderr, re.M)
    for stage, trial in (
        ("keypoints/01", "keypoints/T09"),
        ("tracks/01", "tracks/T09"),
        2 * ("tuning",),
    ):
        assert (results / "logs" / f"{stage}.log").is_file()
        assert (results / "benchmarks" / f"{trial}.tsv").is_file()


def test_nothing_runs_twice(workflow):
    assert workflow.planned() == {}
    assert "Everything is up to date." in workflow.snakemake().stderr


def test_the_code_of_one_figure_redraws_that_figure_alone(workflow):
    append(workflow.root / "pipeline/bluekoi/figures/fig3.py", "\n# changed\n")
    assert workflow.planned() == {"figure": 1, "report": 1}


def test_the_code_of_the_page_makes_the_page_alone(workflow):
    append(workflow.root / "pipeline/bluekoi/report/findings.py", "\n# changed\n")
    assert workflow.planned() == {"report": 1}


def test_the_code_of_the_distances_checks_them_again_and_searches(workflow):
    append(workflow.root / "pipeline/bluekoi/camera/rigid_length_check.py", "\n# changed\n")
    found = workflow.planned()
    assert found["geometry"] == found["mismatch"] == 1
    assert "tracks" not in found
    assert "tuning" not in found


def test_the_code_of_the_pose_maps_again_but_detects_nothing_again(workflow):
    append(workflow.root / "pipeline/bluekoi/camera/resection.py", "\n# changed\n")
    found = workflow.planned()
    assert found["tracks"] == 3
    assert "keypoints" not in found


def test_a_depth_that_is_not_given_is_reported_by_the_distances_before_the_tracks(workflow):
    text = (workflow.study / "study.yaml").read_text()
    (workflow.study / "study.yaml").write_text(re.sub(r" *keypoint_depth_m: .*\n", "", text))
    assert (
        workflow.planned() == {"keypoint_errors": 1, "geometry": 1, "tracks": 3} | JOBS_AFTER_TRACKS
    )


def test_the_code_of_a_stage_runs_it_and_what_follows_again(workflow):
    append(workflow.root / "pipeline/bluekoi/smoothing/linear_gaussian.py", "\n# changed\n")
    assert workflow.planned() == {"tracks": 3} | JOBS_AFTER_TRACKS


def test_a_changed_row_runs_its_trial_alone_and_what_depends_on_it(workflow):
    edit_trials_csv(workflow.study, T10={"head_length_m": "0.121"})
    assert (
        workflow.planned() == {"keypoint_errors": 1, "tracks": 1, "geometry": 1} | JOBS_AFTER_TRACKS
    )


def test_a_source_replaced_by_an_older_file_runs_its_trial_again(workflow):
    path = workflow.study / "keypoints/T10.csv"
    path.write_text(path.read_text().replace("0.99", "0.98"))
    os.utime(path, (1e9, 1e9))
    assert (
        workflow.planned()
        == {"keypoints": 1, "keypoint_errors": 1, "tracks": 1, "geometry": 1} | JOBS_AFTER_TRACKS
    )


def test_a_source_that_was_only_copied_again_runs_nothing_again(workflow):
    os.utime(workflow.study / "keypoints/T10.csv")
    os.utime(workflow.study / "motor/T11.csv")
    assert workflow.planned() == {}


@pytest.fixture(scope="module")
def finished_without_depth(finished_workflow, tmp_path_factory):
    """A home whose study states no depth, tracked again."""
    home = copy_workflow(finished_workflow[0], tmp_path_factory.mktemp("without_depth") / "home")
    text = (home.study / "study.yaml").read_text()
    (home.study / "study.yaml").write_text(re.sub(r" *keypoint_depth_m: .*\n", "", text))
    assert home.snakemake("--until", "steady").returncode == 0
    return home


@pytest.mark.long
def test_rows_in_another_order_track_nothing_again(finished_without_depth, tmp_path):
    home = copy_workflow(finished_without_depth, tmp_path / "home")
    before = modification_times(home, "tracks/*.csv")
    header, *rows = (home.study / "trials.csv").read_text().splitlines()
    (home.study / "trials.csv").write_text("\n".join([header, *rows[::-1]]) + "\n")
    assert "tracks is due" not in home.snakemake("--dry-run").stderr
    assert home.snakemake("--until", "steady").returncode == 0
    assert modification_times(home, "tracks/*.csv") == before


@pytest.mark.long
def test_without_a_depth_a_row_that_says_nothing_on_it_tracks_its_trial_alone(
    finished_without_depth, tmp_path
):
    home = copy_workflow(finished_without_depth, tmp_path / "home")
    before = modification_times(home, "tracks/*.csv")
    edit_trials_csv(home.study, T10={"power_pct": "99"})
    assert home.snakemake("--until", "steady").returncode == 0
    after = modification_times(home, "tracks/*.csv")
    assert {name for name in after if after[name] != before[name]} == {"T10.csv"}


def test_a_dry_run_lists_the_trials_whose_results_were_damaged(workflow):
    results = workflow.root / "results/study"
    for name in ("tracks/T10.csv", "keypoints/T11.csv"):
        (results / name).unlink()
    said = workflow.snakemake("--dry-run").stderr
    assert "keypoints is due for 1: T11\n" in said
    assert "tracks is due for 2: T10, T11\n" in said
    found = workflow.planned()
    assert found["keypoints"] == 1
    assert found["tracks"] == 2
    assert found["report"] == 1


def test_another_role_does_not_track_again(workflow):
    edit_trials_csv(workflow.study, T10={"role": "held_out"})
    found = workflow.planned()
    assert "tracks" not in found
    assert found["tuning"] == 1


def test_a_bad_trial_stops_only_itself_and_ends_the_run_with_a_word(workflow):
    path = workflow.study / "keypoints/T10.csv"
    path.write_text("")
    run = workflow.snakemake()
    assert run.returncode == 1
    said = [line for line in run.stderr.splitlines() if line.startswith("T10")]
    assert len(said) == 1
    assert "keypoints/T10.csv: found an empty file" in said[0]
    assert "Traceback" not in run.stderr
    results = workflow.root / "results/study"
    assert "T10" not in (results / "steady.csv").read_text()
    assert not (results / "tracks/T10.csv").exists()
    newest = (results / "status/T10.json").stat().st_mtime
    assert (results / "figures/fig3.png").stat().st_mtime > newest


@pytest.mark.long
def test_results_that_were_copied_and_lost_a_row_are_of_the_rows_that_are_left(workflow):
    """Snakemake's own records are of the first folder; the copy is newer than trials.csv."""
    path = workflow.study / "trials.csv"
    rows = path.read_text().splitlines()
    path.write_text("\n".join(row for row in rows if not row.startswith("T11")) + "\n")
    copy = workflow.root / "results/copy"
    shutil.copytree(workflow.root / "results/study", copy, copy_function=shutil.copyfile)
    assert workflow.snakemake("--until", "tuning", results="results/copy").returncode == 0
    assert "T11" not in (copy / "steady.csv").read_text()
    assert {path.stem for path in (copy / "simulations").glob("*.csv")} == {"T09", "T10"}
    assert not (copy / "mismatch.json").exists()  # of the three trials; the search was not run


@pytest.mark.long
def test_a_run_in_which_every_trial_fails_leaves_no_verdict_of_an_earlier_one(workflow):
    for path in (workflow.study / "keypoints").glob("*.csv"):
        path.write_text("")
    run = workflow.snakemake()
    assert run.returncode == 1
    assert "Verdict" not in run.stderr
    for name in ("mismatch.json", "coefficients.json", "report.html"):
        assert not (workflow.root / "results/study" / name).exists()


def test_a_report_older_than_the_verdict_is_not_shown_as_that_of_the_run(workflow, monkeypatch):
    results = workflow.root / "results/study"
    assert ResultPaths(results).report_is_current()
    later = (results / "report.html").stat().st_mtime + 60
    os.utime(results / "mismatch.json", (later, later))
    monkeypatch.chdir(workflow.root)
    shown = CliRunner().invoke(main, ["report", "study"])
    assert "This report is of an earlier run" in shown.output


def test_a_file_that_changes_while_the_run_works_is_named(workflow):
    results = workflow.root / "results/study"
    record_file_sizes_and_times(load_study(workflow.study), results)
    edit_trials_csv(workflow.study, T10={"head_length_m": "0.1211"})
    outcome(workflow.study, results)
    said = json.loads((results / "outcome.json").read_text())["warnings"]
    assert said[0].startswith("trials.csv changed while the run was at work")
    manifest = json.loads((results / "manifest.json").read_text())
    assert manifest["changed_during_run"] == ["trials.csv"]


def test_files_that_the_run_itself_makes_are_not_named_as_changed(workflow):
    results = workflow.root / "results/study"
    record_file_sizes_and_times(load_study(workflow.study), results, made_by_run=True)
    edit_trials_csv(workflow.study, T10={"head_length_m": "0.1212"})
    outcome(workflow.study, results)
    assert json.loads((results / "manifest.json").read_text())["changed_during_run"] == []


@pytest.mark.long
def test_a_result_that_was_deleted_comes_back(workflow):
    track = workflow.root / "results/study/tracks/T10.csv"
    before = track.read_bytes()
    track.unlink()
    assert workflow.snakemake("--until", "tracks").returncode == 0
    assert track.read_bytes() == before


def test_trials_whose_results_are_gone_or_cut_short_are_due(
    finished_workflow, tmp_path, monkeypatch
):
    shutil.copytree(finished_workflow[0].root, tmp_path / "home")
    monkeypatch.chdir(tmp_path / "home")
    monkeypatch.setattr(figure_sources, "PACKAGE_FOLDER", tmp_path / "home/pipeline/bluekoi")
    monkeypatch.setattr(provenance, "PACKAGE_FOLDER", tmp_path / "home/pipeline/bluekoi")
    plan = make_plan({**SETTINGS, "study": "study"})
    assert plan.due_trials_by_stage == {"keypoints": set(), "tracks": set(), "overlay": set()}
    track = plan.results / "tracks/T10.csv"
    track.write_bytes(track.read_bytes()[:100])
    (plan.results / "status/T11.json").write_text("{")
    again = make_plan({**SETTINGS, "study": "study"})
    assert again.due_trials_by_stage["tracks"] == {"T10", "T11"}
    assert again.due_trials_by_stage["keypoints"] == set()


def test_results_that_cannot_be_written_are_reported_at_the_door(
    finished_workflow, tmp_path, monkeypatch
):
    monkeypatch.chdir(finished_workflow[0].root)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="a results folder that can be written to"):
        make_plan({**SETTINGS, "study": "study", "results": str(tmp_path / "file" / "below")})


def test_snakemakes_own_report_has_captions_and_categories(workflow):
    assert workflow.snakemake("--report", "own.html").returncode == 0
    text = (workflow.root / "own.html").read_text()
    for words in ("The page", "Tables", "Figures", "Measured and simulated path of every trial"):
        assert words in text, words
    assert len(text) > 1_000_000  # figures and tables inside


def test_the_workflow_lints_clean(finished_workflow):
    run = finished_workflow[0].snakemake("--lint")
    assert run.returncode == 0
    assert "in a good condition" in run.stderr


def test_time_left_is_work_over_pace():
    timing = RemainingTimeEstimator()
    timing.set_expected_jobs({"tracks": 4, "all": 1, "total": 5})
    timing.job_started(1, "tracks", 0.0)
    timing.job_started(2, "tracks", 0.0)
    assert timing.remaining_s(5.0) is None
    assert timing.job_finished(1, 10.0) == "tracks"
    timing.job_finished(2, 10.0)
    assert (timing.finished_job_count, timing.total_job_count) == (2, 4)
    assert timing.remaining_s(10.0) == pytest.approx(10.0)  # 20 s of work, two at a time


def test_the_first_job_of_a_first_run_is_no_measure_of_its_time():
    timing = RemainingTimeEstimator()
    timing.set_expected_jobs({"demo": 24, "tracks": 24})
    for job in range(5):
        timing.job_started(job, "demo", 10.0 * job)
        timing.job_finished(job, 10.0 * job + 10.0)
        assert (timing.remaining_s(10.0 * job + 10.0) is None) == (job < 4)


def test_time_left_before_the_long_jobs_is_what_they_took_the_last_time(tmp_path):
    (tmp_path / "benchmarks/tracks").mkdir(parents=True)
    for name, s in (("tracks/T1", 5.0), ("tuning", 60.0), ("mismatch", 120.0)):
        (tmp_path / f"benchmarks/{name}.tsv").write_text(f"s\th:m:s\n{s}\t0:01\n")
    (tmp_path / "benchmarks/report.tsv").write_text("")
    timing = RemainingTimeEstimator(durations_of_last_run_s(tmp_path))
    timing.set_expected_jobs({"tracks": 1, "tuning": 1, "mismatch": 1})
    timing.job_started(1, "tracks", 0.0)
    timing.job_finished(1, 10.0)
    assert timing.remaining_s(10.0) == pytest.approx(2 * 180.0)  # twice as slow as the last time


def test_a_single_job_that_takes_longer_than_foreseen_is_not_said_to_end_soon():
    timing = RemainingTimeEstimator({"tracks": 1.0, "mismatch": 10.0})
    timing.set_expected_jobs({"tracks": 1, "mismatch": 1})
    timing.job_started(1, "tracks", 0.0)
    timing.job_finished(1, 1.0)
    timing.job_started(2, "mismatch", 1.0)
    assert timing.remaining_s(6.0) == pytest.approx(5.0)
    assert timing.remaining_s(30.0) is None


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_long_stage_is_reported_with_the_last_line_of_its_log(tmp_path):
    (tmp_path / "mismatch.log").write_text("baseline\nrefits with \x1b[31mstall\n")
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := Terminal())
    progress.emit(log_record(logging.INFO, "", event=LogEvent.RUN_INFO, stats={"mismatch": 1}))
    found = {"event": LogEvent.JOB_INFO, "jobid": 1, "rule_name": "mismatch"}
    progress.emit(log_record(logging.INFO, "", **found, log=[str(tmp_path / "mismatch.log")]))
    deadline = time.monotonic() + 10
    while stream.getvalue().count("refits with ?[31mstall") < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    assert stream.getvalue().count("[0/1] mismatch: refits with ?[31mstall") >= 2
    progress.print_final_summary()
    progress.ticker.join(10)
    assert not progress.ticker.is_alive()


def test_a_run_ends_with_the_warnings_of_trials_and_search_and_the_verdict(tmp_path):
    (tmp_path / "outcome.json").write_text(json.dumps({"warnings": ["T1: fps?"]}))
    found = {"sentence": "The clock is wrong.", "warnings": ["Look at T2."]}
    (tmp_path / "mismatch.json").write_text(json.dumps(found))
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := io.StringIO())
    progress.print_final_summary()
    assert stream.getvalue().splitlines() == [
        "Warning: T1: fps?", "Warning: Look at T2.", "Verdict: The clock is wrong.",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("s", "text"), [(1, "5 s"), (61, "65 s"), (100, "2 min"), (4800, "80 min")]
)
def test_times_are_said_as_a_person_does(s, text):
    assert duration_text(s) == text


def test_a_folder_at_work_is_held_and_let_go_with_the_process(tmp_path):
    handle = acquire_lock(tmp_path)
    with pytest.raises(InputError, match=f"another run at work .* end it .process {os.getpid()}"):
        acquire_lock(tmp_path)
    handle.close()
    acquire_lock(tmp_path).close()


@pytest.mark.skipif(sys.platform != "linux", reason="a parent's end is a signal on Linux alone")
def test_snakemake_ends_with_the_command_that_started_it_however_that_ended():
    child = "from bluekoi.cli.snakemake_launcher import end_with_parent as e; import time; e(); "
    child += "print('up', flush=True); time.sleep(60)"
    parent = "import subprocess, sys; print(subprocess.Popen([sys.executable, '-c', sys.argv[1]])"
    parent += ".pid, flush=True); import time; time.sleep(60)"
    run = subprocess.Popen([sys.executable, "-c", parent, child], stdout=subprocess.PIPE, text=True)
    first, second = run.stdout.readline(), run.stdout.readline()
    pid = int(first if first.strip().isdigit() else second)
    run.kill()
    run.wait()
    deadline = time.monotonic() + 20
    while Path(f"/proc/{pid}").exists() and time.monotonic() < deadline:
        if "Z" in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]:
            break
        time.sleep(0.05)
    else:
        assert not Path(f"/proc/{pid}").exists()


def test_results_of_trials_that_left_the_study_are_removed(workflow):
    results = workflow.root / "results/study"
    for folder in ("tracks", "status", "extended"):
        source = next((results / folder).glob("T10.*"))
        shutil.copy(source, source.with_name(source.name.replace("T10", "T99")))
    assert workflow.snakemake().returncode == 0
    assert not list(results.rglob("T99*"))
    assert (results / "tracks/T10.csv").is_file()


def test_a_job_whose_run_was_killed_ends_without_results(workflow):
    """It would write what is true of the study as it was into the folder of the next run."""
    results = workflow.root / "results/study"
    (results / "mismatch.json").unlink()
    run = started_jobs(workflow)
    stage = wait_for_stage_process(run, "mismatch")
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    deadline = time.monotonic() + 20
    while Path(f"/proc/{stage}").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not Path(f"/proc/{stage}").exists()
    assert not (results / "mismatch.json").exists()


def test_a_job_without_preloaded_process_runs_its_stage_itself(tmp_path, monkeypatch):
    address = tmp_path / "socket"
    monkeypatch.setenv(FORKSERVER_SOCKET_VARIABLE, str(address))
    assert request_stage(["steady"]) == EXIT_RUN_ENDED  # which removed its socket
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(address))
    assert request_stage(["steady"]) is None  # it was killed and its socket stayed behind


def test_only_locks_on_our_own_results_are_stale(tmp_path):
    (tmp_path / "0.output.lock").write_text("results/a/steady.csv\nstudies/a/x\n")
    (tmp_path / "1.output.lock").write_text("results/ab/steady.csv\n")
    assert remove_stale_locks(tmp_path, Path("results/a")) == [tmp_path / "0.output.lock"]
    assert (tmp_path / "1.output.lock").exists()


def test_half_written_files_of_a_killed_run_are_swept_up(tmp_path):
    (tmp_path / "figures").mkdir()
    with atomic_write(tmp_path / "figures/fig3.png") as temporary:
        name = temporary.name
    (tmp_path / "figures/fig3.png").rename(left := tmp_path / "figures" / name)
    (tmp_path / "figures/.hidden").touch()
    assert remove_temporary_files(tmp_path) == [left]
    assert [path.name for path in (tmp_path / "figures").iterdir()] == [".hidden"]


def test_a_second_run_on_the_same_folder_is_refused_in_words(workflow):
    handle = acquire_lock(workflow.root / "results/study")
    run = workflow.snakemake()
    handle.close()
    assert run.returncode == 1
    assert "another run at work in this folder" in run.stderr
    assert "Traceback" not in run.stderr


def result_contents(workflow: WorkflowCopy) -> dict[str, bytes]:
    """Every result without dates in it, by name."""
    root = workflow.root / "results/study"
    kinds = (".csv", ".json", ".png", ".pdf", ".html")
    kept = [path for path in root.rglob("*") if path.suffix in kinds]
    return {str(path.relative_to(root)): path.read_bytes() for path in kept}


def started_jobs(workflow: WorkflowCopy) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        workflow.command(),
        cwd=workflow.root,
        env=workflow.environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def delete_records(workflow: WorkflowCopy) -> None:
    shutil.rmtree(workflow.root / "results")
    shutil.rmtree(workflow.root / ".snakemake")


@pytest.mark.long
def test_killed_at_twenty_moments_and_started_again_the_results_are_the_same(
    finished_workflow, workflow
):
    """Each kill hits a run at work; one that ends before is compared and started again."""
    undisturbed, rng, kills = result_contents(finished_workflow[0]), random.Random(7), 0
    delete_records(workflow)
    while kills < 20:
        run = started_jobs(workflow)
        try:
            assert run.wait(rng.uniform(0.0, 0.4) * finished_workflow[0].took_s) == 0
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            kills += 1
            continue
        assert result_contents(workflow) == undisturbed
        delete_records(workflow)
    last = workflow.snakemake()
    assert last.returncode == 0, last.stderr
    assert result_contents(workflow) == undisturbed
    assert not list((workflow.root / "results").rglob(".*-*"))


def wait_for_stage_process(run: subprocess.Popen[bytes], name: str) -> int:
    """Process id of a stage of a run, waited for."""
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline:
        for path in Path("/proc").glob("[0-9]*/cmdline"):
            with contextlib.suppress(OSError):
                words = path.read_bytes().split(b"\0")
                own = os.getsid(int(path.parent.name)) == run.pid
                if own and words[:1] == [b"python3"] and name.encode() in words:
                    return int(path.parent.name)
        time.sleep(0.005)
    raise AssertionError(f"no stage {name} at work")


def wait_for_trial_process(run: subprocess.Popen[bytes], name: str) -> int:
    """Process id of the process that computes one trial of a stage of a run, waited for.

    It is forked by the process of its batch, which the preloaded process (a child of the run) has
    forked.
    """
    wait_for_stage_process(run, name)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        parents: dict[int, int] = {}
        servers = set()
        for path in Path("/proc").glob("[0-9]*/stat"):
            with contextlib.suppress(OSError):
                pid, parent = int(path.parent.name), path.read_text().rpartition(")")[2].split()[1]
                parents[pid] = int(parent)
                if (
                    int(parent) == run.pid
                    and b"forkserver" in (path.parent / "cmdline").read_bytes()
                ):
                    servers.add(pid)
        for pid, parent in parents.items():
            if parents.get(parent) in servers:
                return pid
    raise AssertionError(f"no trial of stage {name} at work")


@pytest.fixture
def with_default_sigint() -> Iterator[None]:
    """What a shell starts in the background ignores Ctrl-C, and so does all that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="no list of processes here")
def test_ctrl_c_ends_the_run_in_words_with_130_and_it_goes_on_later(workflow, with_default_sigint):
    edit_trials_csv(workflow.study, T10={"head_length_m": "0.121"})
    command = [sys.executable, "-m", "bluekoi", "run", "study", "--cores", "2"]
    run = subprocess.Popen(command, cwd=workflow.root, env=workflow.environment(),
                           stderr=subprocess.PIPE, start_new_session=True)  # fmt: skip
    wait_for_stage_process(run, "tracks")
    os.killpg(run.pid, signal.SIGINT)
    said = run.communicate(timeout=120)[1].decode()
    assert run.returncode == 130, said
    assert said.count("Interrupted. What is done is kept") == 1
    assert "Traceback" not in said
    assert workflow.planned()["tracks"] == 1


@pytest.mark.long
@pytest.mark.parametrize("after_s", [1.2, 2.0, 2.6])
def test_ctrl_c_while_snakemake_starts_and_plans_ends_it_in_words(
    workflow, with_default_sigint, after_s
):
    command = [sys.executable, "-m", "bluekoi", "run", "study", "--cores", "2"]
    run = subprocess.Popen(command, cwd=workflow.root, env=workflow.environment(),
                           stderr=subprocess.PIPE, start_new_session=True)  # fmt: skip
    time.sleep(after_s)
    os.killpg(run.pid, signal.SIGINT)
    said = run.communicate(timeout=120)[1].decode()
    # a shell shows 130 for both: Python ends by the signal itself where it arrives inside exec()
    interrupted = run.returncode in (130, -signal.SIGINT)
    assert run.returncode == 0 or interrupted, said
    ended_before = "Report: " in said  # the signal met a Python that was leaving
    assert said.count("Interrupted.") == (interrupted and not ended_before)
    assert "Traceback" not in said


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="no list of processes here")
def test_a_worker_killed_for_memory_costs_its_own_trial_alone_and_only_till_the_next_run(
    finished_workflow, workflow
):
    delete_records(workflow)
    run = subprocess.Popen(workflow.command(), cwd=workflow.root, env=workflow.environment(),
                           stderr=subprocess.PIPE, start_new_session=True)  # fmt: skip
    os.kill(wait_for_trial_process(run, "tracks"), signal.SIGKILL)
    said = run.communicate(timeout=600)[1].decode()
    assert run.returncode == 1
    assert "killed from outside (SIGKILL), by a person or for want of memory" in said
    assert "Traceback" not in said
    assert len(list((workflow.root / "results/study/tracks").glob("*.csv"))) == 2
    assert not (workflow.root / "results/study/steady.csv").exists()
    assert workflow.planned()["tracks"] == 1
    assert workflow.snakemake().returncode == 0
    assert result_contents(workflow) == result_contents(finished_workflow[0])


def log_record(level, message, **more):
    made = logging.LogRecord("snakemake.logging", level, "", 0, message, (), None)
    made.__dict__.update(more)
    return made


def test_snakemake_keeps_its_own_words_until_the_run_begins(tmp_path):
    hush = SnakemakeMessageFilter(SnakemakeProgressHandler(tmp_path / "report.html", io.StringIO()))
    lint = log_record(logging.INFO, "your workflow is in a good condition")
    assert hush.filter(lint)
    assert not hush.filter(log_record(logging.INFO, "x", event=LogEvent.WORKFLOW_STARTED))
    assert not hush.filter(log_record(logging.INFO, "Select jobs to execute..."))
    assert hush.filter(log_record(logging.ERROR, "MissingInputException"))


def test_a_run_interrupted_while_it_plans_is_reported_in_one_line_without_a_traceback(tmp_path):
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := io.StringIO())
    hush = SnakemakeMessageFilter(progress)
    hush.filter(log_record(logging.INFO, "x", event=LogEvent.WORKFLOW_STARTED))
    loop = "Traceback (most recent call last):\nRuntimeError: Cannot close a running event loop"
    assert hush.filter(log_record(logging.ERROR, loop))
    stop = log_record(
        logging.ERROR, loop.replace("RuntimeError", "KeyboardInterrupt\n\nRuntimeError")
    )
    progress.emit(stop)
    assert not hush.filter(stop)
    assert not hush.filter(log_record(logging.ERROR, loop))
    assert stream.getvalue().count("Interrupted. What is done is kept") == 1


def test_a_stage_that_ends_in_an_error_shows_its_log(tmp_path):
    (tmp_path / "tuning.log").write_text("results: found no trial; expected one.\n")
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := io.StringIO())
    found = {"event": LogEvent.JOB_ERROR, "rule_name": "tuning", "log": [tmp_path / "tuning.log"]}
    progress.emit(log_record(logging.ERROR, "Error in rule", **found))
    assert "found no trial; expected one." in stream.getvalue()
    assert "stage tuning" in stream.getvalue()


def test_a_locked_folder_is_reported_with_its_cure(tmp_path):
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := io.StringIO())
    progress.emit(log_record(logging.ERROR, "Error: Directory cannot be locked. Please make sure"))
    assert "snakemake --unlock" in stream.getvalue()


@pytest.mark.parametrize(
    "end", ["died with <Signals.SIGKILL: 9>.", "returned non-zero exit status 137."]
)
def test_a_killed_stage_is_reported_with_what_to_do(tmp_path, end):
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := io.StringIO())
    progress.emit(log_record(logging.ERROR, f"Command 'python3' {end}", event=LogEvent.ERROR))
    assert "killed from outside (SIGKILL)" in stream.getvalue()
    assert "what is done is kept" in stream.getvalue()


def test_a_stage_that_ends_by_itself_was_not_killed():
    assert killing_signal_name("Command 'python3' returned non-zero exit status 1.") == ""
    assert killing_signal_name("Command 'python3' returned non-zero exit status 255.") == ""


def test_an_interrupted_run_says_so_once_and_blames_no_stage(tmp_path):
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := io.StringIO())
    for _ in range(2):
        text = "Command 'python3' died with <Signals.SIGINT: 2>."
        progress.emit(log_record(logging.ERROR, text, event=LogEvent.ERROR))
        found = {"event": LogEvent.JOB_ERROR, "rule_name": "tracks", "log": []}
        progress.emit(log_record(logging.ERROR, "", **found))
    assert stream.getvalue() == ("Interrupted. What is done is kept; start again and it goes on.\n")


def test_a_stage_that_a_library_ends_on_ctrl_c_is_not_blamed_either(tmp_path):
    (tmp_path / "geometry.log").write_text("SystemError: in a callback\nKeyboardInterrupt\n")
    progress = SnakemakeProgressHandler(tmp_path / "report.html", stream := io.StringIO())
    found = {"rule_name": "geometry", "log": [tmp_path / "geometry.log"]}
    progress.emit(log_record(logging.ERROR, "", event=LogEvent.JOB_ERROR, **found))
    assert stream.getvalue() == ("Interrupted. What is done is kept; start again and it goes on.\n")


@pytest.mark.parametrize(("here", "limited"), [(True, False), (False, True)])
def test_jobs_a_second_are_limited_on_a_cluster_only(*, here: bool, limited: bool) -> None:
    workflow = SimpleNamespace(
        local_exec=here, scheduler=SimpleNamespace(job_rate_limiter=object())
    )
    remove_job_rate_limit(workflow)
    assert (workflow.scheduler.job_rate_limiter is not None) == limited
