"""The system of a model: its equations, causes, random forces, lasting errors, residual terms.

Random forces and residual terms are written for each model into a file of short functions beside
the compiled code, so that they are compiled as the model's own are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from ..engine import PriorInclusionProbabilities
from ..engine.candidates import RESIDUAL_EFFECT_KIND, ChannelVariablePairs
from ..files import write_text
from ..integrate import Effect, Parameter, System, kernel_folder
from ..integrate.compiled_system import load_source
from .model import (
    OBSERVE_STAGE,
    Cause,
    Model,
    channels_of_cause,
    names_of_arguments,
    variables_of_cause,
)

RANDOM_FORCE, COLOURED_ERROR = "random_force", "lasting_error"
"""Names of the effects that are present in every filter: random forces, lasting errors of the
observations.
"""
CONSTANT_TERM_VARIABLE = "constant"
"""Variable of a residual term that is constant."""
RESIDUAL_STRENGTH_BOUND = 50.0
"""Bounds of a residual term's strength, in units of the typical force."""


@dataclass(frozen=True)
class ResidualTerm:
    """A residual term: the channel it pushes, the variable it depends on, its expression."""

    name: str
    channel: str
    variable: str
    expression: str


@dataclass(frozen=True)
class AssembledSystem:
    """A system, the sources of its residual terms, and the priors of its causes."""

    system: System
    residual_sources: Mapping[str, ChannelVariablePairs]
    priors: PriorInclusionProbabilities


def assemble_system(
    model: Model, *, force_scale: Mapping[str, float] | None = None, step_s: float | None = None,
    hold: bool = True,
) -> AssembledSystem:  # fmt: skip
    """`AssembledSystem` of a model; force_scale: channel -> typical size, for residual terms; hold:
    whether held inputs are as recorded, and not averaged to a lower rate.
    """
    terms = residual_terms(model)
    module = _generate_module(model, terms)
    effects = [
        *_random_force_and_error_effects(model, module),
        *(_effect_from_cause(model, c) for c in model.causes),
    ]
    if terms:
        effects.append(_effect_from_residual_terms(model, module, terms, force_scale or {}))
    system = System(
        model.name,
        states=tuple(s.name for s in model.states),
        constants=(*(c.name for c in model.constants), *scale_constant_names(model)),
        inputs=tuple(i.name for i in model.inputs),
        coefficients=tuple(model.coefficients),
        stages=tuple(replace(s, open=True) if s.name == OBSERVE_STAGE else s for s in model.stages),
        observations=tuple(o.name for o in model.observations),
        effects=tuple(effects),
        zero_order_hold=tuple(i.name for i in model.inputs if i.held and hold),
        step_s=step_s,
    )
    known = {c.name: c.prior for c in model.causes if np.isfinite(c.prior)}
    return AssembledSystem(
        system,
        {f"{RESIDUAL_EFFECT_KIND}.{t.name}": frozenset({(t.channel, t.variable)}) for t in terms},
        PriorInclusionProbabilities(likely=known),
    )


def residual_term_variables(model: Model) -> tuple[str, ...]:
    """States and inputs that residual terms depend on."""
    if model.force is None:
        return ()
    return tuple(x.name for x in model.variables)


def scale_constant_names(model: Model) -> tuple[str, ...]:
    """Constants that hold the typical size of each variable."""
    return tuple(f"scale_{v}" for v in residual_term_variables(model))


def residual_terms(model: Model) -> list[ResidualTerm]:
    """Residual terms of every channel: constant, in proportion to and as the square of every state
    and input; sine and cosine of angles in place of these.
    """
    angles = {s.name for s in model.states for o in model.observations
              if o.angle and s.observed == o.name}  # fmt: skip
    out: list[ResidualTerm] = []
    for c in model.channels:
        out.append(ResidualTerm(f"{c}_constant", c, CONSTANT_TERM_VARIABLE, "{k}"))
        for v in residual_term_variables(model):
            q = f"({v} / scale_{v})"
            if v in angles:
                forms = {"sin": f"sin_cos({v})[0]", "cos": f"sin_cos({v})[1]"}
            else:
                forms = {"linear": q, "square": f"{q} * abs({q})"}
            out += [
                ResidualTerm(f"{c}_{v}_{kind}", c, v, "{k} * " + text)
                for kind, text in forms.items()
            ]
    return [
        t
        for t in out
        if not any(_cause_equals_residual_term(model, cause, t) for cause in model.causes)
    ]


EQUALITY_PROBE_COUNT = 5
"""States, drawn at random, at which it is asked which outputs a cause changes."""


def _cause_equals_residual_term(model: Model, cause: Cause, term: ResidualTerm) -> bool:
    """Whether a named cause is the force of a residual term, which then has a name."""
    stage = model.force
    if stage is None or set(cause.hooks) != {stage.name} or cause.strengths != 1 or cause.rates:
        return False
    strength, function = cause.parameters[0].argument_name, cause.hooks[stage.name]
    names = names_of_arguments(function)
    if not set(names) <= {strength, term.variable} or len(cause.parameters) > 1:
        return False
    rng, ratios = np.random.default_rng(1), []
    for q in rng.uniform(0.5, 2.0, EQUALITY_PROBE_COUNT) * np.array([1, -1, 1, -1, 1]):
        given = {strength: 1.0, term.variable: float(q)}
        force = np.array(function(*(given[n] for n in names)), dtype=float)
        expected = _residual_term_value(term, float(q))
        other = [i for i, o in enumerate(stage.outputs) if o != term.channel]
        if np.any(force[other] != 0.0):
            return False
        ratios.append(force[stage.outputs.index(term.channel)] / expected)
    return bool(np.ptp(ratios) < 1e-6 * np.abs(ratios[0]))


