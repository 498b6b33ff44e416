"""A named cause and its alternatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

CREDIBLE_SET_PROBABILITY = 0.9
"""Posterior probability that a credible set holds the cause that acts in its place (the level of a
credible set: Wang, Sarkar, Carbonetto and Stephens, J. R. Stat. Soc. B 82 (2020), 1273), and from
which one of several alternatives is taken to act. `python -m validation score` counts how many sets
hold a hidden cause."""


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
