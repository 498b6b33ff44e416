"""`python -m examples.pendulum FOLDER`: which friction stops the pendulum."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from pipeline.fitting import Noise, Series, shoot
from pipeline.mismatch import try_effects

from ..engine import Case, case, investigate, values_of
from ..telling import coefficients, found, table
from .model import SYSTEM
from .reading import FIRST_NOISE, read_folder, stretches

LADDER = (
    (),
    ("viscous_friction",),
    ("coulomb_friction",),
    ("quadratic_friction",),
    ("rate_scale", "viscous_friction"),
    ("rate_scale", "coulomb_friction"),
    ("rate_scale", "quadratic_friction"),
    ("rate_scale", "viscous_friction", "quadratic_friction"),
)
FREE_RUN = Noise(np.array([1e-4, 0.0, 0.0]), np.array([0.5, 0.3, 0.3]), np.full(2, 2.0))
"""Hardly any random force: the fit is to the whole run, as those before it were made."""


def rms(whole: Series, effects: tuple[str, ...]) -> tuple[float, float]:
    """Root mean square of the angle (rad) and the rate (rad/s) over one free run of 94 s."""
    given = case(SYSTEM, [whole], FREE_RUN)
    model = try_effects(given.kernel, [whole], given.base, given.coefficients, effects,
                        noise=FREE_RUN, iterations=40)  # fmt: skip
    shot = shoot(given.kernel, [whole], values_of(given, model, [whole]), open_states=2,
                 iterations=30)[0]  # fmt: skip
    angle, rate = np.sqrt(np.mean((whole.seen - shot.observed) ** 2, axis=0))
    return float(angle), float(rate)


def searched(whole: Series) -> Case:
    """The search over stretches of the recording, friction withheld."""
    return case(SYSTEM, stretches(whole), FIRST_NOISE)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
def main(folder: Path) -> None:
    """Which friction stops the pendulum in FOLDER."""
    whole = read_folder(folder)
    given = searched(whole)
    outcome = investigate(given)
    click.echo(f"{coefficients(outcome)}\n\n{found(given, outcome)}\n")
    rows = [(" + ".join(e) or "no friction", *(f"{v:.4f}" for v in rms(whole, e))) for e in LADDER]
    click.echo(table(("friction", "rms angle, rad", "rms rate, rad/s"), rows))


if __name__ == "__main__":
    main()