def _residual_term_value(term: ResidualTerm, q: float) -> float:
    """A residual term of unit strength at a value of its variable, in units of its scale."""
    kind = term.name.rsplit("_", 1)[-1]
    forms = {"constant": 1.0, "linear": q, "square": q * abs(q), "sin": np.sin(q), "cos": np.cos(q)}
    return float(forms[kind])


def _generate_module(model: Model, terms: list[ResidualTerm]) -> ModuleType:
    """The module of a model's random forces, lasting errors and residual terms."""
    lines = ['"""Written by bluekoi.explain; not to be edited."""',
             "from bluekoi.integrate.branchless import sin_cos", ""]  # fmt: skip
    pushed = model.force.outputs if model.force is not None else ()
    lines += _ornstein_uhlenbeck_source(RANDOM_FORCE, [f"g_{c}" for c in model.channels],
                       [f"g_{o}" if o in model.channels else "0.0" for o in pushed])  # fmt: skip
    errors = [f"e_{o.name}" for o in model.observations]
    lines += _ornstein_uhlenbeck_source(COLOURED_ERROR, errors, errors)
    if terms and model.force is not None:
        lines += _residual_terms_source(model, terms)
    text = "\n".join(lines) + "\n"
    name = f"bluekoi_terms_{model.name}_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    path = kernel_folder() / f"{name}.py"
    if not path.exists():
        write_text(path, text)
    return load_source(name, path)


def _ornstein_uhlenbeck_source(name: str, states: list[str], outputs: list[str]) -> list[str]:
    """First-order processes x' = -x / tau, each with a memory of its own."""
    if not states or not outputs:
        return []
    memories = [f"tau_{s}" for s in states]
    used = [o for o in outputs if o != "0.0"]
    rates = ", ".join(f"-{s} / {m}" for s, m in zip(states, memories, strict=True))
    return [f"def {name}({', '.join(used)}):", f"    return ({', '.join(outputs)},)", "", "",
            f"def {name}_rates({', '.join([*states, *memories])}):", f"    return ({rates},)",
            "", ""]  # fmt: skip


def _residual_terms_source(model: Model, terms: list[ResidualTerm]) -> list[str]:
    stage = model.force
    assert stage is not None
    variables = residual_term_variables(model)
    angles = {t.variable for t in terms if "sin_cos" in t.expression}
    given = [*variables, *(f"scale_{v}" for v in variables if v not in angles),
             *(t.name for t in terms)]  # fmt: skip
    sums = []
    for o in stage.outputs:
        own = [t for t in terms if t.channel == o]
        text = " + ".join(t.expression.format(k=t.name) for t in own) or "0.0"
        for v in sorted(angles):
            text = text.replace(f"sin_cos({v})[0]", f"sine_{v}")
            text = text.replace(f"sin_cos({v})[1]", f"cosine_{v}")
        sums.append(text)
    turned = [f"    sine_{v}, cosine_{v} = sin_cos({v})" for v in sorted(angles)]
    return [f"def residual({', '.join(given)}):", *turned, f"    return ({', '.join(sums)},)"]


def _random_force_and_error_effects(model: Model, module: ModuleType) -> list[Effect]:
    """Random forces and lasting errors."""
    out = []
    stage = model.force
    parts = [] if stage is None else [
        (RANDOM_FORCE, stage.name, tuple(f"g_{c}" for c in model.channels), model.random_force_s,
         model.channels)]  # fmt: skip
    errors = tuple(f"e_{o.name}" for o in model.observations)
    parts.append((COLOURED_ERROR, OBSERVE_STAGE, errors, model.error_s, ()))
    for name, hook, states, (start, lower, upper), channels in parts:
        memories = tuple(Parameter(f"tau_{s}", "s", start, lower, upper, "correlation time")
                         for s in states)  # fmt: skip
        present = Parameter("present", "1", 1.0, 0.0, 1.0, "1 where it acts")
        out.append(Effect(name, "disturbance", name, (present, *memories),
                          {hook: getattr(module, name)}, module.__name__, channels,
                          states=states, rates=getattr(module, f"{name}_rates")))  # fmt: skip
    return out


def _effect_from_cause(model: Model, cause: Cause) -> Effect:
    first = next(iter(cause.hooks.values()))
    return Effect(
        cause.name,
        cause.kind,
        cause.statement,
        tuple(cause.parameters),
        dict(cause.hooks),
        first.__module__,
        channels_of_cause(model, cause),
        variables_of_cause(model, cause),
        cause.states,
        cause.rates,
        evidence=dict(cause.evidence),
        regime=cause.regime,
        strengths=cause.strengths,
    )


def _effect_from_residual_terms(
    model: Model, module: ModuleType, terms: list[ResidualTerm], force_scale: Mapping[str, float]
) -> Effect:
    def strength(t: ResidualTerm) -> Parameter:
        size = force_scale.get(t.channel, 1.0)
        return Parameter(
            t.name,
            "",
            size,
            -RESIDUAL_STRENGTH_BOUND * size,
            RESIDUAL_STRENGTH_BOUND * size,
            t.variable,
        )

    assert model.force is not None
    return Effect(
        RESIDUAL_EFFECT_KIND,
        RESIDUAL_EFFECT_KIND,
        "A force that no candidate describes.",
        tuple(strength(t) for t in terms),
        {model.force.name: module.residual},
        module.__name__,
        model.channels,
        residual_term_variables(model),
        strengths=len(terms),
    )
