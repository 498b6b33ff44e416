"""`python -m validation`: make studies, measure them, run the finder, score it."""

from __future__ import annotations

import json
import logging
from importlib import import_module
from pathlib import Path

import click

from bluekoi.cli import InputErrorGroup

from . import report, scoring, sealing, study_runs

FOLDER_ARGUMENT = click.argument("folder", type=click.Path(path_type=Path))
FOLDERS_ARGUMENT = click.argument(
    "folders", nargs=-1, required=True, type=click.Path(path_type=Path)
)
WORKERS_OPTION = click.option("--workers", default=2, show_default=True, help="Studies at a time.")


@click.group(cls=InputErrorGroup)
def main() -> None:
    """Independent generators, the finder's verdicts on them, and their scores."""
    logging.basicConfig(level=logging.ERROR)


@main.command()
@click.argument("generator")
@click.option("--seed", required=True, type=int)
@click.option("--count", default=40, show_default=True)
@click.option("--first", default=0, show_default=True)
@FOLDER_ARGUMENT
def make(generator: str, seed: int, count: int, first: int, folder: Path) -> None:
    """Write studies of a GENERATOR into FOLDER and publish the hashes of their truths."""
    generate = import_module(f"validation.generators.{generator}").generate
    for index in range(first, first + count):
        name = generate(seed, index, folder)["study"]
        sealing.seal_truth(folder, name)
        click.echo(name)


@main.command()
@FOLDER_ARGUMENT
@WORKERS_OPTION
def measure(folder: Path, workers: int) -> None:
    """Measure every study of FOLDER up to its tracks."""
    for line in study_runs.measure_all(folder, workers):
        click.echo(line)


@main.command()
@FOLDER_ARGUMENT
@WORKERS_OPTION
@click.option("--label", required=True, help="Name under which the verdicts are kept.")
@click.option("--only", default="", help="Only studies whose name contains this.")
def find(folder: Path, workers: int, label: str, only: str) -> None:
    """Run the finder on every measured study of FOLDER."""
    for line in study_runs.analyse_all(folder, label, workers, only=only):
        click.echo(line)


@main.command()
@FOLDERS_ARGUMENT
@click.option("--label", required=True)
@click.option("--out", type=click.Path(path_type=Path), help="Json of summary and studies.")
def score(folders: tuple[Path, ...], label: str, out: Path | None) -> None:
    """Score the verdicts under LABEL of all FOLDERS together."""
    studies = [s for folder in folders for s in scoring.score_all(folder, label)]
    result = scoring.summary(studies)
    click.echo(scoring.summary_text(result))
    if out:
        content = {"label": label, "summary": result, "studies": scoring.study_records(studies)}
        out.write_text(json.dumps(content, indent=1))


@main.command("ground-truth")
@click.argument("study", type=click.Path(path_type=Path))
@click.argument("results", type=click.Path(path_type=Path))
@click.option("--truth", type=click.Path(path_type=Path), help="Truth; else as STUDY names it.")
def ground_truth(study: Path, results: Path, truth: Path | None) -> None:
    """Compare the truth of STUDY with its RESULTS: RESULTS/ground_truth.html."""
    from .ground_truth.page import write_ground_truth  # noqa: PLC0415

    click.echo(write_ground_truth(study, results, truth))


@main.command()
@FOLDERS_ARGUMENT
@click.option("--label", required=True, help="Label of the verdicts; also the finder's name.")
@click.option("--commit", required=True, help="Commit at which the finder was run.")
@click.option("--date", required=True, help="Day of the run, 2026-11-23.")
def record(folders: tuple[Path, ...], label: str, commit: str, date: str) -> None:
    """Write the verdicts under LABEL to validation/results and the tables into docs/evidence.md."""
    studies = [s for folder in folders for s in scoring.score_all(folder, label)]
    content = report.record(studies, finder=label, commit=commit, date=date)
    for path in report.write_results(content):
        click.echo(path)
    report.update_evidence_page()


@main.command()
@FOLDER_ARGUMENT
def discrepancy(folder: Path) -> None:
    """Measure how far the formulas of causes differ, in the measured studies of FOLDER."""
    from .discrepancy import discrepancy_report, relative_residuals  # noqa: PLC0415  compiles the model

    values: dict[str, list[float]] = {}
    for name in study_runs.measured_names(folder):
        found = relative_residuals(folder / "studies" / name, folder / "tracks" / name)
        for cause, own in found.items():
            values.setdefault(cause, []).extend(own)
    click.echo(discrepancy_report(values))


