"""Places of all that a simulation needs, in one flat array of rows of sixteen lanes."""

from __future__ import annotations

from collections.abc import Iterable

from .system import Stage, System

LANES = 16
"""Simulations that one call of the kernel advances together."""


class RowNumbers:
    """Row number of every named value: states, time, parameters, constants, inputs, outputs of
    stages, rates, start and sum of a Runge-Kutta step, observations. own: (effect, argument of its
    functions) -> row of its parameter.
    """

    def __init__(self, system: System) -> None:
        outputs = [
            o for s in system.stages for o in s.outputs if s.name not in ("rates", "observe")
        ]
        self._system = system
        self.named: dict[str, int] = {}
        self._add(system.all_states)
        self._add(("t",))
        self.first_parameter = self._add(p.name for p in system.parameters)
        self.own = {(e.name, p.argument): self.named[f"{e.name}.{p.name}"]
                    for e in system.effects for p in e.parameters}  # fmt: skip
        self.first_constant = self._add(system.constants)
        self.first_input = self._add(system.inputs)
        self._add(outputs)
        self.first_rate = self._add(f"d_{s}" for s in system.all_states)
        self.first_start = self._add(f"start_{s}" for s in system.all_states)
        self.first_total = self._add(f"total_{s}" for s in system.all_states)
        self.first_observed = self._add(f"y_{o}" for o in system.observations)
        self.count = len(self.named)

    def _add(self, names: Iterable[str]) -> int:
        first = len(self.named)
        for name in names:
            if name in self.named:
                raise ValueError(f"the name '{name}' stands for two things")
            self.named[name] = len(self.named)
        return first

    def of(self, name: str) -> int:
        """Row of a named value."""
        return self.named[name]

    def outputs(self, stage: Stage) -> list[int]:
        """Rows that a stage writes to."""
        if stage.name == "rates":
            return [self.first_rate + self._system.states.index(o) for o in stage.outputs]
        if stage.name == "observe":
            return [self.first_observed + self._system.observations.index(o) for o in stage.outputs]
        return [self.of(o) for o in stage.outputs]
