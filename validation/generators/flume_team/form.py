"""What a hidden cause is, and what a law is given to compute with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .robots import Robot

Array = NDArray[np.float64]
PHYSICS, MEASUREMENT, UNLISTED = "physics", "measurement", "unlisted"
REFERENCE_SPEED = 0.3
"""Speed at which forces of powers of speed have their strength, m/s."""


@dataclass(frozen=True)
class Form:
    """One functional form of a cause.

    acts_on: `force`, `thrust`, `frequency`, `angle`, `head`, `water`, `mass`, `centre`, `view`,
    or `depth`: the place in the equations, which fixes the arguments and the result of `law`.
    start, limit: first guess and largest plausible strength, in `unit`.
    shape: parameter -> range it is drawn from. signed: the strength has either sign.
    """

    cause: str
    law: Callable[..., Any]
    acts_on: str
    unit: str
    start: float
    limit: float
    channels: tuple[str, ...]
    variable: str
    kind: str = PHYSICS
    shape: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    signed: bool = False

    @property
    def name(self) -> str:
        """Name of the form, that of its law."""
        return self.law.__name__


@dataclass(frozen=True)
class HiddenCause:
    """A form with its strength (in the form's unit) and shape parameters."""

    form: Form
    strength: float
    parameters: Mapping[str, float]

    def scaled(self, factor: float) -> HiddenCause:
        """The same cause with its strength multiplied."""
        return replace(self, strength=self.strength * factor)


@dataclass(frozen=True)
class Lanes:
    """Constants of the trials, each (trials,).

    phi: actual head angle, rad. flap: thrust frequency, Hz. head: head length, m.
    heading: first core direction, rad. luck: random number between 0 and 1 for laws
    that differ among trials. pool: length and width, m.
    """

    phi: Array
    flap: Array
    head: Array
    heading: Array
    luck: Array
    pool: tuple[float, float]


@dataclass
class Situation:
    """Everything a law may depend on; arrays broadcast to (..., trials).

    u, v: forward and leftward speed relative to the water in core axes, m/s. r: yaw rate, rad/s.
    speed: m/s. alpha: angle of attack of the head, rad. thrust: N. q: dynamic pressure x A, N.
    x, y: m, pool frame. psi: core direction, rad. phi: head angle, rad. t: s.
    memory: (2, ..., trials), states of laws with history.
    """

    t: Array
    x: Array
    y: Array
    psi: Array
    u: Array
    v: Array
    r: Array
    speed: Array
    alpha: Array
    phi: Array
    flap: Array
    thrust: Array
    q: Array
    memory: Array
    lanes: Lanes
    robot: Robot
