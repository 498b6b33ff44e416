"""`python -m examples.ship_zigzag FOLDER [--predict OTHER]`: what a linear ship leaves out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from pipeline.fitting import Series, Shot, shoot
from pipeline.mismatch import Trialled

from ..engine import Case, case, foretold, investigate, values_of
from ..telling import coefficients, found, table
from .model import SYSTEM
from .reading import FIRST_NOISE, read_folder


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
def main(folder: Path, predict: Path | None) -> None:
    """What the manoeuvres in FOLDER say the linear model lacks, and how it foretells others."""
    trials = read_folder(folder)
    given = case(SYSTEM, trials, FIRST_NOISE)
    outcome = investigate(given)
    click.echo(f"{coefficients(outcome)}\n\n{found(given, outcome)}\n")
    others = read_folder(predict) if predict else trials
    rows = []
    for name, model in (("bare", outcome.choice.bare), ("with what was named", outcome.chosen)):
        shots = free_runs(given, model, others) if predict else foretold(given, model)
        rows.append((name, f"{path_m(shots):.3f}", f"{heading_deg(others, shots):.2f}"))
        rows += [(f"{name}: {t.name}", f"{s.rmse:.3f}", f"{heading_deg([t], [s]):.2f}")
                 for t, s in zip(others, shots, strict=True)]  # fmt: skip
    click.echo(table(("manoeuvres foretold", "path, m", "heading, deg"), rows))


if __name__ == "__main__":
    main()
