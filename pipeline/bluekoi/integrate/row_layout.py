"""Places of all that a simulation needs, in one flat array of rows of sixteen lanes."""

from __future__ import annotations

from collections.abc import Iterable

from .system import Stage, System

LANES = 16
"""Simulations that one call of the kernel advances together."""
TIME_NAME = "t"
STATE_ROW_NAME_FORMATS = {
    "d_{}": "the derivative of the state",
    "start_{}": "the state at the start of a step",
    "total_{}": "the sum over a step of the state",
}
OBSERVATION_ROW_NAME_FORMAT = "y_{}"


def reserved_integrator_names(states: Iterable[str], observations: Iterable[str]) -> dict[str, str]:
    """Names that no other value may have, with what each of them is."""
    own = {row.format(s): f"{meaning} '{s}'" for s in states
           for row, meaning in STATE_ROW_NAME_FORMATS.items()}  # fmt: skip
    seen = {OBSERVATION_ROW_NAME_FORMAT.format(o): f"the observation '{o}'" for o in observations}
    return {TIME_NAME: "the time"} | own | seen


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
        self._append_rows(system.all_states)
        self._append_rows((TIME_NAME,))
        self.first_parameter = self._append_rows(p.name for p in system.parameters)
        self.own = {(e.name, p.argument_name): self.named[f"{e.name}.{p.name}"]
                    for e in system.effects for p in e.parameters}  # fmt: skip
        self.first_constant = self._append_rows(system.constants)
        self.first_input = self._append_rows(system.inputs)
        self._append_rows(outputs)
        self.first_rate, self.first_start, self.first_total = (
            self._append_rows(row.format(s) for s in system.all_states)
            for row in STATE_ROW_NAME_FORMATS
        )
        self.first_observed = self._append_rows(
            OBSERVATION_ROW_NAME_FORMAT.format(o) for o in system.observations
        )
        self.count = len(self.named)

    def _append_rows(self, names: Iterable[str]) -> int:
        first = len(self.named)
        for name in names:
            if name in self.named:
                raise ValueError(f"the name '{name}' stands for two things")
            self.named[name] = len(self.named)
        return first

    def row_of(self, name: str) -> int:
        """Row of a named value."""
        return self.named[name]

    def stage_output_rows(self, stage: Stage) -> list[int]:
        """Rows that a stage writes to."""
        if stage.name == "rates":
            return [self.first_rate + self._system.states.index(o) for o in stage.outputs]
        if stage.name == "observe":
            return [self.first_observed + self._system.observations.index(o) for o in stage.outputs]
        return [self.row_of(o) for o in stage.outputs]
