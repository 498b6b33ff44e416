"""What can be hidden: functional forms, and laws drawn from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Law = Callable[..., Any]


@dataclass(frozen=True)
class Form:
    """One functional form of a cause.

    stage: what the law changes. force: law(c, s, p) -> force (N, complex, world), moment (N m);
    memory: the same and the rates of two states; thrust: a factor; drive: a factor of the flapping
    frequency; servo: head angle (rad) and its rate; water: velocity (m/s, complex); inertia: added
    masses; mass: distance by which the centre of mass lies behind its label, m; sink: m; picture:
    a fault of measurement. low, high: bounds of the strength s. ranges: bounds of the parameters p.
    variable: what an unlisted force depends on.
    """

    cause: str
    name: str
    stage: str
    law: Law
    unit: str
    low: float
    high: float
    channels: tuple[str, ...] = ("surge",)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    variable: str = ""
    signed: bool = False


@dataclass(frozen=True)
class HiddenLaw:
    """A form with its strength (positive, times sign) and parameters."""

    form: Form
    strength: float
    shape: Mapping[str, float]
    sign: float = 1.0


def draw_law(rng: np.random.Generator, form: Form, pool: tuple[float, float, float]) -> HiddenLaw:
    """A law of this form; the strength is a first guess. pool: length, width, depth, m."""
    shape = {k: float(rng.uniform(*v)) for k, v in form.ranges.items()}
    if form.stage == "water" or form.cause in ("wall_effect", "unexplained"):
        shape |= {"pool_length_m": pool[0], "pool_width_m": pool[1]}
    sign = float(rng.choice([-1, 1])) if form.signed else 1.0
    return HiddenLaw(form, float(form.low * (form.high / form.low) ** 0.4), shape, sign)


def form_maker(cause: str, stage: str, unit: str, channels: tuple[str, ...] = ("surge",),
           **settings: Any) -> Callable[..., Form]:  # fmt: skip
    """Maker of forms of one cause: make(name, law, low, high, **ranges)."""

    def make(name: str, law: Law, low: float, high: float, **ranges: tuple[float, float]) -> Form:
        return Form(cause, name, stage, law, unit, low, high, channels, ranges, **settings)

    return make
