"""Faults of a model, found before anything is compiled, each with what to do."""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable, Mapping, Sequence

from ..errors import InputError, InputIssue, did_you_mean
from ..integrate import Parameter, Stage
from .model import (
    CAUSE_KINDS,
    OBSERVE_STAGE,
    RATES_STAGE,
    Cause,
    Constant,
    Function,
    Input,
    Model,
    Observation,
    State,
    names_of_arguments,
)
from .unique_names import check_unique_names
from .unused_numbers import check_unused_numbers

MAX_STATES = 14
"""States of the model with its random forces and errors: sixteen lanes less two."""


def refuse_invalid_model(model: Model) -> None:
    """Raises InputError with all that is wrong with a model."""
    findings = _check_types(model)
    if not findings:
        checks = _check_names, _check_stages, _check_causes, _check_coefficients
        findings = [f for check in checks for f in check(model)]
    if findings := findings or _check_test_calls(model) or check_unused_numbers(model):
        raise InputError(findings)


def _issue(model: Model, where: str, found: object, expected: str, remedy: str = "") -> InputIssue:
    return InputIssue(f"model '{model.name}'", where, str(found), expected, remedy)


FIELD_TYPES = {"states": State, "observations": Observation, "inputs": Input, "constants": Constant,
         "coefficients": Parameter, "stages": Stage, "causes": Cause}  # fmt: skip
"""Field of a model -> type of its entries."""


def _check_types(model: Model) -> list[InputIssue]:
    """Parts of a model of the wrong type: not a sequence of its items, or not a number."""
    out = [f for name, kind in FIELD_TYPES.items()
           for f in _check_tuple_of_type(model, name, getattr(model, name), kind)]  # fmt: skip
    if out:
        return out
    for c in model.causes:
        out += _check_tuple_of_type(model, f"cause {c.name}: parameters", c.parameters, Parameter)
        if not isinstance(c.hooks, Mapping) or not all(map(callable, c.hooks.values())):
            out.append(_issue(model, f"cause {c.name}: hooks", _text_or_type(c.hooks),
                                "{'STAGE': function}"))  # fmt: skip
    rows = [(f"coefficient {p.name}", p) for p in model.coefficients]
    rows += [(f"cause {c.name}: {p.name}", p) for c in model.causes for p in c.parameters]
    for where, value in [
        *((f"{w}: {k}", getattr(p, k)) for w, p in rows for k in ("start", "lower", "upper")),
        *((f"state {s.name}: start_std", s.start_std) for s in model.states),
        *((f"observation {o.name}: std", o.std) for o in model.observations),
    ]:
        if not isinstance(value, numbers.Real):
            out.append(_issue(model, where, repr(value), "a number"))
    return out


def _check_tuple_of_type(model: Model, where: str, given: object, kind: type) -> list[InputIssue]:
    expected = f"a tuple of {kind.__name__}"
    if isinstance(given, kind):
        remedy = "A tuple of one needs a comma: (X,)."
        return [_issue(model, where, f"a single {kind.__name__}", expected, remedy)]
    if isinstance(given, str) or not isinstance(given, Sequence):
        return [_issue(model, where, _text_or_type(given), expected)]
    return [_issue(model, where, _text_or_type(x), expected)
            for x in given if not isinstance(x, kind)]  # fmt: skip


def _text_or_type(value: object) -> str:
    """A text as it stands, of anything else its class."""
    return repr(value) if isinstance(value, str) else type(value).__name__


def _check_names(model: Model) -> list[InputIssue]:
    """Names that are unusable or refer to nothing; counts and standard deviations."""
    out = []
    if not model.name.isidentifier():
        out.append(InputIssue("model", "name", f"'{model.name}'", "letters, digits and _"))
    for what, least in (("states", 1), ("observations", 1), ("stages", 1)):
        if len(getattr(model, what)) < least:
            out.append(_issue(model, what, "none", "one at least"))
    out += check_unique_names(model)
    observed = [o.name for o in model.observations]
    for s in model.states:
        for given in (s.observed, s.rate_of):
            if given and given not in observed:
                out.append(_issue(model, f"state {s.name}", f"'{given}'", "an observation",
                                    did_you_mean(given, observed)))  # fmt: skip
        if not s.start_std > 0:
            out.append(_issue(model, f"state {s.name}: start_std", s.start_std, "above 0"))
    out += [_issue(model, f"observation {o.name}: std", o.std, "above 0")
            for o in model.observations if not o.std > 0]  # fmt: skip
    out += [_issue(model, "path", f"'{n}'", "two observations", did_you_mean(n, observed))
            for n in model.path if n not in observed]  # fmt: skip
    total = len(model.states) + len(model.channels) + len(model.observations)
    if total > MAX_STATES:
        out.append(_issue(model, "states", f"{total} with random forces and lasting errors",
                            f"{MAX_STATES} or fewer"))  # fmt: skip
    return out


