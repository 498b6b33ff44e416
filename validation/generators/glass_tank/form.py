"""What a cause is, and what a law is given to act on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .camera import Camera
    from .robots import Robot

Array = NDArray[Any]
Quantity = Any
"""A real or complex number, or an array of them."""
Shape = dict[str, Any]
PHYSICS, MEASUREMENT, UNLISTED = "physics", "measurement", "unlisted"
DT = 0.025
"""Step of the simulation, s."""


def _no_shape(*_: Any) -> Shape:
    """Shape parameters of a family that has none."""
    return {}


@dataclass(frozen=True)
class Family:
    """One named cause with its functional forms.

    laws: place of the equations or of the measurement -> function(situation, strength, cause).
    span: plausible range of the strength in units of `scale`: "1" pure number, "T" thrust at full
    power (N), "TL" thrust x body length (N m), "V" top speed (m/s), "L" body length (m), "s"
    seconds, "Z" water depth per second (m/s), "px" pixels.
    parity: under reflection in a vertical plane, "even", "odd" or "pool" (tied to the pool's axes),
    or one for each form.
    signed: both signs occur, in all forms or in those listed.
    memory: number of memory states of the forms that have any.
    draw: function(rng, robot, form) that draws the shape parameters.
    seen: the labels show the cause directly, so sigma has no upper limit.
    """

    name: str
    laws: Mapping[str, Callable[[Any, Quantity, Cause], None]]
    forms: tuple[str, ...]
    channels: tuple[str, ...]
    variable: str
    unit: str | Mapping[str, str]
    scale: str
    span: tuple[float, float]
    kind: str = PHYSICS
    parity: str | Mapping[str, str] = "even"
    signed: bool | tuple[str, ...] = False
    memory: Mapping[str, int] = field(default_factory=dict)
    draw: Callable[[np.random.Generator, Robot, str], Shape] = _no_shape
    seen: bool = False

    def parity_of(self, form: str) -> str:
        """Parity of one functional form."""
        return self.parity if isinstance(self.parity, str) else self.parity.get(form, "even")

    def unit_of(self, form: str) -> str:
        """Unit of the strength of one functional form."""
        return self.unit if isinstance(self.unit, str) else self.unit[form]

    def signed_in(self, form: str) -> bool:
        """Whether this form occurs with both signs."""
        return self.signed if isinstance(self.signed, bool) else form in self.signed


@dataclass
class Cause:
    """A family with its form, shape parameters and strength, as it acts in one study.

    rows: its memory states, counted from the first memory state.
    """

    family: Family
    form: str
    shape: Shape
    strength: float = 1.0
    rows: slice = field(default_factory=lambda: slice(0, 0))

    @property
    def memory_states(self) -> int:
        """Number of memory states."""
        return self.family.memory.get(self.form, 0)


@dataclass
class Trials:
    """Constants of the trials, each (trials,).

    flap: flapping frequency, Hz. phi: commanded head angle, rad. head: head length, m.
    heading: first core direction, rad. session: place in the session, 0 to 1.
    """

    flap: Array
    phi: Array
    head: Array
    heading: Array
    session: Array

    def take(self, trial: Array) -> Trials:
        """The constants of the trials of these indices, one each."""
        return Trials(*(getattr(self, f.name)[trial] for f in fields(self)))


@dataclass(frozen=True)
class Disturbance:
    """What moves the robot at random.

    push: acceleration by the tail at full power: surge, sway (m/s2), yaw (rad/s2). drift: velocity
    of the water, complex, m/s. servo: error of the head angle, rad.
    """

    push: Array
    drift: Quantity
    servo: Quantity


@dataclass
class AddedMass:
    """Added mass along surge, sway (kg) and yaw (kg m2), and between sway and yaw (kg m).

    munk: factor on the Munk moment -(sway - surge) u w.
    """

    surge: Array
    sway: Array
    yaw: Array
    coupling: Array
    munk: float


@dataclass
class Situation:
    """Everything a law of the motion may depend on or change, in SI units; arrays are (trials,).

    The fields are filled in the order of the equations. velocity: over ground, complex, pool axes.
    water: velocity of the water, complex. relative: velocity through the water; speed, direction:
    its size and unit vector; u, w: its components ahead and to port. r: yaw rate. axis, head_axis:
    unit vectors of core and head. flap: Hz. phi, alpha: rad. q: dynamic pressure x plate area, N.
    arm: from the centre of mass to the centre of pressure of the plate. memory: states of laws with
    history.
    """

    t: Array
    trials: Trials
    robot: Robot
    flap: Quantity = 0.0
    phi: Quantity = 0.0
    x: Quantity = 0.0
    y: Quantity = 0.0
    psi: Quantity = 0.0
    r: Quantity = 0.0
    velocity: Quantity = 0.0
    memory: Quantity = 0.0
    memory_rates: Quantity = 0.0
    axis: Quantity = 0.0
    head_axis: Quantity = 0.0
    water: Quantity = 0.0
    relative: Quantity = 0.0
    speed: Quantity = 0.0
    direction: Quantity = 0.0
    u: Quantity = 0.0
    w: Quantity = 0.0
    alpha: Quantity = 0.0
    q: Quantity = 0.0
    thrust: Quantity = 0.0
    C_D0: float = 0.0
    C_L: Quantity = 0.0
    C_M: Quantity = 0.0
    C_D: Quantity = 0.0
    arm: Quantity = 0.0
    force: Quantity = 0.0
    moment: Quantity = 0.0
    added: AddedMass | None = None
    rates: Quantity = 0.0


@dataclass
class Clock:
    """Frames that the study dates `stated` (s); t: motor time (s). trial: index of the trial."""

    stated: Array
    trial: Array
    t: Array


@dataclass
class Look:
    """The labels of a robot on their way to the picture.

    labels: positions in core axes, complex, m. offset: common shift, m. depth, pool_depth: m.
    middle: centre of the picture, px. pixels: (5, frames), complex.
    """

    phi: Array
    clock: Clock
    labels: list[Quantity]
    depth: Array
    index: float
    pool_depth: float
    camera: Camera
    middle: complex
    offset: Quantity = 0j
    pixels: Quantity = 0j


@dataclass
class Marks:
    """The marks at the corners of the pool. size: length and width between them, m."""

    size: Array
    camera: Camera


def act(place: str, on: Any, causes: Sequence[Cause], strengths: Sequence[float] | Array) -> None:
    """Let every cause with a law for this place change the situation `on`."""
    for cause, strength in zip(causes, strengths, strict=True):
        law = cause.family.laws.get(place)
        if law is not None:
            law(on, strength, cause)


def strengths_of(causes: Sequence[Cause]) -> list[float]:
    """Strengths of the causes."""
    return [cause.strength for cause in causes]


def give_rows(causes: Sequence[Cause]) -> int:
    """Distribute the memory states over the causes; returns their total number."""
    total = 0
    for cause in causes:
        cause.rows = slice(total, total + cause.memory_states)
        total += cause.memory_states
    return total
