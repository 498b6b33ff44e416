"""Compiled right-hand side, integrator and filter of a system, sixteen simulations at a time.

The functions of a system and its effects are put together into one source file, named after the
hash of all sources that go into it, and compiled by numba with its cache: a changed effect gives a
new file, an unchanged one is loaded. Everything a simulation needs lies in one flat array of rows
of 16 lanes (16 simulations), at offsets that are constants of the source, so that each loop over
lanes becomes vector instructions. Effects that no simulation of a call uses are jumped over.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from ..files import write_text
from . import trigonometry
from .system import Function, Stage, System

LANES = 16
_TEMPLATE = Path(__file__).with_name("kernel_template.txt")


@dataclass(frozen=True)
class Kernel:
    """Compiled functions of one system; see `kernel_template.txt` for their arguments."""

    system: System
    propagate: Callable[..., None]
    kalman: Callable[..., float]


@lru_cache(maxsize=32)
def compiled(system: System) -> Kernel:
    """Kernel of a system, compiled once per change of its sources."""
    text = source(system)
    digest = hashlib.sha256(text.encode())
    for name in sorted(_files(system)):
        digest.update(Path(name).read_bytes())
    name = f"bluekoi_{system.name}_{digest.hexdigest()[:16]}"
    path = _folder() / f"{name}.py"
    if not path.exists():
        write_text(path, text)
    module = _load(name, path)
    return Kernel(system, module.propagate, module.kalman)


def _folder() -> Path:
    default = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "bluekoi"
    folder = Path(os.environ.get("BLUEKOI_CACHE", default)) / "kernels"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _load(name: str, path: Path) -> ModuleType:
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _functions(system: System) -> list[Function]:
    base = [stage.function for stage in system.stages if stage.function]
    own = [f for e in system.effects for f in (*e.hooks.values(), *([e.rates] if e.rates else []))]
    return base + own


def _files(system: System) -> set[str]:
    return {inspect.getfile(f) for f in _functions(system)} | {trigonometry.__file__}


def source(system: System) -> str:
    """Source text of a system's kernel."""
    rows = _Rows(system)
    rates = [s for s in system.stages if s.name != "observe"]
    observe = next(s for s in system.stages if s.name == "observe")
    before = _needed(system, observe)
    return _TEMPLATE.read_text(encoding="utf-8").format(
        imports="\n".join(_imports(system)),
        rates="\n".join(line for stage in rates for line in _stage(system, stage, rows)),
        own_rates="\n".join(_own_rates(system, rows)),
        plain="\n".join(_plain(system, rows)),
        observe="\n".join(
            line for stage in (*before, observe) for line in _stage(system, stage, rows)
        ),
        n_states=len(system.all_states),
        n_parameters=len(system.parameters),
        n_constants=len(system.constants),
        n_inputs=len(system.inputs),
        n_observations=len(system.observations),
        row_t=rows.of("t"),
        row_parameters=rows.first_parameter,
        row_constants=rows.first_constant,
        row_inputs=rows.first_input,
        row_rates=rows.first_rate,
        row_observed=rows.first_observed,
        row_clock=rows.of("clock_rate") if "clock_rate" in rows.named else -1,
        clock=f"m[{rows.of('clock_rate') * LANES} + j]" if "clock_rate" in rows.named else "1.0",
        n_rows=rows.count,
    )


def _needed(system: System, last: Stage) -> list[Stage]:
    """Stages whose outputs the last one needs, directly or through others, in order."""
    names = _arguments(system, last)
    needed: list[Stage] = []
    for stage in reversed([s for s in system.stages if s.name not in ("rates", "observe")]):
        if names & set(stage.outputs):
            needed.insert(0, stage)
            names |= _arguments(system, stage)
    return needed


def _arguments(system: System, stage: Stage) -> set[str]:
    functions = [e.hooks[stage.name] for e in system.effects if stage.name in e.hooks]
    functions += [stage.function] if stage.function else []
    return {name for f in functions for name in inspect.signature(f).parameters}


class _Rows:
    """Row number of every named value in the flat array of a simulation."""

    def __init__(self, system: System) -> None:
        outputs = [
            o for s in system.stages for o in s.outputs if s.name not in ("rates", "observe")
        ]
        self.named: dict[str, int] = {}
        self._add(system.all_states)
        self._add(("t",))
        self.first_parameter = self._add(p.name for p in system.parameters)
        self.first_constant = self._add(system.constants)
        self.first_input = self._add(system.inputs)
        self._add(outputs)
        self.first_rate = self._add(f"d_{s}" for s in system.all_states)
        self.first_observed = self._add(f"y_{o}" for o in system.observations)
        self.count = len(self.named)

    def _add(self, names: object) -> int:
        first = len(self.named)
        for name in names:  # type: ignore[attr-defined]
            if name in self.named:
                raise ValueError(f"the name '{name}' stands for two things")
            self.named[name] = len(self.named)
        return first

    def of(self, name: str) -> int:
        return self.named[name]


