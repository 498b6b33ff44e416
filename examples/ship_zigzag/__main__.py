"""`python -m examples.ship_zigzag FOLDER [--predict OTHER]`: what a linear ship leaves out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np

from bluekoi.data import Float
from bluekoi.fitting import Series
from bluekoi.mismatch import Trialled

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
AHEAD_S = 60.0
"""Ten ship lengths. This ship does not keep a straight course by itself: over a whole manoeuvre in
which the rudder is given and not steered by the heading, small errors of the start grow."""
TO_ONE_SIDE = ("single_screw", "rudder_zero", "heading_zero", "drift_asymmetry", "current")
"""What a ship that is the same on both sides, in still water and well measured, does not show."""


@dataclass(frozen=True)
class Told:
    """A manoeuvre foretold from its straight approach to its end, and minute by minute, each
    minute from all before it.
    """

    whole: Forecast
    minutes: tuple[Forecast, ...]


def rms(values: Iterable[float]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(list(values)))))


def errors(forecasts: Iterable[Forecast]) -> str:
    """Root mean square path error, m, and heading error, degrees."""
    each = [(f.path_rms, rms((f.foretold - f.seen)[:, 2])) for f in forecasts]
    return f"{rms(p for p, _ in each):.2f}, {np.degrees(rms(h for _, h in each)):.2f}"


def told(given: Case, model: Trialled, trials: Sequence[Series]) -> list[Told]:
    """Manoeuvres foretold by their rudder."""
    values = values_of(given, model, trials)
    return [_told(given, model, t, v) for t, v in zip(trials, values, strict=True)]


def _told(given: Case, model: Trialled, one: Series, values: Float) -> Told:
    whole = forecast(given.kernel, one, values, model.noise, KNOWN_S)
    starts = np.arange(KNOWN_S, one.times[-1] - AHEAD_S, AHEAD_S)
    parts = [(t, one.frames(0, int(np.sum(one.times <= t + AHEAD_S)))) for t in starts]
    minutes = [forecast(given.kernel, part, values, model.noise, t) for t, part in parts]
    return Told(whole, tuple(minutes))


def left_out(given: Case, model: Trialled) -> list[Told]:
    """Each manoeuvre foretold by a model that was fitted to the other conditions alone."""
    out: dict[str, Told] = {}
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
        whole = {name: [one.whole for one in each] for name, each in runs.items()}
        minutes = {name: [one.minutes for one in each] for name, each in runs.items()}
        write(figure, lambda: draw(others, whole, minutes))


def _errors(trials: Sequence[Series], runs: dict[str, list[Told]]) -> str:
    """Errors of all manoeuvres together and of each."""
    head = ["path error m, heading error deg"]
    every, rows = ["all"], [[t.name] for t in trials]
    for name, each in runs.items():
        head += [f"{name}: {AHEAD_S:.0f} s ahead", f"{name}: to the end"]
        every += [errors(f for one in each for f in one.minutes), errors(one.whole for one in each)]
        for row, one in zip(rows, each, strict=True):
            row += [errors(one.minutes), errors([one.whole])]
    return table(head, [every, *rows])


if __name__ == "__main__":
    main()
