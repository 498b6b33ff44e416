"""Candidate causes: what the finder may add to a model, and what is known of each before any data.

A candidate is an effect of the system, or one term of an effect that has many (`residual.yaw_r`).
Its first parameters are strengths: it is absent where they are 0. The others are its functional
form, with a prior about the leading form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import FreeParameter
from ..fitting.joint_fit import parameter_definition
from ..integrate import Effect, System

RESIDUAL_EFFECT_KIND = "residual"
ChannelVariablePairs = frozenset[tuple[str, str]]


@dataclass(frozen=True)
class CandidateCause:
    """One candidate cause.

    strengths, forms: its parameters. prior: probability of being present, before any data.
    sources: (channel, variable) pairs of the forces that it makes; residual terms that share one
    with a named cause are part of that cause's functional form.
    """

    name: str
    kind: str
    strengths: tuple[FreeParameter, ...]
    forms: tuple[FreeParameter, ...]
    prior: float
    sources: ChannelVariablePairs = frozenset()

    @property
    def strength_and_form_parameters(self) -> tuple[FreeParameter, ...]:
        """Strengths, then forms."""
        return (*self.strengths, *self.forms)

    @property
    def is_residual(self) -> bool:
        """Whether it is a force without a physical statement."""
        return self.kind == RESIDUAL_EFFECT_KIND


@dataclass(frozen=True)
class PriorInclusionProbabilities:
    """Probabilities of presence before any data.

    cause: of each named cause; likely: name -> probability of those that are known to be common;
    unlisted: that any residual term acts.
    """

    cause: float = 0.03
    unlisted: float = 0.10
    likely: Mapping[str, float] | None = None


def candidates_from_effects(
    system: System,
    names: Sequence[str],
    priors: PriorInclusionProbabilities,
    terms: Mapping[str, ChannelVariablePairs] | None = None,
) -> tuple[CandidateCause, ...]:
    """Candidates by effect name; an effect of kind `residual` without forms of its own gives one
    candidate a strength.

    terms: residual term -> channels and variables; those of other candidates are their effects'.
    """
    effects = [system.effect(name) for name in names]
    unlisted = [c for e in effects if e.kind == RESIDUAL_EFFECT_KIND
                for c in _residual_candidates(e, terms or {})]  # fmt: skip
    share = priors.unlisted / max(len(unlisted), 1)
    out = [replace(c, prior=share) for c in unlisted]
    for effect in effects:
        if effect.kind != RESIDUAL_EFFECT_KIND:
            prior = (priors.likely or {}).get(effect.name, priors.cause)
            strengths, forms = _split_strength_and_form_parameters(effect)
            out.append(CandidateCause(effect.name, effect.kind, strengths, forms, prior,
                                 channel_variable_pairs_of_effect(effect)))  # fmt: skip
    return tuple(out)


def _split_strength_and_form_parameters(
    effect: Effect,
) -> tuple[tuple[FreeParameter, ...], tuple[FreeParameter, ...]]:
    labels = [FreeParameter(f"{effect.name}.{p.name}") for p in effect.parameters]
    return tuple(labels[: effect.strengths]), tuple(labels[effect.strengths :])


def _residual_candidates(
    effect: Effect, terms: Mapping[str, ChannelVariablePairs]
) -> list[CandidateCause]:
    """Candidates of a residual effect; their prior is set by how many there are."""
    strengths, forms = _split_strength_and_form_parameters(effect)
    if forms or len(strengths) == 1:
        return [
            CandidateCause(
                effect.name,
                RESIDUAL_EFFECT_KIND,
                strengths,
                forms,
                0.0,
                channel_variable_pairs_of_effect(effect),
            )
        ]
    return [
        CandidateCause(
            s.name,
            RESIDUAL_EFFECT_KIND,
            (s,),
            (),
            0.0,
            terms.get(s.name, channel_variable_pairs_of_effect(effect)),
        )
        for s in strengths
    ]


def channel_variable_pairs_of_effect(effect: Effect) -> ChannelVariablePairs:
    """Pairs of channel and variable of an effect's force."""
    return frozenset((c, v) for c in effect.channels for v in effect.variables)


def strength_difference_step(system: System, free: FreeParameter) -> float:
    """Size of the difference by which a strength is varied about 0."""
    p = parameter_definition(system, free)
    return 1e-3 * max(abs(p.start), 0.01 * (p.upper - p.lower))


def form_prior_precision(system: System, forms: Sequence[FreeParameter]) -> Float:
    """Prior precision (forms,) of functional forms, uniform ones as wide as their bounds."""
    rows = [parameter_definition(system, f) for f in forms]
    uniform = [(p.upper - p.lower) / np.sqrt(12.0) for p in rows]
    return np.array([min(p.spread, u) ** -2.0 for p, u in zip(rows, uniform, strict=True)])


def has_single_sign(system: System, candidate: CandidateCause) -> bool:
    """Whether the strength has one possible sign."""
    if len(candidate.strengths) != 1:
        return False
    p = parameter_definition(system, candidate.strengths[0])
    return p.lower >= 0.0 or p.upper <= 0.0
