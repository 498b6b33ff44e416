"""Coefficients and parameters that are arguments of an equation, but that none computes with.

The trials say nothing on such a number: what is reported of it is its prior.
"""

from __future__ import annotations

import dis
from collections.abc import Iterator, Sequence

from ..errors import InputIssue
from .model import Function, Model, names_of_arguments


def check_unused_numbers(model: Model) -> list[InputIssue]:
    """A finding for each coefficient or parameter of a cause that no equation computes with."""
    stages = [s.function for s in model.stages if s.function is not None]
    own = {c.name: [*c.hooks.values(), *([c.rates] if c.rates is not None else [])]
           for c in model.causes}  # fmt: skip
    every = [*stages, *(f for functions in own.values() for f in functions)]
    named = [(f"coefficient {p.name}", p.name, every) for p in model.coefficients]
    named += [(f"cause {c.name}: {p.name}", p.argument_name, own[c.name])
              for c in model.causes for p in c.parameters]  # fmt: skip
    return [
        InputIssue(f"model '{model.name}'", where, "a number that no equation computes with",
                   f"an equation in which {argument} occurs", "Use it there, or leave it out.")
        for where, argument, functions in named if not _is_used(argument, functions)
    ]  # fmt: skip


def _is_used(argument: str, functions: Sequence[Function]) -> bool:
    return any(
        argument in names_of_arguments(f) and argument in set(_local_names_read_by_function(f))
        for f in functions
    )


def _local_names_read_by_function(function: Function) -> Iterator[str]:
    """Local names that a function reads; all its arguments where it has no bytecode."""
    code = getattr(function, "__code__", None)
    if code is None:
        yield from names_of_arguments(function)
        return
    for instruction in dis.get_instructions(code):
        if instruction.opname.startswith("LOAD_"):  # two names in one from Python 3.13 on
            read = instruction.argval
            yield from (name for name in (read if isinstance(read, tuple) else (read,))
                        if isinstance(name, str))  # fmt: skip
