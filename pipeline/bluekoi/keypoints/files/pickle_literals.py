"""Lists of names out of a pickle, read as text: nothing is ever unpickled.

Pandas stores column names of its h5 tables as a pickle of lists, tuples and strings.
`pickletools.genops` only splits a pickle into its steps; the few that build such literals are
followed here by hand, any other (a class, a call) is refused.
"""

from __future__ import annotations

import pickletools
from typing import Any

STACK_MARK = object()
MAX_OPCODES = 2_000_000
VALUE_OPCODES = {
    "UNICODE", "BINUNICODE", "SHORT_BINUNICODE", "BINUNICODE8", "STRING", "BINSTRING",
    "SHORT_BINSTRING", "INT", "BININT", "BININT1", "BININT2", "LONG", "LONG1", "FLOAT", "BINFLOAT",
}  # fmt: skip
SINGLETON_OPCODES: dict[str, Any] = {"NONE": None, "NEWTRUE": True, "NEWFALSE": False}
EMPTY_CONTAINER_OPCODES: dict[str, type] = {
    "EMPTY_LIST": list,
    "EMPTY_TUPLE": tuple,
    "EMPTY_DICT": dict,
}


class NotLiteral(ValueError):
    """The pickle holds something other than lists, tuples, dicts, strings and numbers."""


def parse_literal(pickled: bytes) -> Any:
    """The list, tuple, dict, string or number that a pickle spells out.

    Raises: NotLiteral where it would make anything else, or is damaged.
    """
    stack: list[Any] = []
    memo: dict[int, Any] = {}
    try:
        for count, (step, argument, _) in enumerate(pickletools.genops(pickled)):
            if count > MAX_OPCODES:
                raise NotLiteral("too long")
            if step.name == "STOP":
                return _refuse_mark(stack.pop())
            _execute_opcode(step.name, argument, stack, memo)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        raise NotLiteral(str(error)) from error
    raise NotLiteral("no end")


def _execute_opcode(name: str, argument: Any, stack: list[Any], memo: dict[int, Any]) -> None:
    if name in VALUE_OPCODES:
        stack.append(argument)
    elif name in SINGLETON_OPCODES:
        stack.append(SINGLETON_OPCODES[name])
    elif name in EMPTY_CONTAINER_OPCODES:
        stack.append(EMPTY_CONTAINER_OPCODES[name]())
    elif name in ("PROTO", "FRAME"):
        return
    elif name == "MARK":
        stack.append(STACK_MARK)
    elif name in ("PUT", "BINPUT", "LONG_BINPUT", "MEMOIZE"):
        memo[len(memo) if name == "MEMOIZE" else int(argument)] = _refuse_mark(stack[-1])
    elif name in ("GET", "BINGET", "LONG_BINGET"):
        stack.append(memo[int(argument)])
    else:
        _execute_collecting_opcode(name, stack)


def _refuse_mark(item: Any) -> Any:
    """A thing that a literal may hold: no mark."""
    if item is STACK_MARK:
        raise NotLiteral("a mark where a value is expected")
    return item


def _execute_collecting_opcode(name: str, stack: list[Any]) -> None:
    """Steps that take things off the stack and put one thing back."""
    if name in ("TUPLE1", "TUPLE2", "TUPLE3"):
        count = int(name[-1])
        stack[-count:] = [tuple(map(_refuse_mark, stack[-count:]))]
    elif name == "APPEND":
        stack[-2].append(_refuse_mark(stack.pop()))
    elif name == "SETITEM":
        value, key = _refuse_mark(stack.pop()), _refuse_mark(stack.pop())
        stack[-1][key] = value
    elif name in ("TUPLE", "LIST", "DICT", "APPENDS", "SETITEMS"):
        _collect_from_mark(name, stack)
    else:
        raise NotLiteral(f"step {name}")


def _collect_from_mark(name: str, stack: list[Any]) -> None:
    marks = [i for i, item in enumerate(stack) if item is STACK_MARK]
    if not marks:
        raise NotLiteral(f"step {name} without a mark")
    at = marks[-1]
    items = stack[at + 1 :]
    del stack[at:]
    if name == "TUPLE":
        stack.append(tuple(items))
    elif name == "LIST":
        stack.append(items)
    elif name == "APPENDS":
        stack[-1].extend(items)
    else:
        pairs = dict(zip(items[::2], items[1::2], strict=True))
        if name == "DICT":
            stack.append(pairs)
        else:
            stack[-1].update(pairs)
