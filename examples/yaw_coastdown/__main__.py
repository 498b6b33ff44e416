"""`python -m examples.yaw_coastdown FOLDER`: each part of the damping withheld in turn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from bluekoi.fitting import Noise, Series, Shot, thinned
from bluekoi.mismatch import try_effects

from ..command import plainly
from ..drawing import write
from ..engine import Case, bare_model, beside, case, foretold, investigate
from ..telling import asked, coefficients, found, table
from .model import SYSTEM
from .picture import draw
from .reading import FIRST_NOISE, read_folder

FREE_RUN = Noise(np.array([1e-4, 0.0]), np.array([1.0, 0.2]), np.array([4.0]))
"""Hardly any random moment: the fit is to whole runs."""
LADDER = (
    (),
    ("quadratic_yaw_damping",),
    ("quadratic_yaw_damping", "constant_moment"),
    ("quadratic_yaw_damping", "gyro_bias"),
)


DAMPING = ("quadratic_yaw_damping", "dry_friction", "gyro_scale")
SHIFTS = ("gyro_bias", "constant_moment")
SHOWN = {"linear": LADDER[0], "linear, quadratic, gyro bias": LADDER[3]}


def withheld(trials: tuple[Series, ...], known: str) -> Case:
    """The search with one kind of damping known and all else left out."""
    return case(SYSTEM, [thinned(t) for t in trials], FIRST_NOISE, within=[known])


def left_out(given: Case, trials: tuple[Series, ...], effects: tuple[str, ...]) -> list[Shot]:
    """Free run of each spin-down by the model fitted to the others' whole runs, as the figures
    before it were.
    """
    whole = replace(given, series=trials, noise=FREE_RUN)
    model = try_effects(whole.kernel, trials, whole.base, whole.coefficients, effects,
                        noise=FREE_RUN, iterations=25)  # fmt: skip
    return foretold(whole, model, open_states=1)


def error_rad_s(given: Case, trials: tuple[Series, ...], effects: tuple[str, ...]) -> float:
    """Root mean square error of the runs left out."""
    shots = left_out(given, trials, effects)
    squares = [np.mean((t.seen - s.observed) ** 2) for t, s in zip(trials, shots, strict=True)]
    return float(np.sqrt(np.mean(squares)))


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--figure", type=click.Path(path_type=Path), help="Picture to write (png).")
@plainly
def main(folder: Path, figure: Path | None) -> None:
    """What damps the vessel in FOLDER, and what shifts it."""
    trials = read_folder(folder)
    for known in ("linear_yaw_damping", "quadratic_yaw_damping"):
        given = withheld(trials, known)
        outcome = investigate(given)
        click.echo(f"\n{known} known, the rest withheld: {coefficients(outcome)}\n")
        click.echo(found(given, outcome))
    given = withheld(trials, "linear_yaw_damping")
    damping = beside(given, bare_model(given), DAMPING)
    click.echo("\n" + asked("what damps beside linear damping", damping))
    shifts = beside(given, damping["quadratic_yaw_damping"].model, SHIFTS)
    click.echo("\n" + asked("what shifts, beside quadratic damping", shifts))
    rows = [(" + ".join(("linear", *e)), f"{error_rad_s(given, trials, e):.4f}") for e in LADDER]
    click.echo("\n" + table(("model", "leave-one-out error, rad/s"), rows))
    if figure:
        runs = {name: [s.observed[:, 0] for s in left_out(given, trials, effects)]
                for name, effects in SHOWN.items()}  # fmt: skip
        write(figure, lambda: draw(trials, runs))


if __name__ == "__main__":
    main()
