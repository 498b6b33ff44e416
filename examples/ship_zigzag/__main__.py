"""`python -m examples.ship_zigzag FOLDER [--predict OTHER]`: what a linear ship leaves out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from pipeline.fitting import Series, Shot, shoot
from pipeline.mismatch import Trialled

from ..drawing import write
from ..engine import Case, beside, case, foretold, investigate, searched_on, values_of
from ..telling import asked, coefficients, found, table
from .model import SYSTEM
from .picture import draw
from .reading import FIRST_NOISE, read_folder

TO_ONE_SIDE = ("single_screw", "rudder_zero", "heading_zero", "drift_asymmetry", "current")
"""What a ship that is the same on both sides, in still water and well measured, does not show."""


def path_m(shots: Sequence[Shot]) -> float:
    """Root mean square path error over all manoeuvres, m."""
    return float(np.sqrt(np.mean([s.rmse**2 for s in shots])))


def heading_deg(trials: Sequence[Series], shots: Sequence[Shot]) -> float:
    """Root mean square heading error over all manoeuvres, degrees."""
    squares = [np.mean((t.seen[:, 2] - s.observed[:, 2]) ** 2)
               for t, s in zip(trials, shots, strict=True)]  # fmt: skip
    return float(np.degrees(np.sqrt(np.mean(squares))))


def free_runs(given: Case, model: Trialled, trials: Sequence[Series]) -> list[Shot]:
    """Free runs of manoeuvres that may not have been fitted."""
    return shoot(given.kernel, trials, values_of(given, model, trials))


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--predict", type=click.Path(path_type=Path), help="Folder of other manoeuvres.")
@click.option("--figure", type=click.Path(path_type=Path), help="Picture to write (png).")
def main(folder: Path, predict: Path | None, figure: Path | None) -> None:
    """What the manoeuvres in FOLDER say the linear model lacks, and how it foretells others."""
    trials = read_folder(folder)
    first = case(SYSTEM, trials, FIRST_NOISE)
    outcome = investigate(first)
    click.echo(f"{coefficients(outcome)}\n\n{found(first, outcome)}\n")
    given, more = searched_on(first, outcome)
    if more is not outcome:
        click.echo(f"With these in the model:\n\n{found(given, more)}\n")
    answers = beside(given, more.chosen, TO_ONE_SIDE)
    click.echo(asked("what differs from side to side, beside what is named", answers) + "\n")
    others = read_folder(predict) if predict else trials
    runs = {
        name: free_runs(given_, model, others) if predict else foretold(given_, model)
        for name, given_, model in (
            ("bare", first, outcome.choice.bare), ("with what was named", given, more.chosen))
    }  # fmt: skip
    click.echo(_errors(others, runs))
    if figure:
        write(figure, lambda: draw(others, runs))


def _errors(trials: Sequence[Series], runs: dict[str, list[Shot]]) -> str:
    """Errors of all manoeuvres together and of each."""
    rows: list[tuple[str, ...]] = []
    for i, trial in enumerate(trials):
        each = [(s.rmse, heading_deg([trial], [s])) for s in (r[i] for r in runs.values())]
        rows.append((trial.name, *(f"{p:.2f}, {h:.2f}" for p, h in each)))
    both = [f"{path_m(r):.2f}, {heading_deg(trials, r):.2f}" for r in runs.values()]
    return table(("foretold: path error m, heading error deg", *runs), [("all", *both), *rows])


if __name__ == "__main__":
    main()
