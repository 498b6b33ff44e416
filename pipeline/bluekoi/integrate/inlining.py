"""Bodies of plain functions written out where they are called.

A compiler of Python spends most of its time on functions, not on their arithmetic: a kernel made
of a hundred small functions takes several times as long to compile as the same arithmetic in a
few. So what stands in straight lines (assignments, then one return) is copied into the kernel with
its arguments put in; products with a literal 0 and sums with it are left out, so that what is
absent (water at rest) costs nothing. Everything else stays a call.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Function = Callable[..., Any]

NUMBA_BUILTIN_FUNCTIONS: dict[Any, tuple[str, ...]] = {
    builtins: ("abs", "min", "max"),
    math: ("sqrt", "exp", "log", "sin", "cos", "tanh", "atan2", "hypot"),
    np: ("floor",),
}
"""Functions that the compiler of the kernel has, by the module they are called of."""


@dataclass
class InlinedCode:
    """Lines written so far, and functions by name that they call."""

    written: list[str] = field(default_factory=list)
    called: dict[str, Function] = field(default_factory=dict)
    names: int = 0

    def assign_to_temporary(self, value: ast.expr, name: str) -> ast.expr:
        """The value itself where it is a name or a number, else a new name for it."""
        if isinstance(value, ast.Name | ast.Constant):
            return value
        self.names += 1
        fresh = ast.Name(f"{name}_{self.names}")
        self.written.append(f"{fresh.id} = {ast.unparse(value)}")
        return fresh


class NotInlinable(Exception):
    """A function does not stand in straight lines."""


def inlined_expressions(
    function: Function, given: Sequence[str], lines: InlinedCode, count: int | None = None
) -> list[str]:
    """Expressions of what a function returns for these arguments; its lines go to `lines`.

    given: expressions in the order of the function's arguments. count: length of the tuple that
    it returns, by its annotation where not given.
    """
    arguments = [ast.parse(text, mode="eval").body for text in given]
    return [ast.unparse(value) for value in _inline_or_call(function, arguments, lines, count)]


def _inline_or_call(
    function: Function, given: Sequence[ast.expr], lines: InlinedCode, count: int | None = None
) -> list[ast.expr]:
    """Written out where that is possible, else called."""
    draft = InlinedCode(names=lines.names)
    try:
        values = _inline_statements(function, given, draft)
    except NotInlinable:
        return _write_call(function, given, lines, count or output_count(function))
    lines.written += draft.written
    lines.called |= draft.called
    lines.names = draft.names
    return values


def _write_call(
    function: Function, given: Sequence[ast.expr], lines: InlinedCode, count: int | None
) -> list[ast.expr]:
    """A call of a function under a name of its own, its outputs held."""
    name = "_".join(["called", *function.__module__.split("."), function.__name__])
    lines.called[name] = function
    call = f"{name}({', '.join(ast.unparse(a) for a in given)})"
    if count is None:
        return [lines.assign_to_temporary(ast.parse(call, mode="eval").body, "out")]
    lines.names += 1
    names = [f"out{i}_{lines.names}" for i in range(count)]
    lines.written.append(f"{', '.join(names)}{',' if count == 1 else ''} = {call}")
    return [ast.Name(name) for name in names]


def output_count(function: Function) -> int | None:
    """Length of the tuple that a function says it returns; None for a single value."""
    said = inspect.signature(function, eval_str=True).return_annotation
    parts = getattr(said, "__args__", None)
    return len(parts) if parts else None


def _inline_statements(
    function: Function, given: Sequence[ast.expr], lines: InlinedCode
) -> list[ast.expr]:
    function = getattr(function, "py_func", function)
    names, statements = _arguments_and_statements(function)
    known: dict[str, ast.expr] = dict(zip(names, given, strict=True))
    for statement in statements[:-1]:
        known |= _assigned_values(statement, _InliningTransformer(known, function, lines))
    last = statements[-1]
    if not isinstance(last, ast.Return) or last.value is None:
        raise NotInlinable
    return _InliningTransformer(known, function, lines).inlined_value_expressions(last.value)


def _arguments_and_statements(function: Function) -> tuple[list[str], list[ast.stmt]]:
    """Argument names and statements without the docstring."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, TypeError, SyntaxError) as error:
        raise NotInlinable from error
    if not isinstance(tree, ast.FunctionDef) or function.__closure__:
        raise NotInlinable
    statements = tree.body[1:] if ast.get_docstring(tree) is not None else tree.body
    if not statements:
        raise NotInlinable
    return [a.arg for a in tree.args.args], statements


