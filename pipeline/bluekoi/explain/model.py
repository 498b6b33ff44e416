"""A model in one file: states, inputs, coefficients, equations and candidate causes, with units.

Every equation is a short function whose arguments are named after what it needs: states, inputs,
constants, coefficients, `t`, or outputs of stages before it. It returns a tuple of numbers.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..data import Float
from ..fitting import TrialEffect
from ..integrate import Parameter, Stage

Function = Callable[..., Any]
CorrelationTimeStartAndBounds = tuple[float, float, float]
"""Start, shortest and longest correlation time, s."""
CAUSE_KINDS = ("physics", "measurement")
FORCE_STAGE, RATES_STAGE, OBSERVE_STAGE = "force", "rates", "observe"
"""Names of the stages that every model has."""


@dataclass(frozen=True)
class State:
    """A state of the model.

    Its initial value in a trial is the first value of the observation `observed`, or the initial
    slope of the observation `rate_of`, estimated from the first eight samples at most, or else
    `start`. start_std: standard deviation of this initial value, in the unit of the state; that of
    the estimate is added.
    """

    name: str
    unit: str
    start_std: float
    start: float = 0.0
    observed: str = ""
    rate_of: str = ""


@dataclass(frozen=True)
class Input:
    """A measured input. held: the input keeps its value until the next sample (zero-order hold), as
    the output of a digital controller does. Otherwise it is interpolated linearly.
    """

    name: str
    unit: str
    held: bool = False


@dataclass(frozen=True)
class Constant:
    """A known number that may differ between trials (a mass, a length). value: that of trials
    that do not state one.
    """

    name: str
    unit: str
    value: float = math.nan


@dataclass(frozen=True)
class Observation:
    """A measured output. std: the smallest standard deviation of its errors that a fit may assume.
    angle: it is an angle, from which jumps by 2 pi are removed.
    """

    name: str
    unit: str
    std: float
    angle: bool = False


@dataclass(frozen=True)
class Cause:
    """A candidate cause: a statement and functions that are added to stages of the model.

    - hooks: name of a stage -> function, whose outputs are added to those of the stage;
    - parameters; strengths: number of leading parameters that are 0 if the cause is absent;
    - site: the cause belongs to the place of the recording (a current, a clock) and is not applied
      to recordings made elsewhere;
    - channels: outputs of the stage `force` that the cause changes. Default: found from `hooks`;
    - states, rates, start_std: states of the cause, the function that gives their derivatives, and
      the standard deviation of their initial values about 0;
    - prior: probability that the cause acts, before any data;
    - regime: in which motions the cause can be seen;
    - evidence: for quantities that `Trial.evidence` states: name of the quantity -> parameter ->
      change of the quantity per unit of the parameter.
    """

    name: str
    statement: str
    hooks: Mapping[str, Function]
    parameters: Sequence[Parameter]
    kind: str = "physics"
    site: bool = False
    strengths: int = 1
    channels: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    rates: Function | None = None
    start_std: float = 1e-6
    prior: float = math.nan
    regime: str = ""
    evidence: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Model:
    """A state-space model with its candidate causes.

    - stages: the equations, in the order of their evaluation. The stage `rates` returns the
      derivatives of the states, `observe` the observations. Causes can add to stages with
      `open=True`;
    - pushed: outputs to which random forces are added. Default: those of the stage `force`; (): no
      random forces;
    - random_force_s, error_s: correlation time of the random forces, and of errors of the
      observations that last longer than a sample. Each is (start of the fit, shortest, longest);
    - per_group: coefficients that have a value of their own in each group of trials;
    - varies: parameters that differ between trials, with the standard deviation of the difference;
    - path: two observations that are the coordinates of a position;
    - start: function (times (n,), observed (n, observations)) -> initial values of all states;
    - measures: function (times, observed, inputs) -> name -> value. These values of recorded and
      predicted trials are compared, for example a diameter;
    - most_hz: observations at a higher rate are averaged to this one. Default: from the time
      constants of the model;
    - read: function (folder) -> trials, for files in another layout than the usual one.
    """

    name: str
    states: Sequence[State]
    observations: Sequence[Observation]
    coefficients: Sequence[Parameter]
    stages: Sequence[Stage]
    causes: Sequence[Cause] = ()
    inputs: Sequence[Input] = ()
    constants: Sequence[Constant] = ()
    pushed: tuple[str, ...] | None = None
    random_force_s: CorrelationTimeStartAndBounds = (0.5, 0.02, 10.0)
    error_s: CorrelationTimeStartAndBounds = (0.2, 0.01, 2.0)
    per_group: tuple[str, ...] = ()
    varies: Sequence[TrialEffect] = ()
    path: tuple[str, ...] = ()
    start: Callable[[Float, Float], Sequence[float]] | None = None
    measures: Callable[[Float, Float, Float], Mapping[str, float]] | None = None
    most_hz: float | None = None
    read: Callable[..., Any] | None = None

    @property
    def variables(self) -> tuple[State | Input, ...]:
        """States, then inputs."""
        return (*self.states, *self.inputs)

    @property
    def given_names(self) -> set[str]:
        """Names of states, inputs, constants and coefficients, and `t`."""
        named = (*self.states, *self.inputs, *self.constants, *self.coefficients)
        return {x.name for x in named} | {"t"}  # type: ignore[attr-defined]

    @property
    def by_name(self) -> dict[str, Cause]:
        """Causes by name."""
        return {c.name: c for c in self.causes}

    @property
    def force(self) -> Stage | None:
        """The stage that random forces and residual terms add to."""
        if self.pushed == ():
            return None
        for stage in self.stages:
            if stage.open and stage.name not in (RATES_STAGE, OBSERVE_STAGE):
                wanted = self.pushed is None and stage.name == FORCE_STAGE
                if wanted or (self.pushed and set(self.pushed) <= set(stage.outputs)):
                    return stage
        return None

    @property
    def channels(self) -> tuple[str, ...]:
        """Outputs that random forces push."""
        stage = self.force
        return self.pushed or (stage.outputs if stage else ())

    def unit_of(self, name: str) -> str:
        """Unit of a state, input, constant or observation."""
        units = {x.name: x.unit for x in self.variables}
        units |= {c.name: c.unit for c in self.constants}
        return (units | {o.name: o.unit for o in self.observations}).get(name, "")


def names_of_arguments(function: Function) -> tuple[str, ...]:
    """Names of a function's arguments."""
    return tuple(inspect.signature(function).parameters)


