"""`python -m examples.fish_robot_pool FOLDER`: the edge of the tank against tracking faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from pipeline.fitting import Free, Series

from ..engine import Case, case, investigate
from ..telling import coefficients, found, table
from .model import SYSTEM
from .reading import FIRST_NOISE, Run, read_folder, series


def case_of(runs: Sequence[Run]) -> Case:
    """The search with one speed for all runs of a command; a run is what is held out."""
    trials: list[Series] = [series(run) for run in runs]
    given = case(SYSTEM, trials, FIRST_NOISE)
    free = (Free("a"), *(Free("V_0", group) for group in sorted({t.group for t in trials})))
    return replace(given, coefficients=free)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
def main(folder: Path) -> None:
    """What slows the robot of FOLDER."""
    runs = read_folder(folder)
    rows = [(r.name, r.faults, f"{r.gap_s:.1f}", f"{r.places[:, 1].min():.2f}",
             f"{r.places[:, 1].max():.2f}") for r in runs]  # fmt: skip
    click.echo(table(("run", "places set aside", "longest gap, s", "y from, m", "to, m"), rows))
    given = case_of(runs)
    outcome = investigate(given)
    click.echo(f"\n{coefficients(outcome)}\n\n{found(given, outcome)}")


if __name__ == "__main__":
    main()
