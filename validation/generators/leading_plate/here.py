"""What laws see and change at an instant, for many columns (trials and their variants) at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from .robots import Array, Robot

Complex = np.ndarray[Any, np.dtype[np.complex128]]


@dataclass(frozen=True)
class Setting:
    """What differs between columns; the last axis of every array counts columns.

    phi: head angle with its servo error (rad); flap: steady frequency (Hz); full: that at full
    power; head: length (m); thrust: factor; delay: rest before the release (s); since: time at
    which a simulation starts (s); order: place in the session, 0 to 1; span: duration (s); push:
    extra water velocity (2) and torque (1); swirl: (7, modes) of the water; jolts: (3, modes) of a
    torque.
    """

    phi: Array
    flap: Array
    full: Array
    head: Array
    thrust: Array
    delay: Array
    since: Array
    order: Array
    span: Array
    coefficients: Array
    fin: Array
    push: Array
    swirl: Array
    jolts: Array

    def columns(self, index: Array | slice) -> Setting:
        """The columns of an index, repeated where it repeats."""
        return Setting(**{f.name: getattr(self, f.name)[..., index] for f in fields(self)})

    def but(self, **changes: Array) -> Setting:
        """A copy with some arrays replaced."""
        return replace(self, **changes)


@dataclass(frozen=True)
class Law:
    """A hidden law. shape: two numbers from 0 to 1 that its form may use; side: -1 or 1."""

    name: str
    form: str
    size: float
    shape: tuple[float, float]
    side: int


@dataclass
class Here:
    """An instant. Velocities are complex numbers along the head plate (real) and across it.

    flow: velocity of the centre of mass relative to the water; core: the same along the core;
    lift, twist: force and whole moment of the plate's lift; force, moment: sums so far;
    aft: how much farther back the fin lies from the centre of mass than stated.
    """

    robot: Robot
    pool: tuple[float, float]
    setting: Setting
    time: Array
    place: Complex
    theta: Array
    rate: Array
    turned: Array
    lagged: Array
    phi: Array
    arm: Array
    water: Complex
    thrust: Array
    flow: Complex
    core: Complex
    speed: Array
    lift: Complex
    twist: Array
    force: Complex
    moment: Array
    aft: Array | float = 0.0
    masses: tuple[float, float, float, float, float] | None = None

    @property
    def side_slip(self) -> Array:
        """Sine of the angle of attack."""
        return -self.flow.imag / self.speed

    def resist(self, size: Array | float) -> None:
        """Add a force against the motion through the water."""
        self.force = self.force - size * self.flow / self.speed

    def push_core(self, along: Array | float, across: Array | float = 0.0) -> None:
        """Add a force given along and across the core, at the centre of mass."""
        self.force = self.force + (along + 1j * across) * np.exp(1j * self.phi)


Action = Callable[[Law, Here], None]


@dataclass(frozen=True)
class Family:
    """A cause and its forms. stage: `input` laws act before the loads are summed, `load` laws
    after. low, high: plausible sizes; probe: size at which it is tried as a rival.
    """

    name: str
    stage: str
    action: Action
    forms: tuple[str, ...]
    low: float
    high: float
    unit: str
    meaning: str
    probe: float
