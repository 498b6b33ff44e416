"""`bluekoi compare`: two runs side by side."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .parameter_types import NonEmptyPath, StudyName
from .report import results_folder
from .results_warnings import warn_of_outdated_results

if TYPE_CHECKING:
    from ..comparison import Difference, RunResults

COMPARISON_CSV_COLUMNS = ("section", "name", "first", "second", "difference", "standard_deviations")
"""Columns of comparison.csv."""
MARKED_ABOVE_STDS = 3.0
"""Numbers that differ by this many standard deviations are marked."""


@click.command()
@click.pass_context
@click.argument("first", type=StudyName("demo", path_type=Path))
@click.argument("second", type=StudyName("demo", path_type=Path))
@click.option("--out", type=NonEmptyPath(path_type=Path), help="Folder for table and figure.")
@click.option("--all", "everything", is_flag=True, help="Also list what is equal.")
def compare(
    ctx: click.Context, first: Path, second: Path, out: Path | None, everything: bool
) -> None:
    """Show what differs between two runs: coefficients, causes, errors, settings and inputs.

    FIRST and SECOND are results folders, or studies whose results are in results/NAME. With --out,
    the table is also written as comparison.csv, and a figure as comparison.png and comparison.pdf.
    If results of a run are missing, the command compares the others, names the missing files, and
    ends with exit code 1.
    """
    from ..comparison import list_run_differences as compared  # noqa: PLC0415
    from ..comparison import read_run  # noqa: PLC0415
    from ..errors import escape_control_characters  # noqa: PLC0415

    runs = [read_run(_results_folder(path)) for path in (first, second)]
    for path, one in zip((first, second), runs, strict=True):
        warn_of_outdated_results(path, one.folder)
    found = compared(*runs)
    for line in table_lines(found, everything=everything):
        click.echo(escape_control_characters(line))
    if missing := [str(run.folder) for run in runs if not run.manifest]:
        click.echo(f"No manifest.json in {' and '.join(missing)}: settings, inputs and versions "
                   "were not compared. `bluekoi run` writes it.", err=True)  # fmt: skip
    if out is not None:
        _write_comparison(out, found, runs)
        click.echo(f"Written: {out / 'comparison.csv'}, {out / 'comparison.png'} and .pdf")
    incomplete = {run.folder: run.missing_result_files for run in runs if run.missing_result_files}
    for folder, missing_results in incomplete.items():
        click.echo(f"No {' and no '.join(missing_results)} in {folder}: their contents were not "
                   "compared. Complete that run with `bluekoi run`.", err=True)  # fmt: skip
    if incomplete:
        ctx.exit(1)


def _results_folder(path: Path) -> Path:
    """A results folder as such, else that of a study.

    Raises: InputError where it is a file.
    """
    if path.is_file():
        from ..errors import input_error  # noqa: PLC0415

        raise input_error(path, "", "a file", "a study folder or a results folder")
    results = any((path / name).is_file() for name in ("coefficients.json", "mismatch.json"))
    return path if results else results_folder(path, None)


def table_lines(found: Sequence[Difference], *, everything: bool) -> Iterator[str]:
    """A table by sections, of what differs or of everything."""
    shown = [d for d in found if everything or not d.same]
    if not shown:
        yield "No difference."
    section = ""
    for one in shown:
        if one.section != section:
            section = one.section
            yield f"{section}:"
        far = f"  ({one.sigmas:+.1f} sd)" if math.isfinite(one.sigmas) else ""
        mark = " *" if abs(one.sigmas) >= MARKED_ABOVE_STDS else ""
        yield f"  {one.name}: {one.first} -> {one.second}{far}{mark}"


def _write_comparison(out: Path, found: Sequence[Difference], runs: Sequence[RunResults]) -> None:
    """Write the table, and the figure as png and pdf."""
    from ..comparison import comparison_figure  # noqa: PLC0415
    from ..files import atomic_write, write_rows  # noqa: PLC0415

    rows = (
        [d.section, d.name, d.first, d.second, _number_text(d.difference), _number_text(d.sigmas)]
        for d in found
    )
    write_rows(out / "comparison.csv", [COMPARISON_CSV_COLUMNS, *rows])
    labels = [run.folder.name or str(run.folder.resolve().name) for run in runs]
    if labels[0] == labels[1]:
        labels = [str(run.folder) for run in runs]
    figure = comparison_figure(runs[0], runs[1], (labels[0], labels[1]))
    for suffix in (".png", ".pdf"):
        with atomic_write(out / f"comparison{suffix}") as temporary:
            figure.savefig(temporary, dpi=150)


def _number_text(value: float) -> str:
    return f"{value:.6g}" if math.isfinite(value) else ""
