"""Source text of a system's kernel: its functions put into loops over sixteen lanes.

A step of the integrator takes one of three ways. Where no effect is on, and where only random
parts are, the whole right-hand side and the Runge-Kutta sum stand in one loop, intermediate values
in registers. With other effects on, each stage is a loop of its own, and effects that are off are
jumped over. Stages that depend on nothing that moves (sines of a constant head angle, 1/m) are
evaluated once a frame and held.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from .dependence import RANDOM, arguments, held, moving, names, needed, zeros
from .rows import LANES, Rows
from .system import Effect, Function, Stage, System

TEMPLATE = Path(__file__).with_name("kernel_template.txt")


def source(system: System) -> str:
    """Source text of a system's kernel."""
    rows = Rows(system)
    observe = next(s for s in system.stages if s.name == "observe")
    before = needed(system, observe)
    random = tuple(e for e in system.effects if e.kind == RANDOM)
    clock = "clock_rate" in rows.named
    return TEMPLATE.read_text(encoding="utf-8").format(
        imports="\n".join(_imports(system)),
        hold="\n".join(_hold(system, rows)),
        fused="\n\n\n".join(
            _fused(system, rows, effects, name=f"{name}_{part}", part=part)
            for name, effects in (("bare", ()), ("random", random))
            for part in ("first", "middle", "last")
        ),
        rates="\n".join(_rates(system, rows)),
        shift="\n".join(_shift(system)),
        observe="\n".join(
            line for stage in (*before, observe) for line in _stage(system, stage, rows)
        ),
        mode=_mode(system),
        fused_time=any("t" in arguments(s, random) for s in moving(system)),
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
        row_start=rows.first_start,
        row_total=rows.first_total,
        row_observed=rows.first_observed,
        clock=f"m[{rows.of('clock_rate') * LANES} + j]" if clock else "1.0",
        n_rows=rows.count,
    )


def _imports(system: System) -> list[str]:
    """Import lines of all functions, compiled under names of their own.

    Functions of what is nothing without effects (the water's velocity) are there once more, under
    rules that let the compiler drop products with 0.
    """
    lines, nothing = [], zeros(system)
    for stage in system.stages:
        if stage.function:
            lines += _import(stage.function, f"base_{stage.name}")
            if arguments(stage, ()) & nothing:
                lines += _import(stage.function, f"still_{stage.name}", "STILL")
    for effect in system.effects:
        for stage_name, function in effect.hooks.items():
            lines += _import(function, f"{effect.name}_{stage_name}")
        if effect.rates:
            lines += _import(effect.rates, f"{effect.name}_own_rates")
    return lines


def _import(function: Function, name: str, rules: str = "FAST") -> list[str]:
    return [
        f"from {function.__module__} import {function.__name__} as _{name}",
        f"{name} = njit(error_model='numpy', fastmath={rules}, forceinline=True)(_{name})",
    ]


def _hold(system: System, rows: Rows) -> list[str]:
    lines = [line for stage in held(system) for line in _base(stage, rows)]
    return lines or ["    pass"]


def _mode(system: System) -> str:
    """Expression: 0 no effect on, 1 random parts alone, 2 others."""
    others = [f"on[{i}]" for i, e in enumerate(system.effects) if e.kind != RANDOM]
    return f"2 if {' or '.join(others) or 'False'} else (1 if on.any() else 0)"


def _fused(system: System, rows: Rows, effects: Sequence[Effect], *, name: str, part: str) -> str:
    """One Runge-Kutta stage in a single loop: rates, and what they add to state and sum."""
    local = dict.fromkeys(zeros(system), "0.0")
    lines = [f"def {name}(m, weight, reach):", "    for j in range(16):"]
    for stage in moving(system):
        results = [f"d_{o}" if stage.name == "rates" else o for o in stage.outputs]
        lines += _calls(stage, effects, results, local, rows)
        local |= {result: f"v_{result}" for result in results}
    states = list(system.states)
    for effect in effects:
        if effect.rates:
            call = _call(f"{effect.name}_own_rates", effect.rates, effect.name, local, rows)
            lines.append(f"        {_tuple(f'v_d_{s}' for s in effect.states)} = {call}")
            states += effect.states
    clock = "clock_rate" in local or "clock_rate" in rows.named
    rate = _value("clock_rate", "", local, rows) if clock else "1.0"
    lines += [f"        w, c = weight * {rate}, reach * {rate}"]
    for state in states:
        lines += _update(rows, state, part)
    return "\n".join(['@njit(error_model="numpy", fastmath=FAST)', *lines])


def _calls(
    stage: Stage,
    effects: Sequence[Effect],
    results: list[str],
    local: Mapping[str, str],
    rows: Rows,
) -> list[str]:
    """Lines that give a stage's outputs as local values, what effects add included."""
    targets = _tuple(f"v_{r}" for r in results)
    if stage.function:
        form = "still" if "0.0" in [local.get(n) for n in names(stage.function)] else "base"
        call = _call(f"{form}_{stage.name}", stage.function, "", local, rows)
        lines = [f"        {targets} = {call}"]
    else:
        lines = [f"        v_{r} = 0.0" for r in results]
    for effect in effects:
        if stage.name in effect.hooks:
            call = _call(
                f"{effect.name}_{stage.name}", effect.hooks[stage.name], effect.name, local, rows
            )
            lines.append(f"        {_tuple(f'a_{r}' for r in results)} = {call}")
            lines += [f"        v_{r} += a_{r}" for r in results]
    return lines


