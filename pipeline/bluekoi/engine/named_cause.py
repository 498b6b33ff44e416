"""A named cause and its alternatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

CREDIBLE_SET_PROBABILITY = 0.9
"""Probability that a credible set holds the cause, and from which one of several alternatives is
taken to act."""


@dataclass(frozen=True)
class NamedCause:
    """A named cause: probability that it acts, and others that may act in its place."""

    name: str
    probability: float
    alternatives: Mapping[str, float]

    @property
    def credible_set(self) -> list[str]:
        """The fewest causes of the place, the most probable first, that hold 90 % of it."""
        place = {self.name: self.probability, **self.alternatives}
        total, out, held = sum(place.values()), [], 0.0
        for name in sorted(place, key=lambda n: -place[n]):
            out.append(name)
            held += place[name]
            if held >= CREDIBLE_SET_PROBABILITY * total:
                break
        return out
