"""Studies measured and analysed, many at a time; what is there already is kept.

DIR/studies/ID   as a generator wrote them        DIR/truth/ID.json   never read here
DIR/tracks/ID    results folder up to steady.csv  DIR/verdicts/LABEL/ID.json

The processes that measure and analyse are denied reading DIR/truth (`isolation`).
"""

from __future__ import annotations

import inspect
import json
import logging
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from .isolation import deny_reading

MEASURED_STAGES = ("keypoints", "keypoint_errors", "geometry", "tracks", "steady")
"""Stages from a study folder to its tracks."""
ANALYSED_STAGE = "mismatch"
SCRATCH_FOLDER = "scratch"


def study_names(directory: Path) -> list[str]:
    """Names of the studies below DIR/studies, in alphabetical order."""
    return sorted(path.name for path in (directory / "studies").iterdir() if path.is_dir())


def measure_all(directory: Path, workers: int) -> Iterator[str]:
    """Measure every study that has no tracks yet; a line for each as it ends."""
    names = [name for name in study_names(directory) if not _has_tracks(directory, name)]
    yield from map_in_isolated_processes(measure, directory, names, workers=workers)


def analyse_all(directory: Path, label: str, workers: int, *, only: str = "") -> Iterator[str]:
    """Analyse every measured study without a verdict under `label`; a line for each as it ends."""
    names = [
        name
        for name in measured_names(directory)
        if only in name and not verdict_path(directory, label, name).is_file()
    ]
    yield from map_in_isolated_processes(
        partial(_analyse_and_report, label), directory, names, workers=workers
    )


def _analyse_and_report(label: str, directory: Path, name: str) -> str:
    return analyse(directory, label, name)


def verdict_path(directory: Path, label: str, name: str) -> Path:
    """Where the verdict of one study stands."""
    return directory / "verdicts" / label / f"{name}.json"


def measured_names(directory: Path) -> list[str]:
    """Names of the studies that have tracks, in alphabetical order."""
    return [name for name in study_names(directory) if _has_tracks(directory, name)]


def _has_tracks(directory: Path, name: str) -> bool:
    return (directory / "tracks" / name / "measured.json").is_file()


def measure(directory: Path, name: str) -> str:
    """Run the stages up to steady.csv on one study; its processor times in measured.json."""
    results = directory / "tracks" / name
    shutil.rmtree(results, ignore_errors=True)
    results.mkdir(parents=True)
    study = directory / "studies" / name
    times, failure = {}, ""
    try:
        for stage in MEASURED_STAGES:
            begin = time.process_time()
            _run_stage(stage, study, results)
            times[stage] = time.process_time() - begin
    except Exception as error:  # one study must not stop the others
        failure = repr(error)
    (results / "measured.json").write_text(json.dumps({"cpu_s": times, "failure": failure}))
    return f"{name} measured in {sum(times.values()):.1f} s {failure}".rstrip()


def analyse(directory: Path, label: str, name: str) -> str:
    """Run the finder on one measured study; its mismatch.json and processor time are kept."""
    begin, failure, content = time.process_time(), "", {}
    with tempfile.TemporaryDirectory() as scratch:
        results = Path(scratch) / name
        try:
            shutil.copytree(directory / "tracks" / name, results)
            _run_stage(ANALYSED_STAGE, directory / "studies" / name, results)
            content = json.loads((results / "mismatch.json").read_text())
        except Exception as error:  # one study must not stop the others
            logging.getLogger(__name__).exception("study %s", name)
            failure = repr(error)
    cpu_s = time.process_time() - begin
    path = verdict_path(directory, label, name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"cpu_s": cpu_s, "failure": failure, "mismatch": content}))
    causes = ", ".join(f"{c['name']} {c['weight']:.2f}" for c in content.get("causes", ()))
    return f"{name} {cpu_s:.1f} s: {causes or content.get('verdict', failure)}"


def _run_stage(name: str, study: Path, results: Path) -> None:
    """Run a stage, once or for every trial, as its arguments say."""
    from bluekoi.study import load_study  # noqa: PLC0415  the worker's own import

    run: Callable[..., Any] = getattr(import_module(f"bluekoi.stages.{name}"), name)
    if "trial_id" not in inspect.signature(run).parameters:
        run(study, results)
        return
    for trial in load_study(study).trials:
        run(study, results, trial.trial_id)


def _isolate(directory: Path) -> None:
    """Deny this process the truths; its temporary files go where it can read them."""
    tempfile.tempdir = str(directory / SCRATCH_FOLDER)
    deny_reading(directory / "truth")


def map_in_isolated_processes(
    task: Callable[[Path, str], str], directory: Path, names: Sequence[str], *, workers: int
) -> Iterator[str]:
    """Result of a task for each study as it ends, in processes that cannot read DIR/truth."""
    for name in (
        "tracks",
        "truth",
        "verdicts",
        SCRATCH_FOLDER,
    ):  # what is made later cannot be read
        (directory / name).mkdir(exist_ok=True)
    with ProcessPoolExecutor(
        workers,
        mp_context=get_context("forkserver"),
        initializer=_isolate,
        initargs=(directory.resolve(),),
    ) as pool:
        for future in as_completed([pool.submit(task, directory, name) for name in names]):
            yield future.result()
