"""`python -m examples.robotic_fish FOLDER [--predict OTHER]`: what the flat-plate model lacks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import click
import numpy as np

from bluekoi.data import Float
from bluekoi.fitting import Noise
from bluekoi.mismatch import Trialled

from ..command import plainly
from ..drawing import write
from ..engine import Beside, Case, beside, case, investigate, refitted
from ..telling import asked, coefficients, found, table
from .asymmetry import CAUSES
from .errors import left_out, path_errors, paths_left_out, repeatability, total
from .model import SYSTEM
from .picture import draw
from .reading import Recording, by_beats, read_folder, series

FIRST_NOISE = Noise(
    np.array([3e-3, 3e-3, 1e-4, 1e-3, 1e-3, 1e-2]), np.array([1.0] * 3 + [0.2] * 3), np.ones(3)
)
NAMES = tuple(e.name for e in SYSTEM.effects if e.kind != "disturbance")
KNOWN_S = (np.inf, 1.0)
"""Starts that suit the whole trial, and starts told by its first second alone."""


def case_of(recordings: list[Recording]) -> Case:
    """The search over means of tail beats."""
    return case(SYSTEM, [by_beats(r) for r in recordings], FIRST_NOISE)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--predict", type=click.Path(path_type=Path), help="Folder of trials not fitted.")
@click.option(
    "--with",
    "own",
    multiple=True,
    type=click.Choice(NAMES),
    metavar="EFFECT",
    help="Foretell with these effects as well (repeat).",
)
@click.option("--asymmetry", is_flag=True, help="Try every cause of the asymmetry as well.")
@click.option("--figure", type=click.Path(path_type=Path), help="Picture to write (png).")
@plainly
def main(
    folder: Path, predict: Path | None, own: tuple[str, ...], asymmetry: bool, figure: Path | None
) -> None:
    """What the recordings in FOLDER say the model lacks, and how well it foretells others."""
    recordings = read_folder(folder)
    given = case_of(recordings)
    outcome = investigate(given)
    models = {"bare": outcome.choice.bare, "with what was named": outcome.chosen}
    if own:
        models["with " + ", ".join(own)] = refitted(given, own, outcome.choice.bare)
    click.echo(f"{coefficients(outcome)}\n\n{found(given, outcome)}\n")
    if predict is None:
        click.echo(_told_apart(given, models, recordings))
    else:
        click.echo(_foretold(given, models, read_folder(predict)))
    if asymmetry:
        answers = beside(given, outcome.chosen, CAUSES)
        click.echo("\n" + asked("cause of the asymmetry, beside what is named", answers))
        click.echo("\n" + _paths_with(given, answers, recordings))
    if figure:
        paths = _paths(given, models, recordings)
        write(figure, lambda: draw(recordings, paths))


def _paths_with(given: Case, answers: Mapping[str, Beside], recordings: list[Recording]) -> str:
    """Path error of conditions left out with each cause beside what is named."""
    trials = [series(r) for r in recordings]
    errors = {n: left_out(given, one.model, trials, KNOWN_S) for n, one in answers.items()}
    rows = sorted((total(e[np.inf]), total(e[1.0]), n) for n, e in errors.items())
    return table(("path error, mm, with", "start fitted", "first second"),
                 [(n, f"{1000 * a:.1f}", f"{1000 * b:.1f}") for a, b, n in rows])  # fmt: skip


def _paths(
    given: Case, models: dict[str, Trialled], recordings: list[Recording]
) -> dict[str, list[Float]]:
    trials = [series(r) for r in recordings]
    bare, named = (paths_left_out(given, m, trials) for m in list(models.values())[:2])
    return {"measured": [t.seen[:, :2] for t in trials], "bare": bare, "named": named}


def _told_apart(given: Case, models: dict[str, Trialled], recordings: list[Recording]) -> str:
    """Leave-condition-out errors beside the recordings' own repeatability."""
    trials = [series(r) for r in recordings]
    rows = []
    for name, model in models.items():
        errors = left_out(given, model, trials, KNOWN_S)
        rows.append((name, *(f"{1000 * total(errors[k]):.1f}" for k in KNOWN_S)))
    own = [repeatability(recordings, k) for k in KNOWN_S]
    rows.append(("one repeat laid on the other", *(f"{1000 * total(e):.1f}" for e in own)))
    return table(("path error, mm, conditions left out", "start fitted", "first second"), rows)


def _foretold(given: Case, models: dict[str, Trialled], others: list[Recording]) -> str:
    """Errors on trials at conditions that no fit has seen, one a line."""
    trials = [series(r) for r in others]
    errors = {(n, k): path_errors(given, m, trials, k) for n, m in models.items() for k in KNOWN_S}
    rows = [
        (t.name, f"{r.beat_hz:.3f}", *(f"{1000 * e[i]:.1f}" for e in errors.values()))
        for i, (t, r) in enumerate(zip(trials, others, strict=True))
    ]
    rows.append(("all", "", *(f"{1000 * total(e):.1f}" for e in errors.values())))
    head = [f"{n}, {'start fitted' if np.isinf(k) else 'first second'}" for n, k in errors]
    return table(("path error, mm", "tail beat, Hz", *head), rows)


if __name__ == "__main__":
    main()