def variables_of_cause(model: Model, cause: Cause) -> tuple[str, ...]:
    """States, inputs and time that a cause depends on, directly or through stages before it;
    `constant` where it depends on none.
    """
    makers = {
        o: s for s in model.stages for o in s.outputs if s.name not in (RATES_STAGE, OBSERVE_STAGE)
    }
    moving = {x.name for x in model.variables} | {"t"}
    todo = [a for f in cause.hooks.values() for a in names_of_arguments(f)]
    done: set[str] = set()
    while todo:
        name = todo.pop()
        if name in done:
            continue
        done.add(name)
        stage = makers.get(name)
        if stage is not None and stage.function is not None and name not in moving:
            todo += names_of_arguments(stage.function)
    found = tuple(sorted(done & moving))
    return found or ("constant",)


def channels_of_cause(model: Model, cause: Cause) -> tuple[str, ...]:
    """Outputs of the stage `force` that a cause pushes: all of them where it acts before it, none
    where it acts on the observations alone.
    """
    if cause.channels or set(cause.hooks) == {OBSERVE_STAGE}:
        return cause.channels
    stage = model.force
    function = cause.hooks.get(stage.name) if stage else None
    if stage is None or function is None or len(cause.hooks) > 1:
        return model.channels
    acting: set[str] = set()
    for k in range(3):
        values = [0.37 + 0.21 * k + 0.11 * i for i in range(len(names_of_arguments(function)))]
        try:
            out = function(*values)
        except ArithmeticError:
            return model.channels
        acting |= {name for name, v in zip(stage.outputs, out, strict=True) if v}
    return tuple(c for c in model.channels if c in acting) or model.channels
