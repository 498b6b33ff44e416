"""`python -m examples.ball_drops FOLDER`: what gravity alone leaves out of eleven balls' falls."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from bluekoi.data import Float
from bluekoi.fitting import Noise, Series
from bluekoi.mismatch import MissingForce, Trialled

from ..command import plainly
from ..drawing import write
from ..engine import Case, bare_model, case, investigate, refitted, with_own_noise
from ..telling import coefficients, found, table
from ..where import shares
from ..where import told as told_where
from .errors import PUBLISHED_M2, Balls, drag_gain, others, rest_of_fall, told
from .model import SYSTEM
from .picture import Ball, draw
from .reading import FIRST_NOISE, read_folder

OUTSIDE = "linear_drag"
"""Valid for creeping flow (Reynolds numbers below 1), and these balls have 5e4 to 4e5. It is no
candidate; `laws` says what the paths alone would make of it."""
PUSHED = Noise(np.array([3.0, 0.1]), np.array([1.0, 0.5]), np.ones(1))
"""Random accelerations as large as what gravity leaves out (m/s2), to see where it is."""
SURE = 3.0
AIR_VISCOSITY = 1.5e-5
"""m2/s, at 15 degrees."""


def together(balls: Balls, *, apart: tuple[str, ...] = (OUTSIDE,)) -> Case:
    """All balls, gravity alone; a ball is a condition."""
    return case(SYSTEM, [replace(s, condition=s.group) for b in balls.values() for s in b],
                FIRST_NOISE, apart=apart)  # fmt: skip


def laws(given: Case) -> list[tuple[str, str, str]]:
    """Log likelihood, fitted and held out, of both laws of drag, without and with perspective."""
    bare, rows = bare_model(given), []
    for effects in (
        (OUTSIDE,),
        ("air_drag",),
        ("perspective", OUTSIDE),
        ("perspective", "air_drag"),
    ):
        model = with_own_noise(given, refitted(given, effects, bare))
        rows.append((" + ".join(effects), f"{model.fit.log_likelihood:.1f}", f"{model.total:.1f}"))
    return rows


def variables(drop: Series, force: MissingForce) -> dict[str, Float]:
    """What a missing acceleration may depend on, frame by frame."""
    height, speed = force.states[:, 0], -force.states[:, 1]
    return {
        "speed_m_s": speed,
        "height_m": height,
        "time_s": drop.times,
        "area_over_mass_m2_kg": np.full(len(height), drop.constants[1] / drop.constants[0]),
    }


def pair(value: tuple[float, float], digits: int = 2) -> str:
    """Value and deviation; in bold where it is sure to differ from nothing."""
    text = f"{value[0]:+.{digits}f} ± {value[1]:.{digits}f}"
    return f"**{text}**" if abs(value[0]) > SURE * value[1] else text


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--figure", type=click.Path(path_type=Path), help="Picture to write (png).")
@plainly
def main(folder: Path, figure: Path | None) -> None:
    """What gravity alone leaves out of the falls in FOLDER."""
    balls = read_folder(folder)
    given = together(balls)
    outcome = investigate(given)
    where = shares(given, outcome.choice.bare, PUSHED, variables, ("fall",))
    click.echo(told_where(where) + "\n")
    click.echo(f"Gravity alone: {coefficients(outcome)}\n\n{found(given, outcome)}\n")
    click.echo(table(("laws of drag", "log likelihood", "held out"), laws(given)) + "\n")
    seen, rows = one_by_one(given, outcome.chosen, balls)
    head = ("ball, left out of the fit", "drag coefficient", "gain by drag", "scale", "release, s",
            "error, m2", "expected", "published", "better")  # fmt: skip
    click.echo(table(head, rows))
    if figure:
        write(figure, lambda: draw(seen))


def one_by_one(
    given: Case, chosen: Trialled, balls: Balls
) -> tuple[dict[str, Ball], list[tuple[object, ...]]]:
    """Each ball by a model of the others: what its figure shows, and its row in the table."""
    seen: dict[str, Ball] = {}
    rows: list[tuple[object, ...]] = []
    for name, drops in balls.items():
        model = others(given, chosen.effects, chosen, name)
        rest, each = rest_of_fall(given, model, drops[0]), told(given, model, drops)
        seen[name] = Ball(name, each, reynolds(drops), rest)
        rows.append((
            name, _listed(d.drag for d in each), f"{drag_gain(given, model, drops):.0f}",
            _listed(d.scale for d in each), _listed(d.release_s for d in each),
            f"{rest.mean_square:.3f}", f"{rest.expected:.3f}", PUBLISHED_M2[name],
            "yes" if rest.mean_square < PUBLISHED_M2[name] else "no",
        ))  # fmt: skip
    return seen, rows


def _listed(values: Iterable[tuple[float, float]]) -> str:
    return "; ".join(pair(v) for v in values)


def reynolds(drops: Sequence[Series]) -> float:
    """Diameter times mean speed over the viscosity of air."""
    area = drops[0].constants[1]
    speeds = [(d.constants[3] - d.seen[-1, 0]) / d.times[-1] for d in drops]
    return float(2.0 * np.sqrt(area / np.pi) * np.mean(speeds) / AIR_VISCOSITY)


if __name__ == "__main__":
    main()