def _update(rows: Rows, state: str, part: str) -> list[str]:
    """Lines that add a rate: the first part begins the sum, the last one ends the step."""
    now, start, total = (
        f"m[{rows.of(prefix + state) * LANES} + j]" for prefix in ("", "start_", "total_")
    )
    rate = f"v_d_{state}"
    if part == "first":
        return [f"        {start} = {now}", f"        {total} = w * {rate}",
                f"        {now} = {now} + c * {rate}"]  # fmt: skip
    if part == "middle":
        return [f"        {total} += w * {rate}", f"        {now} = {start} + c * {rate}"]
    return [f"        {now} = {start} + {total} + w * {rate}"]


def _tuple(parts: Iterable[str]) -> str:
    listed = list(parts)
    return ", ".join(listed) + ("," if len(listed) == 1 else "")


def _call(name: str, function: Function, effect: str, local: Mapping[str, str], rows: Rows) -> str:
    given = [_value(a, effect, local, rows, where=function) for a in names(function)]
    return f"{name}({', '.join(given)})"


def _value(
    name: str, effect: str, local: Mapping[str, str], rows: Rows, *, where: Function | None = None
) -> str:
    """Expression for a named value: a local one, else its row; an effect's own names come first."""
    own = rows.named.get(f"{effect}.{name}")
    if own is None and name in local:
        return local[name]
    row = own if own is not None else rows.named.get(name)
    if row is None:
        place = f"{where.__module__}.{where.__name__}" if where else effect
        raise TypeError(f"{place}: no value '{name}'")
    return f"m[{row * LANES} + j]"


def _rates(system: System, rows: Rows) -> list[str]:
    """Every stage as loops of its own; held stages only where an effect may change them."""
    still = held(system)
    changed: dict[str, list[int]] = {}
    lines: list[str] = []
    for stage in (s for s in system.stages if s.name != "observe"):
        if stage not in still:
            lines += _stage(system, stage, rows)
            continue
        own = {i for i, e in enumerate(system.effects) if stage.name in e.hooks}
        for name in arguments(stage, ()):
            own |= set(changed.get(name, ()))
        changed |= {o: sorted(own) for o in stage.outputs}
        if own:
            lines.append(f"    if {' or '.join(f'on[{i}]' for i in sorted(own))}:")
            lines += ["    " + line for line in _stage(system, stage, rows)]
    return lines + _own_rates(system, rows)


def _stage(system: System, stage: Stage, rows: Rows) -> list[str]:
    """Lane loops of one stage: the model's own function, then each effect that is on."""
    lines = _base(stage, rows)
    for number, effect in enumerate(system.effects):
        if stage.name in effect.hooks:
            call = _call(f"{effect.name}_{stage.name}", effect.hooks[stage.name], effect.name,
                         {}, rows)  # fmt: skip
            body = _loop(call, rows.outputs(stage), assign="+=")
            lines += [f"    if on[{number}]:", *("    " + line for line in body)]
    return lines


def _base(stage: Stage, rows: Rows) -> list[str]:
    targets = rows.outputs(stage)
    if stage.function:
        call = _call(f"base_{stage.name}", stage.function, "", {}, rows)
        return _loop(call, targets, assign="=")
    return ["    for j in range(16):", *(f"        m[{t * LANES} + j] = 0.0" for t in targets)]


def _loop(call: str, targets: list[int], *, assign: str) -> list[str]:
    return [
        "    for j in range(16):",
        f"        {_tuple(f'v{i}' for i in range(len(targets)))} = {call}",
        *(f"        m[{t * LANES} + j] {assign} v{i}" for i, t in enumerate(targets)),
    ]


def _own_rates(system: System, rows: Rows) -> list[str]:
    lines: list[str] = []
    for number, effect in enumerate(system.effects):
        if effect.states and effect.rates:
            call = _call(f"{effect.name}_own_rates", effect.rates, effect.name, {}, rows)
            body = _loop(call, [rows.of(f"d_{s}") for s in effect.states], assign="=")
            lines += [f"    if on[{number}]:", *("    " + line for line in body)]
    return lines


def _shift(system: System) -> list[str]:
    """Calls that move the model's states, and those of the effects that are on."""
    lines = [f"    shift_rows(m, 0, {len(system.states)}, weight, reach, part)"]
    for number, effect in enumerate(system.effects):
        if effect.states:
            first, count = system.all_states.index(effect.states[0]), len(effect.states)
            lines += [
                f"    if on[{number}]:",
                f"        shift_rows(m, {first}, {count}, weight, reach, part)",
            ]
    return lines
