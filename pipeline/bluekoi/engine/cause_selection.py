"""Named causes and their alternatives, from the posterior over sets of causes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from .calibration import calibrated_probability
from .candidates import CandidateCause
from .cause_set_fit import FittedCauseSet
from .named_cause import CREDIBLE_SET_PROBABILITY, NamedCause
from .posterior import Posterior
from .set_score import ScoredCauseSet
from .significance import insignificant_causes, strength_estimates

MIN_NAMED_PROBABILITY = 0.5
"""A cause is named where it is more probable than not (the median probability model: Barbieri and
Berger, Ann. Statist. 32 (2004), 870)."""
UNLISTED_FORCE_LABEL = "unexplained"
ReportedModel = TypeVar("ReportedModel")


@dataclass(frozen=True)
class ChosenCauses(Generic[ReportedModel]):
    """named: probable causes with a significant strength, in the order of the most probable set;
    insignificant: the other probable causes. unexplained: calibrated probability of a force that no
    candidate describes. best: the most probable set of the named causes; model: that set as it is
    reported.
    """

    named: list[NamedCause]
    insignificant: list[NamedCause]
    unexplained: float
    best: ScoredCauseSet
    model: ReportedModel


def named_causes(
    found: Posterior, candidates: Mapping[str, CandidateCause]
) -> tuple[list[NamedCause], float]:
    """Causes that are probably there, and the posterior probability of an unlisted force.

    A place of the most probable set has the name of the most probable cause that may fill it: where
    that one is more probable than not, or where one of them acts with `CREDIBLE_SET_PROBABILITY`.
    """
    residual = {n for n, c in candidates.items() if c.is_residual}
    pairs = list(zip(found.sets, found.probability, strict=True))
    unexplained = min(1.0, float(sum(p for s, p in pairs if residual & set(s.causes))))
    best, out = found.best, list[NamedCause]()
    for name in (c for c in best.causes if c not in residual):
        place = _alternatives_to_cause(found, name)
        taken = float(sum(p for s, p in pairs if s.model.key & place.keys()))
        listed = {n: q for n, q in place.items() if n not in residual}
        unlisted = sum(q for n, q in place.items() if n in residual)
        if not listed or unlisted > MIN_NAMED_PROBABILITY:
            continue
        leader = max(listed, key=lambda n: found.inclusion[n])
        if leader in {c.name for c in out}:
            continue
        if found.inclusion[leader] > MIN_NAMED_PROBABILITY or taken > CREDIBLE_SET_PROBABILITY:
            others = {n: q for n, q in listed.items() if n != leader}
            others |= {UNLISTED_FORCE_LABEL: unlisted} if unlisted > 0.0 else {}
            out.append(NamedCause(leader, found.inclusion[leader], others))
    names = {c.name for c in out}
    out += [NamedCause(n, q, {}) for n, q in found.inclusion.items()
            if q > MIN_NAMED_PROBABILITY and n not in names and n not in residual]  # fmt: skip
    return out, unexplained


def _alternatives_to_cause(found: Posterior, name: str) -> dict[str, float]:
    """The causes that fill a place of the most probable set, with their probabilities."""
    rest = frozenset(found.best.causes) - {name}
    place = {name: found.inclusion[name]}
    for s, p in zip(found.sets, found.probability, strict=True):
        new = s.model.key - rest - {name}
        if name not in s.model.key and len(new) == 1 and rest <= s.model.key:
            (other,) = new
            place[other] = place.get(other, 0.0) + float(p)
    return place


def most_probable_set_with_causes(
    found: Posterior,
    named: Sequence[str],
    unexplained: bool,
    candidates: Mapping[str, CandidateCause],
) -> ScoredCauseSet:
    """The most probable set with just these named causes, with a residual term where asked for."""
    residual = {n for n, c in candidates.items() if c.is_residual}

    def fits(s: ScoredCauseSet) -> bool:
        own = set(s.causes)
        return set(named) == own - residual and bool(own & residual) == unexplained

    pairs = sorted(zip(found.probability, found.sets, strict=True), key=lambda x: -x[0])
    return next((s for _, s in pairs if fits(s)), found.best)


def choose_causes(
    found: Posterior, candidates: Mapping[str, CandidateCause],
    fit: Callable[[ScoredCauseSet], tuple[ReportedModel, FittedCauseSet]],
) -> ChosenCauses[ReportedModel]:  # fmt: skip
    """`ChosenCauses` of a posterior.

    fit: the model of a set as it is reported, and the fit that its strengths are judged by.
    """
    named, unexplained = named_causes(found, candidates)
    left_out: list[NamedCause] = []
    while True:
        names = [c.name for c in named]
        best = most_probable_set_with_causes(
            found, names, unexplained > MIN_NAMED_PROBABILITY, candidates
        )
        model, fitted = fit(best)
        insignificant = insignificant_causes(
            named, candidates, strength_estimates(fitted, candidates)
        )
        if not insignificant:
            stated = calibrated_probability(unexplained)
            return ChosenCauses(named, left_out, stated, best, model)
        left_out += insignificant
        named = [c for c in named if c not in insignificant]


def log_evidence_gain(sets: Sequence[ScoredCauseSet], best: ScoredCauseSet, name: str) -> float:
    """Log evidence that a set loses without one of its causes, that one or with others in its
    place; infinite where no set lacks it.
    """
    less = best.model.key - {name}
    without = [s.log_posterior for s in sets if s.model.key == less]
    without = without or [s.log_posterior for s in sets if name not in s.model.key]
    return best.log_posterior - max(without, default=float("-inf"))