def _assigned_values(statement: ast.stmt, writer: _InliningTransformer) -> dict[str, ast.expr]:
    """Names of one assignment, with what they stand for."""
    if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
        raise NotInlinable
    target = statement.targets[0]
    targets = list(target.elts) if isinstance(target, ast.Tuple) else [target]
    names = [t.id for t in targets if isinstance(t, ast.Name)]
    values = writer.inlined_value_expressions(statement.value)
    if len(names) != len(targets) or len(values) != len(names):
        raise NotInlinable
    return {n: writer.lines.assign_to_temporary(v, n) for n, v in zip(names, values, strict=True)}


class _InliningTransformer(ast.NodeTransformer):
    """Puts known values in, writes calls out, leaves out what is 0."""

    def __init__(
        self, known: Mapping[str, ast.expr], function: Function, lines: InlinedCode
    ) -> None:
        self.known, self.lines = known, lines
        self.scope: Mapping[str, Any] = vars(builtins) | function.__globals__

    def inlined_value_expressions(self, value: ast.expr) -> list[ast.expr]:
        """Expressions of a tuple, of a call of several outputs, or of one value."""
        if isinstance(value, ast.Tuple):
            return [self.visit(part) for part in value.elts]
        if isinstance(value, ast.Call):
            return self._inlined_call_outputs(value)
        return [self.visit(value)]

    def _inlined_call_outputs(self, call: ast.Call) -> list[ast.expr]:
        if call.keywords:
            raise NotInlinable
        function = self._resolved_in_module(call.func)
        arguments = [self.visit(a) for a in call.args]
        for module, names in NUMBA_BUILTIN_FUNCTIONS.items():
            for name in names:
                if function is getattr(module, name):
                    return [ast.Call(_compiled_function_name(module, name), arguments, [])]
        return _inline_or_call(
            function, [self.lines.assign_to_temporary(a, "given") for a in arguments], self.lines
        )

    def _resolved_in_module(self, node: ast.expr) -> Any:
        """What a name, or an attribute of a module, stands for in the function's own module."""
        if isinstance(node, ast.Name) and node.id in self.scope:
            return self.scope[node.id]
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            return getattr(self.scope.get(node.value.id), node.attr, None)
        raise NotInlinable

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """One value of a call."""
        values = self._inlined_call_outputs(node)
        if len(values) != 1:
            raise NotInlinable
        return values[0]

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """A known value, or a number of the function's module."""
        return (
            self.known[node.id]
            if node.id in self.known
            else _number_constant(self._resolved_in_module(node))
        )

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """A number of another module, such as math.pi."""
        return _number_constant(self._resolved_in_module(node))

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        """Minus nothing is nothing."""
        inner = self.visit(node.operand)
        return inner if _is_zero(inner) else ast.UnaryOp(node.op, inner)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """A sum without what is 0, a product that is 0 where a factor is."""
        left, right = self.visit(node.left), self.visit(node.right)
        if isinstance(node.op, ast.Mult) and (_is_zero(left) or _is_zero(right)):
            return ast.Constant(0.0)
        if isinstance(node.op, ast.Add | ast.Sub) and _is_zero(right):
            return left
        if isinstance(node.op, ast.Add) and _is_zero(left):
            return right
        if (
            isinstance(node.op, ast.Sub)
            and isinstance(left, ast.Name)
            and _are_same_expression(left, right)
        ):
            return ast.Constant(0.0)
        return ast.BinOp(left, node.op, right)

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        """Numbers stay."""
        return _number_constant(node.value)

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """Comparisons, choices and the like: the function has to be called."""
        raise NotInlinable(type(node).__name__)


def _compiled_function_name(module: Any, name: str) -> ast.expr:
    if module is builtins:
        return ast.Name(name)
    return ast.Attribute(ast.Name("np" if module is np else module.__name__), name)


def _number_constant(value: Any) -> ast.expr:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise NotInlinable
    return ast.Constant(value)


def _are_same_expression(left: ast.Name, right: ast.expr) -> bool:
    return isinstance(right, ast.Name) and right.id == left.id


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == 0
