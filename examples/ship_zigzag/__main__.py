"""`python -m examples.ship_zigzag FOLDER [--predict OTHER]`: what a linear ship leaves out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import click
import numpy as np

from pipeline.fitting import Series
from pipeline.mismatch import Trialled

from ..command import plainly
from ..drawing import write
from ..engine import Case, beside, case, investigate, refitted, searched_on, values_of
from ..forecasting import Forecast, forecast
from ..telling import asked, coefficients, found, table
from .model import SYSTEM
from .picture import draw
from .reading import FIRST_NOISE, read_folder

KNOWN_S = 5.0
"""Seconds of a manoeuvre from which the rest is foretold: the straight approach."""
TO_ONE_SIDE = ("single_screw", "rudder_zero", "heading_zero", "drift_asymmetry", "current")
"""What a ship that is the same on both sides, in still water and well measured, does not show."""


def rms(values: Iterable[float]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(list(values)))))


def heading_deg(one: Forecast) -> float:
    """Root mean square heading error, degrees."""
    return float(np.degrees(rms((one.foretold - one.seen)[:, 2])))


def told(given: Case, model: Trialled, trials: Sequence[Series]) -> list[Forecast]:
    """Manoeuvres foretold from their first seconds and their rudder."""
    values = values_of(given, model, trials)
    return [forecast(given.kernel, t, v, model.noise, KNOWN_S)
            for t, v in zip(trials, values, strict=True)]  # fmt: skip


def left_out(given: Case, model: Trialled) -> list[Forecast]:
    """Each manoeuvre foretold by a model that was fitted to the other conditions alone."""
    out: dict[str, Forecast] = {}
    for condition in dict.fromkeys(s.condition for s in given.series):
        own = [s for s in given.series if s.condition == condition]
        rest = [s for s in given.series if s.condition != condition]
        fitted = refitted(given, model.effects, model, rest)
        out |= {s.name: f for s, f in zip(own, told(given, fitted, own), strict=True)}
    return [out[s.name] for s in given.series]


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--predict", type=click.Path(path_type=Path), help="Folder of other manoeuvres.")
@click.option("--figure", type=click.Path(path_type=Path), help="Picture to write (png).")
@plainly
def main(folder: Path, predict: Path | None, figure: Path | None) -> None:
    """What the manoeuvres in FOLDER say the linear model lacks, and how it foretells others."""
    trials = read_folder(folder)
    given = case(SYSTEM, trials, FIRST_NOISE)
    outcome = searched_on(given, investigate(given))
    click.echo(f"{coefficients(outcome)}\n\n{found(given, outcome)}\n")
    answers = beside(given, outcome.chosen, TO_ONE_SIDE)
    click.echo(asked("what differs from side to side, beside what is named", answers) + "\n")
    others = read_folder(predict) if predict else trials
    models = {"bare": outcome.choice.bare, "with what was named": outcome.chosen}
    runs = {name: told(given, m, others) if predict else left_out(given, m)
            for name, m in models.items()}  # fmt: skip
    click.echo(_errors(others, runs))
    if figure:
        write(figure, lambda: draw(others, runs))


def _errors(trials: Sequence[Series], runs: dict[str, list[Forecast]]) -> str:
    """Errors of all manoeuvres together and of each."""
    both = [f"{rms(f.path_rms for f in r):.2f}, {rms(map(heading_deg, r)):.2f}"
            for r in runs.values()]  # fmt: skip
    rows = [
        (t.name, *(f"{r[i].path_rms:.2f}, {heading_deg(r[i]):.2f}" for r in runs.values()))
        for i, t in enumerate(trials)
    ]
    return table(("foretold: path error m, heading error deg", *runs), [("all", *both), *rows])


if __name__ == "__main__":
    main()
