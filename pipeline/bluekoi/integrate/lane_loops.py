"""Loops over sixteen lanes, written from plain functions: rows in, arithmetic, rows out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .inlining import InlinedCode, inlined_expressions
from .row_layout import LANES, RowNumbers
from .stage_dependencies import argument_names
from .system import Effect, Function, Stage


class LaneLoopWriter:
    """Source of a loop over lanes: each row is loaded once, values pass by name, rows are set last.

    passed_on: names that stand for other names or for numbers.
    """

    def __init__(self, rows: RowNumbers, passed_on: Mapping[str, str] | None = None) -> None:
        self._rows, self._lines = rows, InlinedCode()
        self._passed_on = dict(passed_on or {})
        self._local: dict[str, str] = {}
        self._loads: dict[int, str] = {}
        self._stores: list[str] = []

    @property
    def not_inlined_functions(self) -> dict[str, Function]:
        """Functions by name that could not be written out."""
        return self._lines.called

    def source_lines(self, indent: str = "    ") -> list[str]:
        """Lines of the loop."""
        loads = [f"{name} = m[{row * LANES} + j]" for row, name in self._loads.items()]
        body = [*loads, *self._lines.written, *self._stores]
        return [f"{indent}for j in range({LANES}):", *(f"{indent}    {line}" for line in body)]

    def load_row(self, row: int) -> str:
        """Name of a row's value."""
        return self._loads.setdefault(row, f"row{row}")

    def store_row(self, row: int, value: str, assign: str = "=") -> None:
        """Set a row, or add to it, after everything has been loaded."""
        self._stores.append(f"m[{row * LANES} + j] {assign} {value}")

    def output_expressions(self, function: Function, count: int, effect: str = "") -> list[str]:
        """Expressions of a function's outputs; an effect's own names come before others."""
        given = [self.expression_of(n, effect, function) for n in argument_names(function)]
        return inlined_expressions(function, given, self._lines, count)

    def expression_of(self, name: str, effect: str = "", where: Function | None = None) -> str:
        """Expression for a named value.

        Raises: TypeError naming the function that asks for what nobody gives.
        """
        own = self._rows.own.get((effect, name))
        if own is None and name in self._local:
            return self._local[name]
        if own is None and name in self._passed_on:
            name = self._passed_on[name]
            if name not in self._rows.named:
                return name
        row = own if own is not None else self._rows.named.get(name)
        if row is None:
            place = f"{where.__module__}.{where.__name__}" if where else effect
            raise TypeError(f"{place}: no value '{name}'")
        return self.load_row(row)

    def bind_name(self, name: str, value: str) -> None:
        """Let a name stand for a value from here on."""
        if not value.isidentifier() and value != "0.0":
            self._lines.written.append(f"v_{name} = {value}")
            value = f"v_{name}"
        self._local[name] = value

    def add_stage(self, stage: Stage, results: Sequence[str], effects: Sequence[Effect]) -> None:
        """A stage's outputs under the names `results`, what effects add included."""
        count = len(stage.outputs)
        values = (
            self.output_expressions(stage.function, count) if stage.function else ["0.0"] * count
        )
        for effect in effects:
            if stage.name in effect.hooks:
                added = self.output_expressions(effect.hooks[stage.name], count, effect.name)
                values = [_sum_expression(v, a) for v, a in zip(values, added, strict=True)]
        for name, value in zip(results, values, strict=True):
            self.bind_name(name, value)


def _sum_expression(a: str, b: str) -> str:
    if "0.0" in (a, b):
        return b if a == "0.0" else a
    return f"{a} + ({b})"
