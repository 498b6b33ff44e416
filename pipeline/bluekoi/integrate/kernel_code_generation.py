"""Source text of a system's kernels: its functions put into loops over sixteen lanes.

There are two. The fast one is for no effects and for random parts alone: the whole right-hand side
and its share of the Runge-Kutta sum stand in one loop, intermediate values in registers. In the
general one each stage is a loop of its own, and effects that are off are jumped over. Stages that
are constant in time (sines of a constant head angle, 1/m) are evaluated once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .lane_loops import LaneLoopWriter
from .row_layout import LANES, RowNumbers
from .stage_dependencies import (
    STOCHASTIC_EFFECT_KIND,
    aliased_or_constant_outputs,
    constant_stages,
    required_stages,
    stage_arguments,
    state_dependent_stages,
)
from .system import Effect, Function, Stage, System

KERNEL_TEMPLATE, STEP_TEMPLATE = (
    Path(__file__).with_name(f"{name}_template.txt").read_text(encoding="utf-8")
    for name in ("kernel", "step")
)
FUNCTION_HEADER = '@njit(error_model="numpy", fastmath=FAST{})\ndef {}:'
STATE_ADVANCE_FUNCTION_HEADER = FUNCTION_HEADER.format(
    ", forceinline=True", "move(m, on, pushed, h, t0, inputs, frame, substeps, varying)"
)


@dataclass(frozen=True)
class _KernelSpecification:
    """What a kernel is written from; `called` collects functions that cannot be written out."""

    system: System
    rows: RowNumbers
    effects: tuple[Effect, ...]
    called: dict[str, Function] = field(default_factory=dict)

    def activity_condition(self, effects: Iterable[Effect]) -> str:
        """Condition that one of these effects is on."""
        return " or ".join(f"on[{self.system.effects.index(e)}]" for e in effects)

    def source_lines(self, loop: LaneLoopWriter, depth: int = 1) -> list[str]:
        """Lines of a finished loop."""
        self.called.update(loop.not_inlined_functions)
        return loop.source_lines("    " * depth)


def kernel_source(system: System, *, general: bool) -> str:
    """Source text of a system's general kernel, or of its fast one."""
    plan = _KernelSpecification(
        system,
        RowNumbers(system),
        system.effects if general else stochastic_effects_of_system(system),
    )
    parts = {
        "hold": _constant_stages_source(plan),
        "observe": _observation_stage_code(plan),
        "moves": _general_kernel_source(plan) if general else _fast_kernel_source(plan),
        "zero_order_hold": _zero_order_hold_source(plan),
        "hold_again": ["    hold(m)"] if system.zero_order_hold else [],
    }
    rows = plan.rows
    return KERNEL_TEMPLATE.format(
        **{name: "\n".join(lines) for name, lines in parts.items()},
        imports="\n".join(_import_lines(plan.called)),
        n_states=len(system.all_states),
        n_inputs=len(system.inputs),
        n_observations=len(system.observations),
        row_t=rows.row_of("t"),
        row_parameters=rows.first_parameter,
        row_constants=rows.first_constant,
        row_inputs=rows.first_input,
        row_start=rows.first_start,
        row_total=rows.first_total,
        row_observed=rows.first_observed,
        n_rows=rows.count,
    )


def stochastic_effects_of_system(system: System) -> tuple[Effect, ...]:
    """The effects that every filter has: random forces and errors."""
    return tuple(e for e in system.effects if e.kind == STOCHASTIC_EFFECT_KIND)


def _zero_order_hold_source(plan: _KernelSpecification) -> list[str]:
    """Lines that keep held inputs at their value of the frame before."""
    out: list[str] = []
    for name in plan.system.zero_order_hold:
        row, column = plan.rows.row_of(name), plan.system.inputs.index(name)
        out += [f"    for j in range({LANES}):",
                f"        m[{row * LANES} + j] = inputs[frame - 1, {column}]"]  # fmt: skip
    return out


