"""`python -m examples.ball_drops FOLDER`: what gravity alone leaves out of eleven balls' falls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from pipeline.fitting import Free, Series, shoot
from pipeline.mismatch import Trialled

from ..engine import Case, Outcome, bare_model, case, investigate, refitted, values_of
from ..telling import coefficients, found, table
from .model import GRAVITY, SYSTEM
from .reading import FIRST_NOISE, read_folder

TRAINED_S = 2.0
PUBLISHED_M2 = {
    "Baseball": 0.300,
    "Blue Basketball": 0.620,
    "Green Basketball": 0.088,
    "Volleyball": 0.111,
    "Bowling Ball": 0.413,
    "Golf Ball": 0.009,
    "Tennis Ball": 0.091,
    "Whiffle Ball 1": 1.58,
    "Whiffle Ball 2": 1.175,
    "Yellow Whiffle Ball": 0.428,
    "Orange Whiffle Ball": 17.2,
}
"""Mean square errors (m2) after 2 s of the best models in de Silva et al., Discovery of physics
from data: universal laws and discrepancies, Frontiers in AI 3 (2020), 25."""

Balls = Mapping[str, tuple[Series, ...]]


def together(balls: Balls) -> Case:
    """All balls, gravity alone; a ball is a condition."""
    return case(SYSTEM, [replace(s, condition=s.group) for b in balls.values() for s in b],
                FIRST_NOISE)  # fmt: skip


def with_drag(balls: Balls) -> Case:
    """All balls, each with a drag coefficient of its own; what else is there?"""
    given = case(SYSTEM, [s for b in balls.values() for s in b], FIRST_NOISE, within=["air_drag"])
    return replace(given, coefficients=tuple(Free("air_drag.C", ball) for ball in balls))


def alone(drops: tuple[Series, ...], like: Trialled) -> Outcome:
    """One ball by itself, gravity alone, under noise known from all."""
    given = case(SYSTEM, drops, like.noise)
    return investigate(given)


def early(one: Series) -> Series:
    """A drop of which only the first two seconds were seen."""
    return replace(one, seen=np.where(one.times[:, None] < TRAINED_S, one.seen, np.nan))


def tested(balls: Balls, effects: tuple[str, ...], like: Trialled) -> dict[str, float]:
    """Ball -> mean square error (m2) after the first two seconds, mean of its drops.

    Its drag and its starts come from its own first two seconds; what the camera does to all drops
    alike (and the other balls' drags) from the other balls.
    """
    given = with_drag(balls)
    out = {}
    for ball, drops in balls.items():
        trained = [early(s) if s.group == ball else s for s in given.series]
        model = refitted(given, effects, like, trained)
        seen = [early(s) for s in drops]
        shots = shoot(given.kernel, seen, values_of(given, model, seen), open_states=2)
        late = [s.times >= TRAINED_S for s in drops]
        out[ball] = float(np.mean([
            np.mean((s.seen - shot.observed)[k] ** 2)
            for s, shot, k in zip(drops, shots, late, strict=True)
        ]))  # fmt: skip
    return out


def released(balls: Balls, model: Trialled) -> dict[str, list[float]]:
    """Ball -> moment of release of each drop, s after its first frame, by the speed gained."""
    given = with_drag(balls)
    out = {}
    for ball, drops in balls.items():
        shots = shoot(given.kernel, drops, values_of(given, model, drops), open_states=2)
        out[ball] = [float(s.times[0] + shot.start[1] / GRAVITY)
                     for s, shot in zip(drops, shots, strict=True)]  # fmt: skip
    return out


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
def main(folder: Path) -> None:
    """What gravity alone leaves out of the falls in FOLDER."""
    balls = read_folder(folder)
    first = together(balls)
    outcome = investigate(first)
    click.echo(f"All balls, gravity alone:\n\n{found(first, outcome)}\n")
    second = with_drag(balls)
    more = investigate(second)
    click.echo(f"Each ball with its own drag: {coefficients(more)}\n\n{found(second, more)}\n")
    bare, chosen = bare_model(second), more.chosen
    before, after = tested(balls, (), bare), tested(balls, chosen.effects, chosen)
    moments = released(balls, chosen)
    rows = []
    for ball, drops in balls.items():
        single = alone(drops, chosen)
        rows.append((
            ball, ", ".join(single.chosen.effects) or "nothing",
            ", ".join(f"{d:+.2f}" for d in moments[ball]), f"{before[ball]:.3f}",
            f"{after[ball]:.3f}", PUBLISHED_M2[ball],
            "yes" if after[ball] < PUBLISHED_M2[ball] else "no",
        ))  # fmt: skip
    head = ("ball", "named by itself", "release, s", "drag alone, m2", "all named, m2",
            "published, m2", "better")  # fmt: skip
    click.echo(table(head, rows))


if __name__ == "__main__":
    main()
