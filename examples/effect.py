"""Short form of an effect: a name, a statement, functions by stage, parameters as rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bluekoi.integrate import Effect, Parameter
from bluekoi.integrate.system import Function

Row = tuple[str, str, float, float, float, str]


def effect(
    name: str,
    statement: str,
    hooks: Mapping[str, Function],
    parameters: tuple[Row, ...],
    **more: Any,
) -> Effect:
    """An `Effect`; a row of `parameters` is name, unit, start, lower, upper, meaning.

    more: other fields of `Effect`; kind is `physics` where it is not given.
    """
    first = next(iter(hooks.values()))
    return Effect(
        name=name,
        statement=statement,
        hooks=hooks,
        parameters=tuple(Parameter(*row) for row in parameters),
        module=first.__module__,
        **({"kind": "physics"} | more),
    )