def _check_stages(model: Model) -> list[InputIssue]:
    """Stages that are missing, return the wrong outputs or have unknown arguments."""
    out = []
    stages = {s.name: s for s in model.stages}
    for name, wanted, what in (
        (RATES_STAGE, [s.name for s in model.states], "states"),
        (OBSERVE_STAGE, [o.name for o in model.observations], "observations"),
    ):
        if name not in stages:
            out.append(_issue(model, "stages", f"no stage '{name}'", f"one that gives {what}"))
        elif list(stages[name].outputs) != wanted:
            out.append(_issue(model, f"stage {name}", ", ".join(stages[name].outputs),
                                f"the {what} in their order: {', '.join(wanted)}"))  # fmt: skip
    known = set(model.given_names)
    for stage in model.stages:
        if stage.function is not None:
            out += _check_arguments(model, f"stage {stage.name}", stage.function, known)
        elif not stage.open:
            out.append(_issue(model, f"stage {stage.name}", "no function",
                                "a function, or open=True"))  # fmt: skip
        if stage.name not in (RATES_STAGE, OBSERVE_STAGE):
            known |= set(stage.outputs)
    outputs = [o for s in model.stages if s.open for o in s.outputs]
    out += [_issue(model, "pushed", f"'{n}'", "an output of an open stage",
                     did_you_mean(n, outputs))
            for n in model.pushed or () if n not in outputs]  # fmt: skip
    if model.pushed is None and model.force is None:
        out.append(
            _issue(
                model,
                "stages",
                "no open stage 'force'",
                "one that random forces add to, or pushed=() where nothing does",
            )
        )
    return out


def _check_arguments(
    model: Model, where: str, function: Function, known: set[str]
) -> list[InputIssue]:
    """Arguments of a function that are not among the known names."""
    return [_issue(model, f"{where}: {function.__name__}", f"argument '{a}'",
                     "a state, input, constant, coefficient, t or an output of a stage before",
                     did_you_mean(a, known))
            for a in names_of_arguments(function) if a not in known]  # fmt: skip


def _check_causes(model: Model) -> list[InputIssue]:
    """Causes of unknown kind, without a function for an open stage, or with wrong parameters."""
    out = []
    opened = [s.name for s in model.stages if s.open or s.name == OBSERVE_STAGE]
    names = [c.name for c in model.causes]
    out += [_issue(model, "causes", f"two named '{n}'", "a name for each")
            for n in sorted({n for n in names if names.count(n) > 1})]  # fmt: skip
    for c in model.causes:
        where = f"cause {c.name}"
        if not c.name.isidentifier():
            out.append(_issue(model, where, "the name", "letters, digits and _"))
        if c.kind not in CAUSE_KINDS:
            out.append(_issue(model, f"{where}: kind", f"'{c.kind}'", " or ".join(CAUSE_KINDS)))
        if not c.hooks:
            out.append(_issue(model, f"{where}: hooks", "none", "a function for a stage"))
        for stage in c.hooks:
            if stage not in opened:
                out.append(_issue(model, f"{where}: hooks", f"stage '{stage}'", "an open stage",
                                    did_you_mean(stage, opened)))  # fmt: skip
        if not 1 <= c.strengths <= len(c.parameters):
            out.append(
                _issue(
                    model,
                    f"{where}: strengths",
                    c.strengths,
                    f"1 to {len(c.parameters)}, the number of its parameters",
                )
            )
        for k, p in enumerate(c.parameters):
            out += _check_bounds(model, f"{where}: {p.name}", p, zero=k < c.strengths)
        out += _check_cause_arguments(model, c)
    return out


