"""Register of hidden laws.

A form is one functional law of a named cause.  It belongs to a stage: `water` (velocity of the
water), `command` (head angle and flapping frequency), `force`, `label`, `depth`, `clock`, `optics`.
Its parameter `amp` carries the magnitude; the other parameters shape it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

MEASUREMENT = (
    "scale_error",
    "clock_error",
    "camera_shift",
    "uncorrected_refraction",
    "lens_error",
    "time_offset",
    "keypoint_bias",
)


@dataclass(frozen=True)
class Form:
    """One functional form: stage, starting magnitude, greatest magnitude, ranges of the shape."""

    name: str
    label: str
    stage: str
    start: float
    cap: float
    ranges: dict[str, Any]
    func: Callable[[Any, dict[str, float]], None]
    text: str

    def draw(self, rng: np.random.Generator) -> Law:
        """A law of this form with shape parameters drawn and the starting magnitude."""
        values: dict[str, float] = {"amp": self.start}
        for key, span in self.ranges.items():
            if isinstance(span, list):
                values[key] = float(span[int(rng.integers(len(span)))])
            else:
                values[key] = float(rng.uniform(*span))
        return Law(self, values)


@dataclass(frozen=True)
class Law:
    """A form with its parameters."""

    form: Form
    params: dict[str, float]

    @property
    def name(self) -> str:
        """Name of the cause."""
        return self.form.name

    @property
    def stage(self) -> str:
        """Stage at which the law acts."""
        return self.form.stage

    @property
    def kind(self) -> str:
        """`physics` or `measurement`."""
        return "measurement" if self.name in MEASUREMENT else "physics"

    def with_amp(self, amp: float) -> Law:
        """The same law with another magnitude."""
        return replace(self, params={**self.params, "amp": float(amp)})

    def apply(self, work: Any) -> None:
        """Let the law act on a working state."""
        self.form.func(work, self.params)


FORMS: dict[str, list[Form]] = {}
UNLISTED: list[Form] = []
UNLISTED_FACTS: dict[str, tuple[list[str], str]] = {}


def form(
    name: str, label: str, stage: str, start: float, cap: float, **ranges: Any
) -> Callable[[Callable[[Any, dict[str, float]], None]], Callable]:
    """Decorator that enters a function as a form of a named cause."""

    def enter(func: Callable[[Any, dict[str, float]], None]) -> Callable:
        text = " ".join((func.__doc__ or "").split())
        FORMS.setdefault(name, []).append(Form(name, label, stage, start, cap, ranges, func, text))
        return func

    return enter


def unlisted(
    label: str,
    channels: list[str],
    variable: str,
    stage: str,
    *,
    start: float,
    cap: float,
    **ranges: Any,
) -> Callable:
    """Decorator that enters a function as a force which no listed cause describes."""

    def enter(func: Callable[[Any, dict[str, float]], None]) -> Callable:
        text = " ".join((func.__doc__ or "").split())
        UNLISTED.append(Form("unlisted", label, stage, start, cap, ranges, func, text))
        UNLISTED_FACTS[label] = (channels, variable)
        return func

    return enter


def smooth_sign(value: Any, width: Any) -> Any:
    """A sign that changes smoothly over a width."""
    return np.tanh(value / width)