@main.command()
@FOLDER_ARGUMENT
@click.option("--only", default="", help="Only studies whose name contains this.")
def limits(folder: Path, only: str) -> None:
    """Measure what the limits of the search leave out, in the measured studies of FOLDER."""
    from .search_limits import limit_effects, limit_line, limit_summary  # noqa: PLC0415  compiles the model

    found = []
    for name in _measured_names(folder, only):
        found.append(limit_effects(folder / "studies" / name, folder / "tracks" / name))
        click.echo(limit_line(found[-1]))
    click.echo(limit_summary(found))


@main.command("noise-starts")
@FOLDER_ARGUMENT
@click.option("--only", default="", help="Only studies whose name contains this.")
def noise_starts(folder: Path, only: str) -> None:
    """Measure what other starts of the noise estimate gain in the studies of FOLDER."""
    from .noise_starts import gain_table, other_start_gains  # noqa: PLC0415  compiles the model

    found = []
    for name in _measured_names(folder, only):
        found += other_start_gains(folder / "studies" / name, folder / "tracks" / name)
        click.echo(name)
    click.echo(gain_table(found))


@main.command("first-frame")
@FOLDER_ARGUMENT
@click.option("--only", default="", help="Only studies whose name contains this.")
def first_frame(folder: Path, only: str) -> None:
    """Measure which accuracy of the start of a trial the measured studies of FOLDER support."""
    from .first_frame import first_frame_gains, gain_table  # noqa: PLC0415  compiles the model

    found = []
    for name in _measured_names(folder, only):
        found.append(first_frame_gains(folder / "studies" / name, folder / "tracks" / name))
        click.echo(name)
    click.echo(gain_table(found))


@main.command()
@FOLDER_ARGUMENT
@click.option("--only", default="", help="Only studies whose name contains this.")
def proposals(folder: Path, only: str) -> None:
    """Measure the ranks of the causes that the search has found in the studies of FOLDER."""
    from .proposal_ranks import proposed_causes, rank_summary  # noqa: PLC0415  compiles the model

    found = []
    for name in _measured_names(folder, only):
        own = proposed_causes(folder / "studies" / name, folder / "tracks" / name)
        click.echo(f"{name}: " + ", ".join(f"{one.name} {one.rank}" for one in own))
        found += own
    if not found:
        raise click.ClickException(f"{folder}: no cause in the most probable sets.")
    click.echo(rank_summary(found))


def _measured_names(folder: Path, only: str) -> list[str]:
    """Names of the measured studies that contain `only`; an error where there is none."""
    names = [name for name in study_runs.measured_names(folder) if only in name]
    if not names:
        raise click.ClickException(f"{folder}: no measured study whose name contains '{only}'.")
    return names


@main.command("calibration-slope")
def calibration_slope() -> None:
    """Estimate the slope of the stated probabilities from validation/results."""
    from .calibration_slope import (  # noqa: PLC0415  as the other measurements
        estimation_runs,
        fitted_slope,
        names_of,
        slope_report,
    )

    runs = report.load_runs()
    every = names_of(runs)
    click.echo(slope_report(names_of(estimation_runs(runs))))
    click.echo(f"slope of all {len(every.true)} recorded names: {fitted_slope(every):.2f}")


@main.command()
@FOLDERS_ARGUMENT
def drift(folders: tuple[Path, ...]) -> None:
    """Count drifting trials that are reported in the measured studies of FOLDERS, with and without
    a drift.
    """
    from .drift_detection import detection_rate_report, drift_detections  # noqa: PLC0415  compiles the model

    studies = [(folder, name) for folder in folders for name in study_runs.measured_names(folder)]
    click.echo(
        detection_rate_report(
            [drift_detections(f / "studies" / name, f / "tracks" / name) for f, name in studies]
        )
    )


@main.command()
@FOLDERS_ARGUMENT
def lengths(folders: tuple[Path, ...]) -> None:
    """Compare the rigid lengths in the measured studies of FOLDERS with right geometry."""
    from .rigid_length_misfit import length_misfit, length_misfit_report  # noqa: PLC0415  loads the model

    rows = [
        length_misfit(folder, name)
        for folder in folders
        for name in study_runs.measured_names(folder)
    ]
    click.echo(length_misfit_report([row for row in rows if row is not None]))


@main.command("report")
def evidence_page() -> None:
    """Make the tables and the plot of docs/evidence.md from validation/results."""
    report.update_evidence_page()


if __name__ == "__main__":
    main()
