"""A mass on a line, pushed at random, seen with errors that last: its answers are known."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

from bluekoi.integrate import Parameter, Stage, System

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
randomness = import_module("examples.randomness")


def push() -> tuple[float]:
    """No force of its own."""
    return (0.0,)


def rates(v: float, F: float, c: float) -> tuple[float, float]:
    """Derivatives of place and speed of a unit mass with linear drag c."""
    return v, F - c * v


def observe(x: float) -> tuple[float]:
    """The place is seen."""
    return (x,)


SYSTEM = System(
    "one_mass", ("x", "v"), (), ("u",), (Parameter("c", "1/s", 0.5, 0.0, 5.0, "drag"),),
    (Stage("force", ("F",), push, open=True), Stage("rates", ("x", "v"), rates),
     Stage("observe", ("seen",), observe, open=True)),
    ("seen",),
    (randomness.pushes("The water is never still.", "force", ("surge",), (0.3, 0.01, 10.0)),
     randomness.lasting_errors("Errors of the place last.", 1, (0.3, 0.01, 10.0))),
)  # fmt: skip
