"""Dependences between the stages of a system, and which of them are constant in time."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Sequence

from .inlining import InlinedCode, inlined_expressions
from .system import Effect, Function, Stage, System

STOCHASTIC_EFFECT_KIND = "disturbance"
"""Kind of effects that are present in every filter."""


def argument_names(function: Function) -> list[str]:
    """Names of a function's arguments, in order."""
    return list(inspect.signature(function).parameters)


def stage_arguments(stage: Stage, effects: Iterable[Effect]) -> set[str]:
    """What a stage and these effects on it ask for; effects' own parameters left out."""
    asked = set(argument_names(stage.function)) if stage.function else set()
    for effect in effects:
        if stage.name in effect.hooks:
            own = {p.argument_name for p in effect.parameters}
            asked |= set(argument_names(effect.hooks[stage.name])) - own
    return asked


def required_stages(system: System, last: Stage, effects: Sequence[Effect]) -> list[Stage]:
    """Stages whose outputs the last one and these effects on it need, directly or through others,
    in order.
    """
    asked = stage_arguments(last, effects)
    found: list[Stage] = []
    for stage in reversed(_intermediate_stages(system)):
        if asked & set(stage.outputs):
            found.insert(0, stage)
            asked |= stage_arguments(stage, system.effects)
    return found


def _intermediate_stages(system: System) -> list[Stage]:
    return [s for s in system.stages if s.name not in ("rates", "observe")]


def constant_stages(system: System) -> list[Stage]:
    """Stages that follow from parameters, constants and inputs alone while no effect is on."""
    known = {*(p.name for p in system.coefficients), *system.constants, *system.inputs}
    found: list[Stage] = []
    for stage in _intermediate_stages(system):
        random = any(
            e.kind == STOCHASTIC_EFFECT_KIND and stage.name in e.hooks for e in system.effects
        )
        if not random and stage_arguments(stage, ()) <= known:
            found.append(stage)
            known |= set(stage.outputs)
    return found


def state_dependent_stages(system: System) -> list[Stage]:
    """Stages that depend on the state, in order, `rates` last."""
    constant = constant_stages(system)
    return [s for s in system.stages if s.name != "observe" and s not in constant]


def aliased_or_constant_outputs(system: System) -> dict[str, str]:
    """Outputs of constant stages that are, while no effect is on, a number or another named value.

    name -> that name or number: a head angle as commanded, water that is at rest.
    """
    found: dict[str, str] = {}
    for stage in constant_stages(system):
        given = argument_names(stage.function) if stage.function else []
        count = len(stage.outputs)
        values = ["0.0"] * count
        if stage.function:
            values = inlined_expressions(stage.function, given, InlinedCode(), count)
        for output, value in zip(stage.outputs, values, strict=True):
            if value in given or _is_number(value):
                found[output] = found.get(value, value)
    return found


def _is_number(value: str) -> bool:
    try:
        float(value)
    except ValueError:
        return False
    return True
