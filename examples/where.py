"""Where the missing force of a model sits: what it depends on, by conditions left out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from bluekoi.data import Float
from bluekoi.fitting import Noise, Series
from bluekoi.mismatch import MissingForce, Trialled, dependences, missing_force

from .engine import Case, values_of
from .telling import table

Variables = Callable[[Series, MissingForce], Mapping[str, Float]]


def shares(
    given: Case, model: Trialled, noise: Noise, variables: Variables, channels: Sequence[str]
) -> list[tuple[str, str, float]]:
    """Channel, variable, share of the missing force that a smooth curve over the variable foretells
    in conditions left out; the largest first.

    noise: with random forces that may be as large as what is missing.
    """
    series = given.series
    forces = missing_force(given.kernel, series, values_of(given, model, series), noise)
    seen = [variables(s, f) for s, f in zip(series, forces, strict=True)]
    pushes = [f.force for f in forces]
    found = dependences(series, pushes, seen, noise.disturbance[: len(channels)])
    return [(channels[d.channel], d.variable, d.share) for d in found]


def told(rows: Sequence[tuple[str, str, float]], count: int = 5) -> str:
    """The first rows as a table."""
    shown = [(channel, f"`{name}`", f"{share:.2f}") for channel, name, share in rows[:count]]
    return table(("missing force", "depends on", "share foretold"), shown)
