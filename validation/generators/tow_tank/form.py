"""A functional form of a cause."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Shape = dict[str, float]
NO_SHAPE: dict[str, tuple[float, float]] = {}


@dataclass(frozen=True)
class Form:
    """One law: what it changes (`stage`), its formula, range of strength and range of shape.

    stage: shaft, servo, water, thrust, head, body, centre, inertia or label. signed: strength of
    either sign. channels: those in which it acts. variable: what an unlisted force depends on.
    """

    cause: str
    name: str
    stage: str
    law: Callable[[Any, float, Shape], Any]
    low: float
    high: float
    unit: str
    channels: tuple[str, ...]
    ranges: dict[str, tuple[float, float]]
    signed: bool = False
    memory: Callable[[Any, float, Shape], Any] | None = None
    variable: str = ""

    def draw(self, rng: np.random.Generator) -> Shape:
        """Numbers of the shape."""
        return {k: float(rng.uniform(*v)) for k, v in self.ranges.items()}


def forms(  # noqa: PLR0917  rows of a table
    cause: str,
    stage: str,
    low: float,
    high: float,
    unit: str,
    channels: str,
    laws: dict[str, Any],
    ranges: dict[str, tuple[float, float]] | None = None,
    **more: Any,
) -> list[Form]:
    """Forms of one cause that share a range; a law may bring its own ranges of shape."""
    out = []
    for name, entry in laws.items():
        law, own = entry if isinstance(entry, tuple) else (entry, ranges or NO_SHAPE)
        out.append(
            Form(cause, name, stage, law, low, high, unit, tuple(channels.split()), own, **more)
        )
    return out