def _import_lines(called: dict[str, Function]) -> list[str]:
    """Import lines of the functions that could not be written out, compiled by the kernel."""
    lines = []
    for name, function in sorted(called.items()):
        lines += [
            f"from {function.__module__} import {function.__name__} as _{name}",
            f"{name} = compiled_here(_{name})",
        ]
    return lines


def _constant_stages_source(plan: _KernelSpecification) -> list[str]:
    return [line for s in constant_stages(plan.system) for line in _base_model_loop(plan, s)] or [
        "    pass"
    ]


def _fast_kernel_source(plan: _KernelSpecification) -> list[str]:
    """Steps without effects and with random parts, and which is taken."""
    timed = [any("t" in stage_arguments(s, effects) for s in state_dependent_stages(plan.system))
             for effects in ((), plan.effects)]  # fmt: skip
    body, pushed = _fused_stage_source(plan, ()), _fused_stage_source(plan, plan.effects)
    all_states, own = len(plan.system.all_states), len(plan.system.states)
    return [
        STEP_TEMPLATE.format(way="bare", count=own, timed=timed[0], body="\n".join(body)),
        STEP_TEMPLATE.format(
            way="random", count=all_states, timed=timed[1], body="\n".join(pushed)
        ),
        STATE_ADVANCE_FUNCTION_HEADER,
        "    if pushed:",
        "        move_random(m, on, h, t0, inputs, frame, substeps, varying)",
        "    else:",
        "        move_bare(m, on, h, t0, inputs, frame, substeps, varying)",
    ]


def _fused_stage_source(plan: _KernelSpecification, effects: Sequence[Effect]) -> list[str]:
    """One Runge-Kutta stage in a single loop: rates, and what they add to state and sum."""
    loop, rows = LaneLoopWriter(plan.rows, aliased_or_constant_outputs(plan.system)), plan.rows
    for stage in state_dependent_stages(plan.system):
        last = stage.name == "rates"
        loop.add_stage(stage, [f"d_{o}" if last else o for o in stage.outputs], effects)
    states = list(plan.system.states)
    for effect in effects:
        if effect.rates:
            rates = loop.output_expressions(effect.rates, len(effect.states), effect.name)
            for state, rate in zip(effect.states, rates, strict=True):
                loop.bind_name(f"d_{state}", rate)
            states += effect.states
    clock = loop.expression_of("clock_rate") if "clock_rate" in rows.named else "1.0"
    for name in ("weight", "reach"):
        loop.bind_name(name, name if clock == "1.0" else f"{name} * {clock}")
    for state in states:
        _accumulate_rate(loop, rows, state, loop.expression_of(f"d_{state}"))
    return plan.source_lines(loop, 3)


def _accumulate_rate(loop: LaneLoopWriter, rows: RowNumbers, state: str, rate: str) -> None:
    """Add a rate to a state's sum, and set the state for the next part of the step."""
    start = loop.load_row(rows.row_of(f"start_{state}"))
    loop.store_row(rows.row_of(state), f"{start} + {loop.expression_of('reach')} * {rate}")
    loop.store_row(rows.row_of(f"total_{state}"), f"{loop.expression_of('weight')} * {rate}", "+=")


def _general_kernel_source(plan: _KernelSpecification) -> list[str]:
    """Rates by stages, and a step by them."""
    body = ["            rates(m, on)", *_accumulation_source(plan, plan.system.states)]
    for effect in plan.effects:
        if effect.rates:
            lines = _accumulation_source(plan, effect.states)
            body += [
                f"            if {plan.activity_condition([effect])}:",
                *(f"    {line}" for line in lines),
            ]
    timed = [
        e for e in plan.effects if any("t" in stage_arguments(s, (e,)) for s in plan.system.stages)
    ]
    return [
        FUNCTION_HEADER.format("", "rates(m, on)"),
        *_state_derivatives_source(plan),
        "\n",
        STEP_TEMPLATE.format(way="any", count=len(plan.system.all_states),
                    timed=plan.activity_condition(timed) or False, body="\n".join(body)),
        STATE_ADVANCE_FUNCTION_HEADER,
        "    move_any(m, on, h, t0, inputs, frame, substeps, varying)",
    ]  # fmt: skip


