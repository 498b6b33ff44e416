"""`python -m examples.fish_robot_pool FOLDER`: the edge of the tank against tracking faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from bluekoi.fitting import Free, Series

from ..command import plainly
from ..drawing import write
from ..engine import Case, beside, case, investigate
from ..telling import asked, coefficients, found, table
from .edge import AT_THE_EDGE, near_over_far
from .model import SYSTEM
from .picture import draw
from .reading import FIRST_NOISE, Run, read_folder, series


def case_of(runs: Sequence[Run]) -> Case:
    """The search with one speed for all runs of a command; a run is what is held out."""
    trials: list[Series] = [series(run) for run in runs]
    given = case(SYSTEM, trials, FIRST_NOISE)
    free = (Free("a"), *(Free("V_0", group) for group in sorted({t.group for t in trials})))
    return replace(given, coefficients=free)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--figure", type=click.Path(path_type=Path), help="Picture to write (png).")
@plainly
def main(folder: Path, figure: Path | None) -> None:
    """What slows the robot of FOLDER."""
    runs = read_folder(folder)
    rows = [(r.name, r.faults, f"{r.gap_s:.1f}", f"{r.places[:, 1].min():.2f}",
             f"{r.places[:, 1].max():.2f}") for r in runs]  # fmt: skip
    click.echo(table(("run", "places set aside", "longest gap, s", "y from, m", "to, m"), rows))
    given = case_of(runs)
    outcome = investigate(given)
    click.echo(f"\n{coefficients(outcome)}\n\n{found(given, outcome)}\n")
    answers = beside(given, outcome.chosen, AT_THE_EDGE)
    click.echo(asked("at the edge, beside what is named", answers) + "\n")
    ratios = [(k, f"{r:.2f}", f"{near}, {far}")
              for k, (r, near, far) in near_over_far(runs).items()]  # fmt: skip
    click.echo(table(("command", "speed within 0.12 m of the edge over speed beyond",
                      "beats in both"), ratios))  # fmt: skip
    if figure:
        write(figure, lambda: draw(runs))


if __name__ == "__main__":
    main()
