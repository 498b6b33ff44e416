"""Sizes of hidden causes from the ideal detector."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .detector import Fault, Measured, Model, measured
from .experiment import Experiment, Variant
from .law import Family, Law
from .robots import Array
from .scatter import Scatter, flat

LEAST_SIGMA, MOST_SIGMA = 8.0, 40.0
LEAST_RATIO = 2.0
TARGET_RATIO = 2.3
TRIES = 5


@dataclass(frozen=True)
class Hidden:
    """What is hidden so far: laws with sizes, and an error of measurement."""

    laws: tuple[Law, ...] = ()
    fault: Fault | None = None

    @property
    def sizes(self) -> tuple[float, ...]:
        """Sizes of the laws."""
        return tuple(float(law.size) for law in self.laws)

    def starts(self, experiment: Experiment) -> Array:
        """True states at the starts of segments."""
        return experiment.segment_starts(self.laws, self.sizes)

    def shown(self, experiment: Experiment, starts: Array) -> Array:
        """The true observation, (trials, n)."""
        seen = experiment.observe([Variant(sizes=self.sizes)], self.laws, starts)
        return flat(self.fault(seen) if self.fault else seen)[0]

    def model(self, experiment: Experiment, starts: Array) -> Model:
        """The model that has all of it, from the true starts."""
        return Model(experiment, starts, self.laws, self.sizes, self.fault)


def lacking(
    experiment: Experiment, truth: Hidden, known: Hidden, scatter: Scatter, cause: str
) -> Measured:
    """What a model of `known` leaves over of `truth`, which has `cause` as well."""
    starts = truth.starts(experiment)
    shown = truth.shown(experiment, starts)
    return measured(known.model(experiment, starts), shown, scatter, cause)


def enough(found: Measured) -> bool:
    """Whether a cause is visible to the detector, not glaring, and clear in the path."""
    return LEAST_SIGMA <= found.sigma <= MOST_SIGMA and found.ratio >= LEAST_RATIO


def sized_law(
    rng: np.random.Generator, family: Family, experiment: Experiment, hidden: Hidden,
    scatter: Scatter,
) -> tuple[Law, Measured] | None:  # fmt: skip
    """A form of a family, sized to be `enough` beside what is hidden; None without a size."""
    sign = rng.choice([-1.0, 1.0]) if family.odd else 1.0
    law = Law(family, str(rng.choice(list(family.forms))), 0.0, float(rng.uniform()))

    def look(size: float) -> Measured:
        own = replace(law, size=sign * size)
        truth = Hidden((*hidden.laws, own), hidden.fault)
        return lacking(experiment, truth, hidden, scatter, family.name)

    found = search_size(rng, look, family.low, family.high)
    return (replace(law, size=float(sign * found[0])), found[1]) if found else None


def search_size(
    rng: np.random.Generator, look: Callable[[float], Measured], low: float, high: float
) -> tuple[float, Measured] | None:
    """A size in a range at which a cause is `enough`, by the secant method on logarithms.

    Aims at a drawn sigma of 10 to 30, or larger where the path error must be clear.
    """
    wanted = float(np.exp(rng.uniform(np.log(10), np.log(30))))
    size = float(np.sqrt(low * high))
    points: list[tuple[float, float]] = []
    for _ in range(TRIES):
        found = look(size)
        reach = min(found.sigma / wanted, found.ratio / TARGET_RATIO)
        reach = float(np.log(np.clip(reach, 1e-3, 1e3))) if np.isfinite(reach) else 7.0
        if enough(found) and abs(reach) < 0.15:
            return size, found
        points.append((float(np.log(size)), reach))
        following = _next_size(points, low, high)
        if abs(np.log(following / size)) < 0.02:
            break
        size = following
    return (size, found) if enough(found) else None


def _next_size(points: list[tuple[float, float]], low: float, high: float) -> float:
    place, reach = points[-1]
    slope = 1.0
    if len(points) > 1 and abs(place - points[-2][0]) > 1e-6:
        slope = float(np.clip((reach - points[-2][1]) / (place - points[-2][0]), 0.4, 2.5))
    return float(np.clip(np.exp(place - np.clip(reach / slope, -2.0, 2.0)), low, high))
