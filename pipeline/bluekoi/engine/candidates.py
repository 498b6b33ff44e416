"""Candidate causes: what the finder may add to a model, and what is known of each before any data.

A candidate is an effect of the system, or one term of an effect that has many (`residual.yaw_r`).
Its first parameters are strengths: it is absent where they are 0. The others are its functional
form, with a prior about the leading form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..fitting import Free
from ..integrate import Effect, Parameter, System

RESIDUAL = "residual"
Sources = frozenset[tuple[str, str]]


@dataclass(frozen=True)
class Candidate:
    """One candidate cause.

    strengths, forms: its parameters. prior: probability of being present, before any data.
    sources: (channel, variable) pairs of the forces that it makes; residual terms that share one
    with a named cause are part of that cause's functional form.
    """

    name: str
    kind: str
    strengths: tuple[Free, ...]
    forms: tuple[Free, ...]
    prior: float
    sources: Sources = frozenset()

    @property
    def free(self) -> tuple[Free, ...]:
        """Strengths, then forms."""
        return (*self.strengths, *self.forms)

    @property
    def is_residual(self) -> bool:
        """Whether it is a force without a physical statement."""
        return self.kind == RESIDUAL


@dataclass(frozen=True)
class Priors:
    """Probabilities of presence before any data.

    cause: of each named cause; likely: name -> probability of those that are known to be common;
    unlisted: that any residual term acts.
    """

    cause: float = 0.03
    unlisted: float = 0.10
    likely: Mapping[str, float] | None = None


def candidates_of(
    system: System,
    names: Sequence[str],
    priors: Priors,
    terms: Mapping[str, Sources] | None = None,
) -> tuple[Candidate, ...]:
    """Candidates by effect name; an effect of kind `residual` gives one candidate a strength.

    terms: residual term -> channels and variables; those of other candidates are their effects'.
    """
    residual = [e for e in system.effects if e.kind == RESIDUAL and e.name in names]
    count = sum(e.strengths for e in residual)
    out: list[Candidate] = []
    for name in names:
        effect = system.effect(name)
        labels = [Free(f"{name}.{p.name}") for p in effect.parameters]
        strengths, forms = tuple(labels[: effect.strengths]), tuple(labels[effect.strengths :])
        if effect.kind == RESIDUAL:
            share = priors.unlisted / max(count, 1)
            out += [Candidate(f.name if len(strengths) > 1 else name, RESIDUAL, (f,), forms, share,
                              (terms or {}).get(f.name, sources_of(effect)))
                    for f in strengths]  # fmt: skip
            continue
        prior = (priors.likely or {}).get(name, priors.cause)
        out.append(Candidate(name, effect.kind, strengths, forms, prior, sources_of(effect)))
    return tuple(out)


def sources_of(effect: Effect) -> Sources:
    """Pairs of channel and variable of an effect's force."""
    return frozenset((c, v) for c in effect.channels for v in effect.variables)


def parameter(system: System, free: Free) -> Parameter:
    """The parameter that a free number is a value of."""
    return system.parameters[system.slot[free.name]]


def form_precision(system: System, forms: Sequence[Free]) -> Float:
    """Prior precision (forms,) of functional forms, uniform ones as wide as their bounds."""
    rows = [parameter(system, f) for f in forms]
    uniform = [(p.upper - p.lower) / np.sqrt(12.0) for p in rows]
    return np.array([min(p.spread, u) ** -2.0 for p, u in zip(rows, uniform, strict=True)])


def is_signed(system: System, candidate: Candidate) -> bool:
    """Whether the strength has one possible sign."""
    if len(candidate.strengths) != 1:
        return False
    p = parameter(system, candidate.strengths[0])
    return p.lower >= 0.0 or p.upper <= 0.0
