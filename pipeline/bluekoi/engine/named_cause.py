"""A named cause and its alternatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .calibration import calibrated_probability, calibrated_shares_of_alternatives

CREDIBLE_SET_PROBABILITY = 0.9
"""Posterior probability that a credible set holds the cause that acts in its place (the level of a
credible set: Wang, Sarkar, Carbonetto and Stephens, J. R. Stat. Soc. B 82 (2020), 1273), and from
which one of several alternatives is taken to act. `python -m validation score` counts how many sets
hold a hidden cause."""


@dataclass(frozen=True)
class NamedCause:
    """A named cause and others that may act in its place, each with its posterior probability."""

    name: str
    posterior: float
    alternatives: Mapping[str, float]

    @property
    def probability(self) -> float:
        """Calibrated probability that the cause acts."""
        return calibrated_probability(self.posterior)

    @property
    def alternative_probabilities(self) -> dict[str, float]:
        """Calibrated probabilities of the alternatives: what the named cause leaves of 1, divided
        by their calibrated shares. For one alternative with posterior 1 - p, this is that of 1 - p.
        """
        rest = 1.0 - self.probability
        return {
            n: rest * share
            for n, share in calibrated_shares_of_alternatives(self.alternatives).items()
        }

    @property
    def credible_set(self) -> list[str]:
        """The fewest causes of the place, the most probable first, that hold 90 % of its calibrated
        shares.
        """
        shares = calibrated_shares_of_alternatives({self.name: self.posterior, **self.alternatives})
        out, held = list[str](), 0.0
        for name in sorted(shares, key=lambda n: -shares[n]):
            out.append(name)
            held += shares[name]
            if held >= CREDIBLE_SET_PROBABILITY:
                break
        return out
