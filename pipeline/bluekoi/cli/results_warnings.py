"""Warnings of commands that read results: failed trials, a study that has changed since."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ..study import Study


DEMO_STUDY_FOLDER = Path("studies/demo")
"""Where a run of `demo` lays out the files of its study (`demo_folder` in config/default.yaml)."""


def warn_of_failed_trials(study: Study, results: Path) -> None:
    """Name on the standard error the trials that failed or were cut short."""
    from ..errors import escape_control_characters  # noqa: PLC0415
    from ..stages.outcome import available_trial_statuses  # noqa: PLC0415
    from ..stages.trial_failure import failed_trial_lines  # noqa: PLC0415

    for line in failed_trial_lines(available_trial_statuses(study, results)):
        click.echo(escape_control_characters(f"Warning: {line}"), err=True)


def warn_of_outdated_results(study: Path | Study, results: Path) -> None:
    """Name on the standard error what has changed in a study since its results were made.

    Nothing is said of a folder without a readable study.
    """
    from ..errors import InputError, escape_control_characters  # noqa: PLC0415
    from ..stages.study_changes import outdated_results_message  # noqa: PLC0415
    from ..study import load_study  # noqa: PLC0415

    if isinstance(study, Path):
        if study == Path("demo") and not study.exists():
            study = DEMO_STUDY_FOLDER
        if not (study / "study.yaml").is_file():
            return
        try:
            study = load_study(study)
        except InputError as error:
            click.echo(f"The study has changed and cannot be read: {error}", err=True)
            return
    if message := outdated_results_message(study, results):
        click.echo(escape_control_characters(f"Warning: {message}."), err=True)