def _accumulation_source(plan: _KernelSpecification, states: Sequence[str]) -> list[str]:
    loop = LaneLoopWriter(plan.rows)
    clock = f" * {loop.expression_of('clock_rate')}" if "clock_rate" in plan.rows.named else ""
    for name in ("weight", "reach"):
        loop.bind_name(name, name + clock)
    for state in states:
        _accumulate_rate(loop, plan.rows, state, loop.load_row(plan.rows.row_of(f"d_{state}")))
    return plan.source_lines(loop, 3)


def _state_derivatives_source(plan: _KernelSpecification) -> list[str]:
    """Every stage as loops of its own; held stages only where an effect may change them."""
    constant = constant_stages(plan.system)
    changed: dict[str, list[Effect]] = {}
    lines: list[str] = []
    for stage in (s for s in plan.system.stages if s.name != "observe"):
        if stage not in constant:
            lines += _stage_code(plan, stage)
            continue
        asked = {e for name in stage_arguments(stage, ()) for e in changed.get(name, ())}
        own = [e for e in plan.effects if stage.name in e.hooks or e in asked]
        changed |= dict.fromkeys(stage.outputs, own)
        lines += _code_lines_if_effect_active(plan, own, _stage_code(plan, stage))
    for effect in plan.effects:
        if effect.rates:
            targets = [plan.rows.row_of(f"d_{s}") for s in effect.states]
            lines += _code_lines_if_effect_active(
                plan, [effect], _assignment_loop(plan, effect.rates, targets, effect.name)
            )
    return lines


def _observation_stage_code(plan: _KernelSpecification) -> list[str]:
    """What is seen; stages that only effects ask for where one of those is on."""
    observe = next(s for s in plan.system.stages if s.name == "observe")
    always = required_stages(plan.system, observe, ())
    lines: list[str] = []
    for stage in required_stages(plan.system, observe, plan.effects):
        asking = [e for e in plan.effects if stage in required_stages(plan.system, observe, (e,))]
        found = _stage_code(plan, stage)
        lines += found if stage in always else _code_lines_if_effect_active(plan, asking, found)
    return lines + _stage_code(plan, observe)


def _code_lines_if_effect_active(
    plan: _KernelSpecification, effects: Sequence[Effect], lines: Sequence[str]
) -> list[str]:
    """Lines for where one of the effects is on."""
    return (
        [f"    if {plan.activity_condition(effects)}:", *(f"    {line}" for line in lines)]
        if effects
        else []
    )


def _stage_code(plan: _KernelSpecification, stage: Stage) -> list[str]:
    """Lane loops of one stage: the model's own function, then each effect that is on."""
    lines, targets = _base_model_loop(plan, stage), plan.rows.stage_output_rows(stage)
    for effect in plan.effects:
        if stage.name in effect.hooks:
            added = _assignment_loop(
                plan, effect.hooks[stage.name], targets, effect.name, assign="+="
            )
            lines += _code_lines_if_effect_active(plan, [effect], added)
    return lines


def _base_model_loop(plan: _KernelSpecification, stage: Stage) -> list[str]:
    targets = plan.rows.stage_output_rows(stage)
    if stage.function:
        return _assignment_loop(plan, stage.function, targets, "")
    loop = LaneLoopWriter(plan.rows)
    for target in targets:
        loop.store_row(target, "0.0")
    return plan.source_lines(loop)


def _assignment_loop(
    plan: _KernelSpecification,
    function: Function,
    targets: Sequence[int],
    effect: str,
    *,
    assign: str = "=",
) -> list[str]:
    """Loop that sets rows to a function's outputs, or adds these to them."""
    loop = LaneLoopWriter(plan.rows)
    for target, value in zip(
        targets, loop.output_expressions(function, len(targets), effect), strict=True
    ):
        if assign == "=" or value not in ("0.0", "0"):
            loop.store_row(target, value, assign)
    return plan.source_lines(loop)
