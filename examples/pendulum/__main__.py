"""`python -m examples.pendulum FOLDER`: which friction stops the pendulum."""

from __future__ import annotations

from pathlib import Path

import click

from bluekoi.fitting import Series

from ..command import plainly
from ..drawing import write
from ..engine import Case, case, investigate
from ..telling import coefficients, found, table
from .laws import Law, law, weights
from .model import SYSTEM
from .picture import draw
from .reading import FIRST_NOISE, read_folder, stretches

MEASURED = ("rate_scale", "zero_error")
"""Faults of the recording that every law is given."""
VISCOUS, DRY, SQUARE = "viscous_friction", "coulomb_friction", "quadratic_friction"
FRICTIONS = {
    "viscous": (VISCOUS,),
    "Coulomb": (DRY,),
    "quadratic": (SQUARE,),
    "viscous and Coulomb": (VISCOUS, DRY),
    "viscous and quadratic": (VISCOUS, SQUARE),
    "Coulomb and quadratic": (DRY, SQUARE),
}


def searched(whole: Series) -> Case:
    """The search over stretches of the recording, friction withheld."""
    return case(SYSTEM, stretches(whole), FIRST_NOISE)


def frictions(whole: Series) -> dict[str, Law]:
    """Every friction over the whole run."""
    return {name: law(whole, (*MEASURED, *effects)) for name, effects in FRICTIONS.items()}


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--figure", type=click.Path(path_type=Path), help="Picture to write (png).")
@plainly
def main(folder: Path, figure: Path | None) -> None:
    """Which friction stops the pendulum in FOLDER."""
    whole = read_folder(folder)
    given = searched(whole)
    outcome = investigate(given)
    click.echo(f"By stretches: {coefficients(outcome)}\n\n{found(given, outcome)}\n")
    laws = frictions(whole)
    real = {name: one for name, one in laws.items() if 0.0 not in one.numbers.values()}
    shares = dict(zip(real, weights(list(real.values())), strict=True))
    rows = [
        (name, _numbers(one), *(f"{v:.4f}" for v in one.rms), f"{one.worth.sum():.0f}",
         f"{shares[name]:.3f}" if name in shares else "one part is 0")
        for name, one in laws.items()
    ]  # fmt: skip
    head = ("friction, over the whole run", "size", "rms angle, rad", "rms rate, rad/s",
            "stretches foretold, log likelihood", "weight")  # fmt: skip
    click.echo(table(head, rows))
    if figure:
        write(
            figure, lambda: draw(whole, {k: laws[k] for k in ("viscous", "Coulomb", "quadratic")})
        )


def _numbers(one: Law) -> str:
    own = {k: v for k, v in one.numbers.items() if k.split(".")[0] not in (*MEASURED, "w0")}
    return ", ".join(f"{value:.4f}" for value in own.values())


if __name__ == "__main__":
    main()
