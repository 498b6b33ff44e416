"""Parameter types for numbers on the command line: finite, within a range, single or a list."""

from __future__ import annotations

import math
from typing import Any

import click


class FiniteNumber(click.FloatRange):
    """A number within a range; neither `nan`, which passes every comparison, nor `inf`."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The number; a usage error where it is not finite or out of range."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number", param, ctx)
        return number


class NumberList(click.ParamType):
    """Numbers `50,75,100`, or a row of them `10:60:5` (from, to, step), each from low to high."""

    name = "numbers"
    most = 1000

    def __init__(self, low: float = -math.inf, high: float = math.inf) -> None:
        self.low, self.high = low, high

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """The numbers, each once; a usage error where one cannot be read or is out of range."""
        text = str(value)
        try:
            found = self._parse(text)
        except (ValueError, ArithmeticError):
            self.fail(f"'{text}': write 50,75,100 or 10:60:5 (from, to, step)", param, ctx)
        bad = [n for n in found if not (math.isfinite(n) and self.low <= n <= self.high)]
        if bad:
            self.fail(f"{bad[0]:g}: each must be a number from {self.low:g} to {self.high:g}",
                      param, ctx)  # fmt: skip
        return tuple(dict.fromkeys(found))

    def _parse(self, text: str) -> tuple[float, ...]:
        if ":" not in text:
            return tuple(float(part) for part in text.split(","))
        first, last, step = (float(part) for part in text.split(":"))
        count = int((last - first) / step + 1 + 1e-9)
        if not 1 <= count <= self.most:
            raise ValueError
        return tuple(round(first + k * step, 9) for k in range(count))
