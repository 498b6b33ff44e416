"""A study folder, read and checked at the door: the only reader of study.yaml and trials.csv."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import InputError, InputIssue
from ..files import found_instead_of_file
from .consistency_rules import length_unit_remedy
from .image_files import IMAGE_SUFFIXES
from .study_yaml import read_study_settings
from .trials_csv import read_incomplete_trials, read_trials
from .types import Study, StudySettings, Trial


def load_study(folder: str | Path, *, only: str | None = None) -> Study:
    """Study of a folder with study.yaml and trials.csv.

    only: read this trial alone, without checking the others.

    Raises: InputError with all that is wrong in both files at once. Files that the trials point to
    are not opened here: a broken recording stops only its own trial.

        >>> study = load_study("lab")
        >>> [trial.trial_id for trial in study.trials]
        ['T09', 'T10', 'T11']
        >>> study.setup.pool.length_m
        2.6
    """
    root = Path(folder)
    if not root.is_dir():
        found = "a file" if root.exists() else "no such folder"
        expected = "a study folder with study.yaml and trials.csv"
        raise InputError(InputIssue(str(root), "", found, expected))
    findings: list[InputIssue] = []
    setup = read_study_settings(root / "study.yaml", findings)
    trials = read_trials(root / "trials.csv", findings, only=only)
    if setup is not None:
        findings += _head_length_issues(root / "trials.csv", trials, setup)
    if findings or setup is None:
        raise InputError(findings)
    return Study(root=root.resolve(), setup=setup, trials=tuple(trials))


def load_incomplete_study(folder: str | Path) -> Study:
    """Study of which only the sources of the trials are known, unchecked: study.yaml is not read,
    and cells of trials.csv, or all of it, may be missing.
    """
    root = Path(folder)
    trials = tuple(read_incomplete_trials(root / "trials.csv"))
    return Study.model_construct(root=root.resolve(), setup=None, trials=trials)


def _head_length_issues(
    path: Path, trials: Sequence[Trial], setup: StudySettings
) -> list[InputIssue]:
    """A finding for each trial whose head would fit the body in cm or mm alone."""
    body = setup.robot.body_length_m
    remedies = {t.trial_id: length_unit_remedy("head_length_m", t.head_length_m, body)
                for t in trials}  # fmt: skip
    return [
        InputIssue(str(path), f"trial {t.trial_id}, head_length_m", f"{t.head_length_m:g}",
                   f"a head that fits the body of {body:g} m in study.yaml", remedies[t.trial_id])
        for t in trials if remedies[t.trial_id]
    ]  # fmt: skip


def missing_files(study: Study) -> list[InputIssue]:
    """A finding for each file that trials.csv points to and that is not there."""
    return [finding for trial in study.trials for finding in missing_files_of_trial(study, trial)]


def missing_files_of_trial(study: Study, trial: Trial) -> list[InputIssue]:
    """A finding for each file of one trial that is not there."""
    motor = study.motor_path(trial)
    paths = [*study.paths(trial), *([motor] if motor else [])]
    return [
        _folder_without_pictures(study, trial, path)
        or InputIssue(
            str(study.root / "trials.csv"),
            f"trial {trial.trial_id}",
            found_instead_of_file(path, f"'{_path_from_csv_cell(path, study.root)}'"),
            "a file at that path, relative to the study folder or absolute",
        )
        for path in paths
        if not path.is_file()
    ]


def _folder_without_pictures(study: Study, trial: Trial, path: Path) -> InputIssue | None:
    """A finding for a source that is a folder in which there is no picture."""
    if path == study.motor_path(trial) or not (trial.reads_images and path.is_dir()):
        return None
    empty = next(path.iterdir(), None) is None
    what = "an empty folder" if empty else "a folder without pictures:"
    return InputIssue(
        str(study.root / "trials.csv"),
        f"trial {trial.trial_id}, source",
        f"{what} '{_path_from_csv_cell(path, study.root)}'",
        f"pictures in it ({', '.join(IMAGE_SUFFIXES)}), or another file",
    )


def _path_from_csv_cell(path: Path, root: Path) -> Path:
    """A path as trials.csv names it."""
    return path.relative_to(root) if path.is_relative_to(root) else path