def _imports(system: System) -> list[str]:
    """Import lines of all functions, in nopython form under names of their own."""
    lines = []
    for stage in system.stages:
        if stage.function:
            lines += _import(stage.function, f"base_{stage.name}")
    for effect in system.effects:
        for stage_name, function in effect.hooks.items():
            lines += _import(function, f"{effect.name}_{stage_name}")
        if effect.rates:
            lines += _import(effect.rates, f"{effect.name}_own_rates")
    return lines


def _import(function: Function, name: str) -> list[str]:
    return [
        f"from {function.__module__} import {function.__name__} as _{name}",
        f"{name} = njit(error_model='numpy', fastmath=FAST, inline='always')(_{name})",
    ]


def _stage(system: System, stage: Stage, rows: _Rows) -> list[str]:
    """Lane loops of one stage: the model's own function, then each effect that is on."""
    targets = [_target(stage, output, system, rows) for output in stage.outputs]
    if stage.function:
        lines = _loop(f"base_{stage.name}", stage.function, "", targets, rows)
    else:
        lines = ["    for j in range(16):", *(f"        m[{t * LANES} + j] = 0.0" for t in targets)]
    for number, effect in enumerate(system.effects):
        if stage.name in effect.hooks:
            function = effect.hooks[stage.name]
            body = _loop(
                f"{effect.name}_{stage.name}", function, effect.name, targets, rows, assign="+="
            )
            lines += [f"    if on[{number}]:", *("    " + line for line in body)]
    return lines


def _plain(system: System, rows: _Rows) -> list[str]:
    """One lane loop over all stages of the bare model, intermediate values in registers."""
    local: set[str] = set()
    lines = ["    for j in range(16):"]
    for stage in (s for s in system.stages if s.name != "observe"):
        results = [f"d_{o}" if stage.name == "rates" else o for o in stage.outputs]
        if stage.function:
            names = inspect.signature(stage.function).parameters
            given = [n if n in local else f"m[{rows.of(n) * LANES} + j]" for n in names]
            comma = "," if len(results) == 1 else ""
            lines.append(
                f"        {', '.join(results)}{comma} = base_{stage.name}({', '.join(given)})"
            )
        else:
            lines += [f"        {name} = 0.0" for name in results]
        local |= set(stage.outputs) if stage.name != "rates" else set()
    lines += [f"        m[{rows.of(f'd_{s}') * LANES} + j] = d_{s}" for s in system.states]
    if "clock_rate" in local:
        lines.append(f"        m[{rows.of('clock_rate') * LANES} + j] = clock_rate")
    own = [rows.of(f"d_{s}") for e in system.effects for s in e.states]
    return lines + [f"        m[{row * LANES} + j] = 0.0" for row in own]


def _own_rates(system: System, rows: _Rows) -> list[str]:
    lines: list[str] = []
    for number, effect in enumerate(system.effects):
        if effect.states and effect.rates:
            targets = [rows.of(f"d_{s}") for s in effect.states]
            zero = [f"        m[{t * LANES} + j] = 0.0" for t in targets]
            lines += ["    for j in range(16):", *zero]
            body = _loop(f"{effect.name}_own_rates", effect.rates, effect.name, targets, rows)
            lines += [f"    if on[{number}]:", *("    " + line for line in body)]
    return lines


def _target(stage: Stage, output: str, system: System, rows: _Rows) -> int:
    if stage.name == "rates":
        return rows.first_rate + system.states.index(output)
    if stage.name == "observe":
        return rows.first_observed + system.observations.index(output)
    return rows.of(output)


def _loop(
    name: str,
    function: Function,
    effect: str,
    targets: list[int],
    rows: _Rows,
    *,
    assign: str = "=",
) -> list[str]:
    arguments = []
    for argument in inspect.signature(function).parameters:
        own = f"{effect}.{argument}"
        row = rows.named.get(own, rows.named.get(argument))
        if row is None:
            raise TypeError(f"{function.__module__}.{function.__name__}: no value '{argument}'")
        arguments.append(f"m[{row * LANES} + j]")
    results = ", ".join(f"v{i}" for i in range(len(targets)))
    comma = "," if len(targets) == 1 else ""
    return [
        "    for j in range(16):",
        f"        {results}{comma} = {name}({', '.join(arguments)})",
        *(f"        m[{t * LANES} + j] {assign} v{i}" for i, t in enumerate(targets)),
    ]
