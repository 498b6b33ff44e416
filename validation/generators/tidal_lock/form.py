"""What a functional form of a cause consists of."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

Extras = dict[str, tuple[float, float, str]]


@dataclass(frozen=True)
class Form:
    """One functional form of one cause.

    `law` acts at `stage` of the equations of motion or of the observation. `full` gives the
    largest plausible magnitude of the parameter `symbol` for a robot; `extras` lists further
    parameters as (low, high, unit). A form with memory has `states` states that follow `rates`.
    """

    cause: str
    form: str
    stage: str
    law: Callable[..., Any]
    symbol: str
    unit: str
    full: Callable[[Any], float]
    extras: Extras = field(default_factory=dict)
    kind: str = "physics"
    signed: bool = False
    states: int = 0
    rates: Callable[..., np.ndarray] | None = None
    channels: tuple[str, ...] = ()
    variable: str = ""


@dataclass(frozen=True)
class Active:
    """A form with its parameters; `p.amp` is a scalar or one value a row."""

    form: Form
    p: SimpleNamespace

    def scaled(self, magnitude: np.ndarray | float) -> "Active":
        """The same form with the magnitude replaced, sign kept."""
        values = dict(vars(self.p))
        values["amp"] = self.p.sign * np.asarray(magnitude, float)
        return Active(self.form, SimpleNamespace(**values))

    def parameters(self) -> dict[str, dict[str, float | str]]:
        """Parameters for the record: {name: {value, unit}}."""
        table = {self.form.symbol: {"value": float(self.p.amp), "unit": self.form.unit}}
        for name, (_, _, unit) in self.form.extras.items():
            table[name] = {"value": float(getattr(self.p, name)), "unit": unit}
        return table


def family(
    cause: str,
    stage: str,
    magnitude: tuple[str, str, Callable[[Any], float]],
    laws: dict[str, Any],
    **common: Any,
) -> list[Form]:
    """All forms of a cause; a law is given alone, or as (law, extras), or as (law, extras, more).

    `magnitude` is (symbol, unit, full).
    """
    forms = []
    for name, entry in laws.items():
        law, extras, more = (*entry, {}, {})[:3] if isinstance(entry, tuple) else (entry, {}, {})
        settings = {"stage": stage, "extras": extras, **common, **more}
        symbol, unit, full = settings.pop("magnitude", magnitude)
        forms.append(
            Form(cause=cause, form=name, law=law, symbol=symbol, unit=unit, full=full, **settings)
        )
    return forms


def draw_parameters(rng: np.random.Generator, form: Form, trials: int) -> Active:
    """A form with random further parameters, sign and per-trial numbers, at magnitude zero."""
    values = {name: rng.uniform(low, high) for name, (low, high, _) in form.extras.items()}
    sign = float(rng.choice([-1.0, 1.0])) if form.signed else 1.0
    draws = rng.standard_normal((trials, 2))
    return Active(form, SimpleNamespace(amp=0.0, sign=sign, draw=draws, **values))
