"""`bluekoi report`: the verdict of a run in the terminal, and its page in the browser."""

from __future__ import annotations

import os
import sys
import webbrowser
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import click

from .parameter_types import NonEmptyPath, StudyName
from .results_warnings import warn_of_outdated_results

OLD_REPORT_MESSAGE = (
    "This report is of an earlier run: the last run was not completed. `bluekoi run {}` updates it."
)


def results_folder(study: Path, results: Path | None) -> Path:
    """Folder of a study's results: the one given, else results/NAME; a folder of results itself.

    Raises: InputError where nothing has been run.
    """
    from ..errors import input_error  # noqa: PLC0415

    if results is None and (study / "report.html").is_file():
        return study
    folder = results or Path("results") / study.resolve().name
    if not folder.is_dir():
        if results is None and not study.exists() and str(study) != "demo":
            expected = "a study folder or a results folder"
            raise input_error(study, "", "no such folder", expected)
        remedy = f"Run it first: bluekoi run {study}, or name them with --results."
        raise input_error(folder, "", "no results", "the results of a run", remedy)
    return folder


@click.command()
@click.argument("study", default="demo", type=StudyName("demo", path_type=Path))
@click.option("--results", type=NonEmptyPath(path_type=Path), help="Folder with the results.")
@click.option("--open", "shown", is_flag=True, help="Open the page in the browser.")
@click.pass_context
def report(ctx: click.Context, study: Path, results: Path | None, shown: bool) -> None:
    """Show the verdict on STUDY (default: the demo), its warnings and causes, and the place of its
    report.
    """
    from ..errors import escape_control_characters, input_error  # noqa: PLC0415
    from ..files import read_json  # noqa: PLC0415
    from ..stages.result_paths import ResultPaths  # noqa: PLC0415

    folder = results_folder(study, results)
    path = folder / "mismatch.json"
    found = read_json(path) if path.is_file() else None
    if found is not None and not (isinstance(found, dict) and found.get("sentence")):
        remedy = f"Remove the file and run the study again: bluekoi run {study}."
        raise input_error(path, "", "no verdict", "the result of a search", remedy)
    for line in summary_lines(found) if found else ["No search for causes yet."]:
        click.echo(escape_control_characters(line))
    for line in _failure_and_warning_lines(study, folder):
        click.echo(escape_control_characters(line))
    page = folder / "report.html"
    if not page.is_file():
        click.echo(f"No report yet in {folder}; `bluekoi run {study}` makes it.", err=True)
        ctx.exit(1)
    warn_of_outdated_results(study, folder)
    if not ResultPaths(folder).report_is_current():
        click.echo(OLD_REPORT_MESSAGE.format(study), err=True)
    click.echo(f"Report: {page}")
    if shown and not open_in_browser(page):
        click.echo("No browser could be started here; open the file by hand.", err=True)
        ctx.exit(1)


def _failure_and_warning_lines(study: Path, results: Path) -> list[str]:
    """A line for each failed trial of a run, and for each of the warnings that it ended with."""
    from ..errors import InputError  # noqa: PLC0415
    from ..files import read_json  # noqa: PLC0415
    from ..stages.outcome import available_trial_statuses, run_warnings  # noqa: PLC0415
    from ..stages.trial_failure import failed_trial_lines  # noqa: PLC0415
    from ..study import load_study  # noqa: PLC0415

    done = results / "outcome.json"  # of a run in which no trial failed
    failed: list[str] = []
    if done.is_file():
        warnings = list(read_json(done).get("warnings", ()))
    else:
        try:
            loaded = load_study(study)
            statuses = available_trial_statuses(loaded, results)
            warnings = run_warnings(loaded, results, statuses)
        except InputError:  # none, or one that has changed: `warn_of_outdated_results` says so
            return []
        failed = failed_trial_lines(statuses)
    return [*failed, *(f"Warning: {text}" for text in warnings)]


def summary_lines(mismatch: Mapping[str, Any]) -> Iterator[str]:
    """Lines on the verdict: its sentence, each cause, a line for each of its numbers, warnings."""
    yield f"Verdict: {mismatch.get('sentence', '')}"
    for cause in mismatch.get("causes") or []:
        yield f"  {cause['name']} (probability {cause['weight']:.2f})"
        for name, cell in cause.get("parameters", {}).items():
            meaning = f"  ({cell['meaning']})" if cell.get("meaning") else ""
            yield f"    {name} = {_parameter_text(cell)}{meaning}"
    causes = mismatch.get("causes") or []
    if any(
        cell.get("std") is not None for c in causes for cell in c.get("parameters", {}).values()
    ):
        yield "  (+- is one standard deviation; the report gives 95 % intervals)"
    for text in mismatch.get("warnings") or []:
        yield f"Warning: {text}"


def _parameter_text(cell: Mapping[str, Any]) -> str:
    unit = "" if cell.get("unit") in (None, "", "1") else f" {cell['unit']}"
    value, std = cell.get("value"), cell.get("std")
    if value is None:
        return "unknown"
    return f"{value:.4g}{unit}" if std is None else f"{value:.4g} +- {std:.2g}{unit}"


def open_in_browser(page: Path) -> bool:
    """Whether a browser of a graphical session could be asked to show the page."""
    graphical = sys.platform != "linux" or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    )
    return graphical and webbrowser.open(page.resolve().as_uri())
