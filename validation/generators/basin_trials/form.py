"""Data types: laws, runs side by side, and the moment of a motion that a law acts on.

Core axes: surge along the core (the direction of thrust), sway to its left.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .robots import Robot

Array = NDArray[Any]
Quantity = Any
"""A real or complex number, or an array of them."""
POOL_LENGTH, POOL_WIDTH = 2.6, 1.6
"""Sides of the pool, m."""
HALF_DENSITY = 500.0
"""Half the density of water, kg/m3."""


@dataclass(frozen=True)
class Family:
    """One named cause with its functional forms.

    stage: input, water, head or body. act(now, law) changes the moment `now`. parameter, unit: of
    the size. start, limit: first and largest plausible size. signed: both signs occur.
    where: channel and variable that describe an unlisted force.
    """

    name: str
    stage: str
    act: Callable[[Situation, HiddenLaw], None]
    forms: tuple[str, ...]
    parameter: str
    unit: str
    start: float
    limit: float
    signed: bool = False
    where: tuple[str, str] | None = None


@dataclass(frozen=True)
class HiddenLaw:
    """A family in one of its forms, as it acts in a study.

    shape: three numbers between 0 and 1 that vary the form. size: in the unit of the family.
    path_error: what it leaves after the refit, m.
    """

    family: Family
    form: str
    shape: tuple[float, ...]
    size: float
    path_error: float = 0.0

    @property
    def name(self) -> str:
        """Name of the cause."""
        return self.family.name

    def sized(self, size: float) -> HiddenLaw:
        """The same with another size."""
        return replace(self, size=size)


@dataclass(frozen=True)
class Runs:
    """Inputs of runs side by side, each array (runs,).

    phi: head angle, rad. head: head length, m. flap: Hz. trial: index of the trial. begin: time of
    the first state, s. values: coefficient, `fin_area` (m2) or `fin_arm` (m) -> array.
    """

    phi: Array
    head: Array
    flap: Array
    trial: Array
    begin: Array
    values: Mapping[str, Array]

    def take(self, rows: Array | slice) -> Runs:
        """The runs of these indices."""
        values = {name: v[rows] for name, v in self.values.items()}
        return Runs(
            self.phi[rows], self.head[rows], self.flap[rows], self.trial[rows], self.begin[rows],
            values,
        )  # fmt: skip


@dataclass(frozen=True)
class AddedMass:
    """Added masses of surge and sway (kg), between sway and yaw (kg m), and of yaw (kg m2).

    munk: factor on the Munk moment -(sway - surge) u v.
    """

    surge: float
    sway: float
    coupling: float
    yaw: float
    munk: float


@dataclass
class Situation:
    """One moment of all runs, each quantity (runs,); laws read it and change it. SI and radians.

    x, y: centre of mass. psi: direction of the core. r: yaw rate. ground, water: velocities of
    robot and water in core axes, complex. u, v: surge and sway relative to the water. alpha: angle
    of attack of the head. turned: heading since the start. lag: state of a law with memory,
    lag_rate its derivative. phi, f: head angle and frequency, command the stated head angle.
    area: of the head. arm: from the centre of mass to the aerodynamic centre. wx, wy: velocity of
    the water in pool axes. X, Y, N: surge force, sway force and yaw moment. thrust: N.
    shift: of the centre of mass towards the head. lift_sine: sin 2 alpha in the lift.
    """

    t: Array
    robot: Robot
    runs: Runs
    x: Array
    y: Array
    psi: Array
    r: Array
    ground: Array
    lag: Array
    turned: Array
    phi: Array
    f: Array
    head: Array
    command: Array
    area: Array
    arm: Array
    wx: Quantity
    wy: Quantity
    X: Array
    Y: Array
    N: Array
    lag_rate: Array
    thrust_factor: Quantity = 1.0
    lift_factor: Quantity = 1.0
    drag_factor: Quantity = 1.0
    moment_factor: Quantity = 1.0
    shift: Quantity = 0.0
    added: AddedMass | None = None
    water: Quantity = 0.0
    u: Quantity = 0.0
    v: Quantity = 0.0
    speed: Quantity = 0.0
    alpha: Quantity = 0.0
    lift_sine: Quantity = 0.0
    thrust: Quantity = 0.0

    def resist(self, force: Quantity) -> None:
        """Add a resistance (N) against the motion through the water."""
        speed = np.maximum(self.speed, 1e-6)
        self.X = self.X - force * self.u / speed
        self.Y = self.Y - force * self.v / speed
