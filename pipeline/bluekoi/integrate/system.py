"""A state-space model in words and functions: stages of equations, and effects that add to them.

Nothing here knows what moves. A model is a chain of stages; each stage is one pure scalar function
whose arguments are named after what it needs (states, constants, inputs, parameters, `t`, or the
outputs of stages before it) and which returns its outputs as a tuple. An effect is a set of
functions of the same form, each added to the outputs of one stage that is open to additions.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

Function = Callable[..., Any]


@dataclass(frozen=True)
class Parameter:
    """One number to be fitted.

    - start, lower, upper: value at which a fit begins, and bounds;
    - spread: standard deviation of the normal prior about `start`, for shape parameters. It keeps a
      parameter that the trials hardly determine near its start. Infinite: no prior;
    - plausible: typical magnitude of a strength, the width of its prior. Default: |start|;
    - symbol: name of the parameter in the equation of an effect. Default: `name`;
    - bounded_by: constants of a trial that are the bounds where they are known (the first is less
      than the second), in the place of `lower` and `upper`;
    - tries: further starting values, for parameters whose likelihood has several maxima. A fit
      begins at the most likely one. For an effect that describes an error of the camera, such as a
      wrong lens, they have a second use: the finder computes for each of these values how the
      effect changes the measured distance between two keypoints of the same rigid part.
    """

    name: str
    unit: str
    start: float
    lower: float
    upper: float
    meaning: str
    spread: float = math.inf
    tries: tuple[float, ...] = ()
    plausible: float = math.nan
    symbol: str = ""
    bounded_by: tuple[str, str] | None = None

    @property
    def argument_name(self) -> str:
        """Name by which functions of an effect ask for it: its symbol, or else its name."""
        return self.symbol or self.name

    @property
    def typical_magnitude(self) -> float:
        """Plausible magnitude of a strength: `plausible`, or else the size of its start."""
        if math.isfinite(self.plausible):
            return self.plausible
        return abs(self.start) or 0.1 * (self.upper - self.lower)

    def with_trial_bounds(self, constants: Mapping[str, float]) -> Parameter:
        """The parameter between the bounds of a trial with these constants."""
        if self.bounded_by is None:
            return self
        low, high = (constants[name] for name in self.bounded_by)
        return replace(self, lower=low, upper=high) if low < high else self


@dataclass(frozen=True)
class Stage:
    """One step of the right-hand side of the differential equations: `outputs = function(...)`,
    plus the outputs that effects or causes add if the stage is `open`.
    """

    name: str
    outputs: tuple[str, ...]
    function: Function | None = None
    open: bool = False


@dataclass(frozen=True, eq=False)
class Effect:
    """One physical or measuring statement that may be absent or present.

    kind: physics, measurement, residual (a force without a name), disturbance (a random process) or
    trial error (constant in a trial, different in each).

    It is absent when its strengths, the first `strengths` parameters, are 0; the others give it its
    form. hooks: stage name -> function whose outputs are added there. states: names of states of
    its own, all starting at 0, with `rates` giving their derivatives. evidence: names of quantities
    that are measured directly -> parameter -> their change per unit of the parameter; or -> a
    function that predicts the quantity from parameters, the means of inputs and time t in a trial,
    and its constants. starts: strengths from which fits begin, where one start may lead astray.
    forms: name of a variant -> values of the shape parameters that give it, where they differ from
    their starts. A search tries each of them. The prior of a shape parameter is so wide that every
    form lies within two standard deviations of the start. needs_both_sides: whether it is a
    difference between turns to port and to starboard, which turns to one side cannot show.
    """

    name: str
    kind: str
    statement: str
    parameters: tuple[Parameter, ...]
    hooks: Mapping[str, Function]
    module: str
    channels: tuple[str, ...] = ()
    variables: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    rates: Function | None = None
    evidence: Mapping[str, Mapping[str, float] | Function] = field(default_factory=dict)
    confused_with: tuple[str, ...] = ()
    regime: str = ""
    strengths: int = 1
    starts: tuple[float, ...] = ()
    forms: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    needs_both_sides: bool = False

    @cached_property
    def parameters_by_auxiliary_measurement(self) -> dict[str, tuple[str, ...]]:
        """Side measurement -> the parameters that its prediction depends on, in its order."""
        names = {p.argument_name: p.name for p in self.parameters}
        return {name: tuple(names[a] for a in inspect.signature(by).parameters if a in names)
                if callable(by) else tuple(by) for name, by in self.evidence.items()}  # fmt: skip

    @cached_property
    def measurements_by_nuisance_parameter(self) -> dict[str, set[str]]:
        """Parameter that acts on no stage -> the side measurements that determine it."""
        functions = [*self.hooks.values(), *([self.rates] if self.rates else [])]
        acting = {name for f in functions for name in inspect.signature(f).parameters}
        silent = {p.name for p in self.parameters if p.argument_name not in acting}
        informed = sorted(
            {p for by in self.parameters_by_auxiliary_measurement.values() for p in by} & silent
        )
        return {
            p: {name for name, by in self.parameters_by_auxiliary_measurement.items() if p in by}
            for p in informed
        }


@dataclass(frozen=True, eq=False)
class System:
    """A model with all the effects that it may be extended by.

    states, constants (per trial), inputs (per trial, over time) and coefficients name the
    arguments that stages may ask for. Stage `rates` must return one derivative a state, stage
    `observe` one value an observation. zero_order_hold: inputs that keep the value of a frame
    until the next one; the others run linearly between frames. step_s: longest integration
    step; None for the default of the caller, times `time_unit_s`.
    """

    name: str
    states: tuple[str, ...]
    constants: tuple[str, ...]
    inputs: tuple[str, ...]
    coefficients: tuple[Parameter, ...]
    stages: tuple[Stage, ...]
    observations: tuple[str, ...]
    effects: tuple[Effect, ...] = ()
    zero_order_hold: tuple[str, ...] = ()
    step_s: float | None = None
    time_unit_s: float = 1.0

    def longest_step_s(self, default_s: float) -> float:
        """Longest integration step: the system's own, or a default for a time unit of 1 s."""
        return self.step_s or default_s * self.time_unit_s

    @cached_property
    def all_states(self) -> tuple[str, ...]:
        """The model's states, then those of the effects."""
        return self.states + tuple(name for effect in self.effects for name in effect.states)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The model's coefficients, then the parameters of the effects as `effect.parameter`."""
        own = tuple(
            replace(p, name=f"{e.name}.{p.name}") for e in self.effects for p in e.parameters
        )
        return self.coefficients + own

    @cached_property
    def parameter_index(self) -> dict[str, int]:
        """Place of every parameter by name."""
        return {p.name: i for i, p in enumerate(self.parameters)}

    def effect_parameter_indices(self, effect: str) -> tuple[int, ...]:
        """Places of an effect's parameters in `parameters`."""
        own = self.effect(effect).parameters
        return tuple(self.parameter_index[f"{effect}.{p.name}"] for p in own)

    @cached_property
    def strength_parameter_indices(self) -> tuple[np.ndarray, np.ndarray]:
        """Places of all effects' strengths one after the other, and where each effect's begin."""
        own = [self.effect_parameter_indices(e.name)[: e.strengths] for e in self.effects]
        first = np.cumsum([0, *(len(slots) for slots in own[:-1])])
        return np.array([s for slots in own for s in slots], dtype=int), first[: len(own)]

    def effect(self, name: str) -> Effect:
        """The effect of that name; KeyError where there is none."""
        return self._effect_by_name[name]

    @cached_property
    def _effect_by_name(self) -> dict[str, Effect]:
        return {effect.name: effect for effect in self.effects}

    def parameter_vector(
        self,
        coefficients: Mapping[str, float],
        effects: Mapping[str, Mapping[str, float]] | None = None,
    ) -> np.ndarray:
        """Parameter vector `(parameters,)`; effects that are not named are absent.

        Raises: KeyError for a name the system does not have.
        """
        given = dict(coefficients)
        for effect, own in (effects or {}).items():
            given |= {f"{effect}.{name}": value for name, value in own.items()}
        unknown = set(given) - {p.name for p in self.parameters}
        if unknown:
            raise KeyError(f"{self.name} has no parameter {', '.join(sorted(unknown))}")
        return np.array(
            [given.get(p.name, self._value_if_effect_absent(p)) for p in self.parameters]
        )

    def unpack_parameter_vector(
        self, values: np.ndarray
    ) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
        """Coefficients, and the effects that are present with their parameters: what `values`
        takes.
        """
        given = dict(zip((p.name for p in self.parameters), values.tolist(), strict=True))
        coefficients = {p.name: given[p.name] for p in self.coefficients}
        effects = {
            e.name: {p.name: given[f"{e.name}.{p.name}"] for p in e.parameters}
            for e in self.effects
            if any(given[f"{e.name}.{p.name}"] != 0 for p in e.parameters[: e.strengths])
        }
        return coefficients, effects

    def _value_if_effect_absent(self, parameter: Parameter) -> float:
        if "." not in parameter.name:
            return parameter.start
        effect, name = parameter.name.split(".", 1)
        found = self.effect(effect)
        strengths = [p.name for p in found.parameters[: found.strengths]]
        return 0.0 if name in strengths else parameter.start