def _check_cause_arguments(model: Model, cause: Cause) -> list[InputIssue]:
    """Arguments of a cause's functions that nothing gives."""
    base = model.given_names | {p.argument_name for p in cause.parameters} | set(cause.states)
    every = base | {
        o for s in model.stages if s.name not in (RATES_STAGE, OBSERVE_STAGE) for o in s.outputs
    }
    out = []
    for stage, function in cause.hooks.items():
        known = set(base)
        for s in model.stages:
            if s.name not in (RATES_STAGE, OBSERVE_STAGE):
                known |= set(s.outputs)  # of its own stage too: what the model gives there
            if s.name == stage:
                break
        out += _check_arguments(model, f"cause {cause.name}", function, known)
    if cause.rates is not None:
        out += _check_arguments(model, f"cause {cause.name}", cause.rates, every)
    return out


def _check_coefficients(model: Model) -> list[InputIssue]:
    """Coefficients with wrong bounds, or that no equation takes as an argument."""
    out = [f for p in model.coefficients
           for f in _check_bounds(model, f"coefficient {p.name}", p, zero=False)]  # fmt: skip
    known = [p.name for p in model.coefficients]
    used = {a for f in _all_functions(model) for a in names_of_arguments(f)}
    out += [_issue(model, f"coefficient {n}", "no equation that asks for it",
                     "an argument of that name in a stage or a cause") for n in known
            if n not in used]  # fmt: skip
    return out + [_issue(model, "per_group", f"'{n}'", "a coefficient", did_you_mean(n, known))
                  for n in model.per_group if n not in known]  # fmt: skip


def _all_functions(model: Model) -> list[Function]:
    """Functions of all stages and causes."""
    own = [s.function for s in model.stages if s.function is not None]
    for c in model.causes:
        own += [*c.hooks.values(), *([c.rates] if c.rates is not None else [])]
    return own


def _check_bounds(model: Model, where: str, p: Parameter, *, zero: bool) -> list[InputIssue]:
    """Start value and bounds of a parameter; zero: the bounds must include 0."""
    if not all(math.isfinite(x) for x in (p.start, p.lower, p.upper)):
        return [_issue(model, where, f"{p.start}, {p.lower} to {p.upper}",
                         "a finite start value and bounds")]  # fmt: skip
    if not p.lower <= p.start <= p.upper or p.lower == p.upper:
        return [_issue(model, where, f"start {p.start:g}, bounds {p.lower:g} to {p.upper:g}",
                         "a start value between its bounds")]  # fmt: skip
    if zero and not p.lower <= 0.0 <= p.upper:
        return [
            _issue(
                model,
                where,
                f"bounds {p.lower:g} to {p.upper:g}",
                "bounds that include 0: a cause is absent where its strength is 0",
            )
        ]
    return []


def _check_test_calls(model: Model) -> list[InputIssue]:
    """Functions called once with plain numbers: errors and wrong counts of outputs."""
    stages = {s.name: s for s in model.stages}
    out = [f for s in model.stages if s.function is not None
           for f in _check_test_call(model, f"stage {s.name}", s.function, s.outputs)]  # fmt: skip
    for c in model.causes:
        for name, function in c.hooks.items():
            where = f"cause {c.name}, stage {name}"
            out += _check_test_call(model, where, function, stages[name].outputs)
        if c.rates is not None:
            out += _check_test_call(model, f"cause {c.name}, rates", c.rates, c.states)
    return out


def _check_test_call(
    model: Model, where: str, function: Callable[..., object], outputs: Sequence[str]
) -> list[InputIssue]:
    place = f"{where}: {function.__name__}"
    expected = f"a tuple of {len(outputs)}: {', '.join(outputs)}"
    try:
        found = function(*(0.5 + 0.1 * i for i in range(len(names_of_arguments(function)))))
    except ArithmeticError:
        return []
    except (Exception, SystemExit) as error:
        return [_issue(model, place, f"{type(error).__name__}: {error}", expected)]
    if not isinstance(found, tuple) or len(found) != len(outputs):
        shown = f"{len(found)} values" if isinstance(found, tuple) else type(found).__name__
        return [_issue(model, place, shown, expected)]
    wrong = [v for v in found if not isinstance(v, numbers.Real)]
    return [_issue(model, place, f"{type(wrong[0]).__name__}", expected)] if wrong else []
