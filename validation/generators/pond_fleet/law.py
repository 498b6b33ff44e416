"""A hidden law: one functional form of a cause with its size.

A form is a function (flow, size, shape) whose result depends on the stage of its family:

load      Load                                thrust    factor on the thrust
polar     factors on lift, drag and moment    shaft     frequency over its steady value
servo     present head angle (rad)            water     velocity of the water in the pool (m/s)
inertia   added inertia, share of its moment  lag       lagged lift, and rates of two states
centre    centre of mass from the design centre, forward and to port (m)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

STAGES = ("servo", "shaft", "water", "thrust", "polar", "lag", "load", "inertia", "centre")


@dataclass(frozen=True)
class Family:
    """The forms of a cause, and its size from `low` to `high` in `unit`.

    odd: distinguishes port from starboard; the size then has a random sign. where: channel and
    variable of a force that is not on the list.
    """

    name: str
    stage: str
    meaning: str
    unit: str
    low: float
    high: float
    forms: Mapping[str, Callable[..., Any]]
    odd: bool = False
    where: tuple[str, str] | None = None


@dataclass(frozen=True)
class Law:
    """A form of a family. shape: a free number, 0 to 1, for what the size leaves open."""

    family: Family
    form: str
    size: Any
    shape: float

    def __call__(self, *arguments: Any) -> Any:
        """Result of the form; its meaning depends on the family's stage."""
        return self.family.forms[self.form](*arguments, self.size, self.shape)


def by_name(*functions: Callable[..., Any]) -> dict[str, Callable[..., Any]]:
    """Forms under the names of their functions."""
    return {function.__name__: function for function in functions}
