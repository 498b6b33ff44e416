"""Plan of a run: study, results folder, trials that are out of date, fingerprints of the code.

The Snakefile asks a `Plan` for inputs and for what makes a job run again. Trials are processed in
batches: a batch has a marker file, and runs when one of its trials is out of date (`freshness`).
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, Any

from ..errors import input_error
from ..stages.freshness import (
    is_fresh,
    short_hash,
    status_file_path,
    trial_inputs_hash,
    trial_row_as_dict,
    without_keys,
)
from ..stages.result_paths import ResultPaths
from ..study import Study, load_study
from .figure_sources import figure_fingerprint, figure_names, figure_title_and_caption
from .provenance import source_fingerprint

RESULT_FILES = (
    "geometry.json", "steady.csv", "coefficients.json", "table1.csv", "table2.csv",
    "mismatch.json", "report.html",
)  # fmt: skip
RESULT_FOLDERS = (
    "benchmarks", "extended", "figures", "keypoints", "logs", "overlays", "poses", "simulations",
    "status", "steady", "tracks",
)  # fmt: skip
MIN_TRIALS_PER_BATCH, MAX_BATCHES = 6, 50
"""Trials with keypoint files share a process: six, or more where that would make over 50 jobs. A
trial takes 0.3 s, a process of its own as much again. A video takes longer and is a job of its own.
"""
DRY_RUN_DUE_MARKER_SUFFIX = "-due"
"""Ending of the marker of a batch that has to run, in a dry run: a missing file is listed there."""
FORBIDDEN_PATH_CHARACTERS = {*"{}<>", *map(chr, range(32))}
"""Characters that Snakemake does not allow in the path of a results folder."""


@dataclass(frozen=True)
class RunPlan:
    """One run; folders as given, so that logs and reports show what the user wrote.

    dry_run: nothing is run, so nothing may be removed either.
    """

    folder: Path
    results: Path
    study: Study
    is_demo: bool
    overlaid: str
    dry_run: bool = True
    lock: IO[str] | None = None

    @property
    def all_trial_ids(self) -> list[str]:
        """Ids of all trials, in the order of trials.csv."""
        return [trial.trial_id for trial in self.study.trials]

    def overlay_trial_ids(self) -> list[str]:
        """Ids of the trials that get an overlay video."""
        filmed = [t.trial_id for t in self.study.trials if not t.reads_keypoints]
        return {"all": self.all_trial_ids, "filmed": filmed, "none": []}[self.overlaid]

    @property
    def detects_outlines(self) -> bool:
        """Whether the detector of a rigid body's outline is run on some of the trials."""
        how = self.study.setup.detection
        filmed = any(not trial.reads_keypoints for trial in self.study.trials)
        return filmed and how.source == "silhouette" and how.body != "bending"

    @cached_property
    def batches(self) -> dict[str, list[str]]:
        """Trials that share a process, by the name of their batch."""
        size = max(MIN_TRIALS_PER_BATCH, -(-len(self.all_trial_ids) // MAX_BATCHES))
        read = [t.trial_id for t in self.study.trials if t.reads_keypoints]
        groups = [read[first : first + size] for first in range(0, len(read), size)]
        groups += [[t.trial_id] for t in self.study.trials if not t.reads_keypoints]
        return {f"{number:02d}": group for number, group in enumerate(groups, 1)}

    @cached_property
    def due_trials_by_stage(self) -> dict[str, set[str]]:
        """Trials whose results of a stage are missing, damaged or made from other inputs."""
        keypoints = self._trials_due_here_or_upstream("keypoints", set(), self.all_trial_ids)
        tracks = self._trials_due_here_or_upstream("tracks", keypoints, self.all_trial_ids)
        overlay = self._trials_due_here_or_upstream("overlay", tracks, self.overlay_trial_ids())
        return {"keypoints": keypoints, "tracks": tracks, "overlay": overlay}

    def _trials_due_here_or_upstream(
        self, stage: str, before: set[str], ids: list[str]
    ) -> set[str]:
        """Trials due in a stage, or in the stage before it."""
        layout, code = ResultPaths(self.results), self.code_fingerprint(stage)

        def fresh(name: str) -> bool:
            inputs = trial_inputs_hash(stage, self.study, self.study.trial(name), layout, code)
            return is_fresh(status_file_path(stage, layout, name), self.results, inputs)

        return {name for name in ids if name in before or not fresh(name)}

    def batch_marker_files(self, stage: str) -> list[str]:
        """Files that stand for a stage done for all trials, one per batch.

        A dry run names those that are due differently, so that they count as missing.
        """
        wanted = set(self.overlay_trial_ids() if stage == "overlay" else self.all_trial_ids)
        return [
            self._batch_marker_file(stage, name)
            for name, ids in self.batches.items()
            if wanted & set(ids)
        ]

    def _batch_marker_file(self, stage: str, batch: str) -> str:
        due = self.dry_run and self.due_trials_by_stage[stage] & set(self.batches[batch])
        return str(
            self.results
            / f"status/batches/{stage}-{batch}{DRY_RUN_DUE_MARKER_SUFFIX if due else ''}"
        )

    def remove_due_marker_files(self) -> None:
        """Remove the markers of batches with a trial that is out of date."""
        for stage, due in self.due_trials_by_stage.items():
            for batch in (name for name, ids in self.batches.items() if due & set(ids)):
                Path(self._batch_marker_file(stage, batch)).unlink(missing_ok=True)

    def batch_trial_options(self, stage: str) -> Any:
        """Input function: options that name the trials of a batch."""

        def options(wildcards: Any) -> str:
            ids = self.batches[wildcards.batch.removesuffix(DRY_RUN_DUE_MARKER_SUFFIX)]
            wanted = set(self.overlay_trial_ids() if stage == "overlay" else ids)
            return " ".join(f"--trial={name}" for name in ids if name in wanted)

        return options

    def keypoints_marker_file(self, wildcards: Any) -> str:
        """Marker of a batch's keypoints."""
        return self._batch_marker_file(
            "keypoints", wildcards.batch.removesuffix(DRY_RUN_DUE_MARKER_SUFFIX)
        )

    def tracks_marker_file(self, wildcards: Any) -> str:
        """Marker of a batch's tracks."""
        return self._batch_marker_file(
            "tracks", wildcards.batch.removesuffix(DRY_RUN_DUE_MARKER_SUFFIX)
        )

    def demo_recording_files(self, wildcards: Any) -> list[str]:
        """Files of the demo study that a batch needs; any other study has its files already."""
        if not self.is_demo:
            return []
        trials = [
            self.study.trial(name)
            for name in self.batches[wildcards.batch.removesuffix(DRY_RUN_DUE_MARKER_SUFFIX)]
        ]
        return [
            str(self.folder / name) for t in trials for name in (*t.sources, t.motor_log) if name
        ]

    @property
    def stage_options(self) -> str:
        """Options of every stage: where the study and the results are."""
        return f"--study={shlex.quote(str(self.folder))} --results={shlex.quote(str(self.results))}"

    def targets(self) -> list[str]:
        """Files that a run is made for."""
        stages = [
            path for stage in self.due_trials_by_stage for path in self.batch_marker_files(stage)
        ]
        return [
            *stages,
            *(str(self.results / name) for name in RESULT_FILES),
            *self.figure_png_files(),
        ]

    def memory_mb(self, base: int, each: int) -> int:
        """Memory to ask a cluster for, of a stage that holds all trials at once."""
        return base + each * len(self.all_trial_ids)

    def figure_png_files(self) -> list[str]:
        """Pictures of all figures."""
        return [str(self.results / f"figures/{name}.png") for name in figure_names()]

    def keypoint_errors_file(self) -> list[str]:
        """File with the errors of keypoint files, where trials are read from such files."""
        read = any(trial.reads_keypoints for trial in self.study.trials)
        return [str(ResultPaths(self.results).keypoint_errors)] if read else []

    def keypoint_depth_file(self) -> list[str]:
        """File with the estimated depth of the keypoints, where study.yaml does not give it."""
        return (
            []
            if self.study.setup.robot.keypoint_depth_given
            else [str(self.results / "geometry.json")]
        )

    def extra_figure_inputs(self, wildcards: Any) -> list[str]:
        """What a figure is drawn from beside the fits and the search."""
        return [str(self.results / "geometry.json")] if wildcards.figure == "geometry" else []

    def code_fingerprint(self, stage: str) -> str:
        """Fingerprint of all source files that a stage runs through."""
        return source_fingerprint(f"stages.{stage}")

    def figure_fingerprint(self, wildcards: Any) -> str:
        """Fingerprint of one figure's own file and of what it draws with."""
        return figure_fingerprint(wildcards.figure)

    def figure_title_and_caption(self, wildcards: Any) -> dict[str, str]:
        """Title and caption of a figure, read from its file without running it."""
        return figure_title_and_caption(wildcards.figure)

    def geometry_fingerprint(self) -> str:
        """Fingerprint of what the check of the rigid distances depends on beside keypoints."""
        heads = sorted((trial.trial_id, trial.head_length_m) for trial in self.study.trials)
        setup = self.study.setup.model_dump(mode="json")
        return short_hash(
            heads, without_keys(setup, "detection"), self.study.setup.robot.keypoint_depth_given
        )

    def fit_fingerprint(self) -> str:
        """Fingerprint of what the fits depend on beside tracks: setup, conditions, roles."""
        rows = [trial_row_as_dict(trial) for trial in self.study.trials]
        return short_hash(rows, without_keys(self.study.setup.model_dump(mode="json"), "detection"))


def make_plan(settings: Mapping[str, Any]) -> RunPlan:
    """Plan of a run by its checked settings; the demo's study files are laid out if need be.

    Raises: InputError with all that is wrong with the study, or where the results cannot be
    written.
    """
    is_demo = settings["study"] == "demo" and not Path("demo/study.yaml").is_file()
    folder = Path(settings["demo_folder"] if is_demo else settings["study"])
    if is_demo:
        _write_demo_study_files(folder)
    study = load_study(folder)
    results = Path(settings["results"] or Path("results") / folder.resolve().name)
    check_results_name(results)
    _check_results_outside_study(study, results)
    _prepare_results_folder(results)
    return RunPlan(folder, results, study, is_demo=is_demo, overlaid=settings["overlays"])


def check_results_name(results: Path) -> None:
    """Raises: InputError where the path has characters with a meaning in Snakemake's patterns."""
    if found := sorted(set(str(results)) & FORBIDDEN_PATH_CHARACTERS):
        raise input_error(
            str(results), "", f"a results folder with {', '.join(map(repr, found))} in its path",
            "a path without { } < > and control characters",
            "Name another one with --results.",
        )  # fmt: skip


def _check_results_outside_study(study: Study, results: Path) -> None:
    """Raises: InputError where results would be written among, or over, files of the study."""
    here = results.resolve()
    for path in study.files():
        for at in (path.absolute(), path.resolve()):
            inside = at.relative_to(here).parts[:1] if at.is_relative_to(here) else ()
            if inside and inside[0] in (*RESULT_FOLDERS, at.name):
                raise input_error(
                    results, "", f"a folder that holds {path.name}, a file of the study",
                    "a folder of its own for the results", "Name another one with --results.",
                )  # fmt: skip


def _write_demo_study_files(folder: Path) -> None:
    """Study files of the demo; skipped where they stand and were written by this very code."""
    stamp, code = folder / ".laid-out-by", source_fingerprint("stages.demo")
    truth = folder.with_name(f"{folder.name}-truth") / "truth.json"
    files = [folder / "study.yaml", folder / "trials.csv", truth, stamp]
    whole = all(path.is_file() for path in files)
    if whole and stamp.read_text(encoding="utf-8") == code:
        return
    from ..files import write_text  # noqa: PLC0415
    from ..stages.demo import write_demo_study  # noqa: PLC0415  heavy, and only once

    write_demo_study(folder)
    write_text(stamp, code)


def _prepare_results_folder(results: Path) -> None:
    if results.is_file():
        raise input_error(results, "", "a file", "a folder for the results")
    try:
        results.mkdir(parents=True, exist_ok=True)
        (probe := results / ".writable").touch()
        probe.unlink()
    except OSError as error:
        found = f"'{error.strerror}'"
        raise input_error(results, "", found, "a results folder that can be written to") from error
