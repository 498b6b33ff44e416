"""What a hidden law is: a family of forms, the size and the shape of one of them.

A form is one pure function of the flow about the robot, the robot, its size and its shape number.
Sizes are shares of the robot's reference drag or speed, so that one range serves all robots.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from .robots import Array, Robot

Form = Callable[..., Any]


@dataclass(frozen=True)
class Flow:
    """The robot in the water at one instant; every array has the shape (columns,).

    z: position (m, complex). v: velocity relative to the water in axes of the core (complex).
    psi: direction of the core. flap: Hz. turned: turned since the start (rad). thrust: N.
    """

    t: float
    z: Array
    v: Array
    speed: Array
    psi: Array
    phi: Array
    r: Array
    flap: Array
    thrust: Array
    turned: Array
    head: Array
    pool: tuple[float, float]

    @property
    def backward(self) -> Array:
        """Unit vector against the motion, in axes of the core; zero at rest."""
        return -self.v / (self.speed + 1e-9)


@dataclass(frozen=True)
class Family:
    """Forms of one cause. hook: what the forms change. low, high: range of the size.

    odd: the size may have either sign. where: channel and variable of an unlisted force.
    """

    name: str
    hook: str
    parameter: str
    unit: str
    low: float
    high: float
    forms: Mapping[str, Form]
    odd: bool = False
    where: tuple[str, str] | None = None


@dataclass(frozen=True)
class Law:
    """One form with its size; shape: number in 0 to 1 that sets lengths, onsets and directions."""

    family: Family
    form: str
    size: float
    shape: float

    @property
    def hook(self) -> str:
        """What the law changes."""
        return self.family.hook

    def __call__(self, *arguments: Any) -> Any:
        """Value of the form."""
        return self.family.forms[self.form](*arguments, self.size, self.shape)


def reference(flow: Flow, robot: Robot) -> Array:
    """V / V0: speed over the published straight speed at full power."""
    return flow.speed / robot.speed
