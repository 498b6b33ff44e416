"""A functional form of a cause, and a form with its numbers drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

STAGES = (
    "servo", "motor", "water", "mass", "balance", "head", "thrust", "force",
    "depth", "stated", "picture", "exposure", "label",
)  # fmt: skip
"""Where a form acts. The first eight change the motion, the others what is seen of it."""
OPTICAL_STAGES = STAGES[8:]


@dataclass(frozen=True)
class Form:
    """One functional form of a cause. `law(s, k, p)`: s the moment, k strength, p parameters."""

    cause: str
    name: str
    stage: str
    law: Callable[..., Any]
    unit: str
    low: float
    high: float
    """Range of the strength."""
    channels: tuple[str, ...] = ()
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Parameters that are drawn: low and high."""
    memory: Callable[..., Any] | None = None
    """Rate of change of the form's own states, (rows, n)."""
    rows: int = 0
    variable: str = ""
    """Of an unlisted force: the variable on which it depends."""


@dataclass(frozen=True)
class HiddenForm:
    """A form with its numbers."""

    form: Form
    strength: float
    parameters: dict[str, float]

    def __call__(self, s, k=None):
        """The form's value at the moment `s`, with strength(s) `k`."""
        return self.form.law(s, self.strength if k is None else k, self.parameters)


def draw_hidden(rng: np.random.Generator, form: Form) -> HiddenForm:
    """The form with parameters drawn evenly, strength within e^0.9 of its range's middle."""
    parameters = {name: float(rng.uniform(*ends)) for name, ends in form.ranges.items()}
    strength = np.sqrt(form.low * form.high) * np.exp(rng.uniform(-0.9, 0.9))
    return HiddenForm(form, float(np.clip(strength, form.low, form.high)), parameters)


def forms(cause, stage, unit, channels, rows):
    """A form for each row (name, law, low, high[, ranges[, memory, states]])."""
    out = []
    for name, law, low, high, *more in rows:
        ranges, memory, states = (*more, *({}, None, 0)[len(more) :])
        out.append(Form(cause, name, stage, law, unit, low, high, channels, ranges, memory, states))
    return out
