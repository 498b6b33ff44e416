"""What a law is: a named physical statement with one size and hooks into the engine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.random import Generator


@dataclass
class Law:
    """One hidden cause.

    `size` (in `unit`) is the single number that is scaled until the effect is visible, `largest`
    its plausible limit; zero means no effect. Hooks, all called as hook(here, size) with `here` an
    `engine.Here`: `flap` and `thrust` return factors, `phi` the new head angle (rad), `water` a
    complex velocity in pool axes (m/s), `coefficients` changes C_L, C_D and C_M in place, `force`
    returns a complex force in core axes (N) and a moment (N m), `added` sets added masses, `shift`
    returns the displacement of the centre of mass (complex, pool axes, m), `states` the rates of
    the law's own `n_states` states. Two are called otherwise: `depth` with time and size, the depth
    gained (m), and `view` with a View and the size; it changes what the camera sees or what
    study.yaml says.
    """

    name: str
    form: str
    key: str
    unit: str
    size: float
    largest: float
    kind: str = "physics"
    hooks: dict[str, Callable[..., Any]] = field(default_factory=dict)
    extra: dict[str, tuple[Any, str]] = field(default_factory=dict)
    n_states: int = 0
    channels: tuple[str, ...] = ()
    variable: str = ""
    sign: float = 1.0
    show: Callable[[float], float] = float

    @property
    def seen(self) -> bool:
        """Whether the law changes what the camera sees beside the motion."""
        return "view" in self.hooks or "depth" in self.hooks

    def truth(self, sigma: float) -> dict[str, Any]:
        """The entry of the truth file."""
        parameters = {self.key: {"value": self.show(self.sign * self.size), "unit": self.unit}}
        for key, (value, unit) in self.extra.items():
            is_numpy = isinstance(value, np.ndarray | np.generic)
            parameters[key] = {"value": value.tolist() if is_numpy else value, "unit": unit}
        return {
            "name": self.name,
            "kind": self.kind,
            "form": self.form,
            "parameters": parameters,
            "sigma": round(float(sigma), 3),
        }


def pick(rng: Generator, *forms: str) -> str:
    """One of the forms."""
    return str(rng.choice(forms))
