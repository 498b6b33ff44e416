"""Data types: forms of causes, hidden causes, trials side by side, and one moment of their motion.

Core axes: surge along the core (the direction of thrust), sway to its left, as one complex number.
Any array may have shape (trials,) or (trials, knots).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

Array = np.ndarray
PHYSICS, MEASUREMENT, UNLISTED = "physics", "measurement", "unlisted"


@dataclass(frozen=True)
class Form:
    """One functional form of a cause.

    stage: where the law acts (`motion`, `faults`). start, limit: first and greatest strength in
    `unit`. shape: further parameters with their ranges. variable: name in `where` of mismatch.json.
    """

    cause: str
    name: str
    stage: str
    law: Callable[..., Any]
    channels: tuple[str, ...]
    variable: str
    unit: str
    start: float
    limit: float
    shape: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    kind: str = PHYSICS
    odd: bool = False


@dataclass(frozen=True)
class HiddenCause:
    """A form with its strength (in the form's unit) and its shape parameters."""

    form: Form
    strength: float
    parameters: Mapping[str, float]

    def sized(self, strength: float) -> HiddenCause:
        """The same with another strength."""
        return replace(self, strength=strength)


@dataclass(frozen=True)
class ParallelTrials:
    """Trials side by side, each array (trials,) or (trials, 1).

    angle: commanded head angle plus the constant error of the servo, rad. hertz: flapping frequency
    of the driven motor. head: head length, m. start: complex position of release, m. heading: core
    direction at release, rad. pool: length and width, m.
    """

    angle: Array
    hertz: Array
    head: Array
    start: Array
    heading: Array
    pool: tuple[float, float]

    def columns(self) -> ParallelTrials:
        """The same with arrays of shape (trials, 1), to go with many knots."""
        names = ("angle", "hertz", "head", "start", "heading")
        return replace(self, **{name: getattr(self, name)[:, None] for name in names})


@dataclass(frozen=True)
class InstantaneousState:
    """What laws may depend on; SI units and radians.

    place: complex position. flow: velocity relative to the water in core axes, complex.
    heading: direction of the core. rate: yaw rate. angle: head angle. attack: angle of attack of
    the head. thrust: N. turned: heading minus heading at release. lag: two states of memory laws.
    """

    t: Array
    place: Array
    flow: Array
    heading: Array
    rate: Array
    angle: Array
    attack: Array
    hertz: Array
    thrust: Array
    area: Array
    turned: Array
    lag: Array
    lanes: ParallelTrials

    @property
    def speed(self) -> Array:
        """Speed relative to the water, m/s."""
        return np.abs(self.flow)

    @property
    def ahead(self) -> Array:
        """Unit vector of the flow velocity in core axes; 0 at rest."""
        return self.flow / np.maximum(self.speed, 1e-9)