def effect_from_module(module: ModuleType, stages: tuple[Stage, ...]) -> Effect:
    """The effect that a module describes: its constants in capitals, its functions by stage name.

    Raises: TypeError naming the module and what it lacks.
    """
    name = module.__name__.rsplit(".", 1)[-1]
    hooks = {
        stage.name: getattr(module, stage.name)
        for stage in stages
        if stage.open and inspect.isfunction(getattr(module, stage.name, None))
    }
    missing = [
        key
        for key in ("EFFECT_DESCRIPTION", "EFFECT_PARAMETERS", "EFFECT_KIND")
        if not hasattr(module, key)
    ]
    if missing or not hooks:
        raise TypeError(f"effect '{name}' lacks {', '.join(missing) or 'a function for a stage'}")
    return Effect(
        name=name,
        kind=module.EFFECT_KIND,
        statement=module.EFFECT_DESCRIPTION,
        parameters=tuple(module.EFFECT_PARAMETERS),
        hooks=hooks,
        module=module.__name__,
        channels=tuple(getattr(module, "AFFECTED_CHANNELS", ())),
        variables=tuple(getattr(module, "DEPENDS_ON_VARIABLES", ())),
        states=tuple(getattr(module, "EFFECT_STATE_NAMES", ())),
        rates=getattr(module, "effect_state_derivatives", None),
        evidence=dict(getattr(module, "SIDE_MEASUREMENT_PREDICTIONS", {})),
        confused_with=tuple(getattr(module, "CONFUSED_WITH", ())),
        regime=getattr(module, "MOST_VISIBLE_WHERE", ""),
        strengths=getattr(module, "STRENGTH_PARAMETER_COUNT", 1),
        starts=tuple(getattr(module, "STRENGTH_START_VALUES", ())),
        forms=dict(getattr(module, "FUNCTIONAL_FORMS", {})),
        needs_both_sides=getattr(module, "NEEDS_TURNS_TO_BOTH_SIDES", False),
    )
