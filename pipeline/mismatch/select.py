"""Choice of effects: forward while an addition pays, back where one no longer does, then rivals.

An addition pays where the trials it was not fitted to gain clearly by it, and where its strength
is sure when trials are left out. Each model is judged under its own noise, fitted anew: a model
that lacks something takes its lack for noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..fitting import Filtered, filter_all
from ..integrate import Kernel
from ..integrate.batch import each
from .bench import Bench
from .judge import Trialled, candidate_frees
from .search import Foretold, held_shapes, screened

CLAIMS = (
    (1.0, 1e-9, 0.0), (12.0, 1e-5, 0.0),
    (1.0, 1e-5, 0.05), (2.0, 2e-4, 0.05), (10.0, 1e-3, 0.05), (30.0, 5e-3, 0.3),
)  # fmt: skip
"""Least held-out log likelihood over the inflation, the largest p value that goes with it, and the
least part of what all effects together gain. About 30 candidates are tried, so that chance alone
shows one of p = 2e-4 in one study of 150, but without a gain. Few trials leave more to chance,
which a large gain makes up for. What a strong effect of another form than nature's leaves over is
small beside it, and any candidate may pick it up: it must be surer, or gain much by itself.
"""
TOLD_ASIDE = 6.0
"""A side measurement (rigid lengths, the tail beat) that an effect makes this much likelier, 3.5
deviations, speaks for it by itself: no misfit of the paths can feign it.
"""
LEAST_FOR_SHAPE = 2.0
MOST_INFLATED, MUCH = 4.0, 0.2
"""An addition that spreads the numbers over trials this many times more than before explains
nothing: it bends the model to single trials. Unless it gains this part of all: then it is wrong in
form, which comes next.
"""
TRIED = 6
CONTENDERS = 3
PART_OF_BEST = 0.3
"""Of those that gained at least this part of the best's gain so many are settled."""
MOST_CAUSES = 4
MOST_ROUNDS = 8


@dataclass(frozen=True)
class Round:
    """One round: the model it started from, the gains foretold, the candidates refitted with it.

    bare: the model without effects; tried: best first; each has one effect more than `before`.
    """

    bare: Trialled
    before: Trialled
    foretold: Mapping[str, float]
    tried: tuple[Trialled, ...]

    @property
    def best(self) -> Trialled:
        """What paid most; the start of the round where nothing pays."""
        paying = [t for t in self.tried if pays(self.before, t, self.bare)]
        return max(paying, key=lambda t: t.total, default=self.before)


@dataclass(frozen=True)
class Choice:
    """What the search ended with.

    bare: the model without effects; chosen: with those that pay; rounds: how it got there;
    without: chosen effect -> the model without it; places: chosen effect -> the round in which it
    competes for its place beside all the others that are chosen.
    """

    bare: Trialled
    chosen: Trialled
    rounds: tuple[Round, ...]
    without: Mapping[str, Trialled]
    places: Mapping[str, Round]


def choose(bench: Bench, bare: Trialled) -> Choice:
    """Forward and back until nothing changes, then every chosen effect against its rivals."""
    bare = current = bench.settled(bare)
    rounds: list[Round] = []
    seen: set[frozenset[str]] = set()
    without: dict[str, Trialled] = {}
    while len(rounds) < MOST_ROUNDS:
        done = one_round(bench, current, bare)
        rounds.append(done)
        if done.best.effects == current.effects or len(current.effects) >= MOST_CAUSES:
            break
        current, without = pruned(bench, shaped(bench, bench.renoised(done.best)), bare)
        if frozenset(current.effects) in seen:
            break
        seen.add(frozenset(current.effects))
    places = _places(bench, current, without, bare, rounds)
    for _ in range(MOST_CAUSES):
        outdone = [e for e in current.effects if _outdone(places[e], current)]
        if not outdone:
            break
        rounds.append(places[outdone[0]])
        current, without = pruned(bench, _instead(places[outdone[0]], current), bare)
        places = _places(bench, current, without, bare, rounds)
    return Choice(bare, current, tuple(rounds), without, places)


def _outdone(place: Round, chosen: Trialled) -> bool:
    """Whether a rival does clearly better than the chosen effect in its place."""
    rivals = [t.total for t in place.tried if t.effects[-1] not in chosen.effects]
    return max(rivals, default=-np.inf) > chosen.total + chosen.inflation


def _instead(place: Round, chosen: Trialled) -> Trialled:
    """The rival, where it pays by itself; else nothing: a name that another outdoes is none."""
    best = place.best
    return place.before if set(best.effects) == set(chosen.effects) else best


def one_round(bench: Bench, before: Trialled, bare: Trialled, *, tried: int = TRIED) -> Round:
    """All candidates screened, the most promising refitted, the best of these settled."""
    kernel, series = bench.kernel, bench.series
    predictor = filter_all(kernel, series, bench.points(before), before.noise)
    left = [c for c in bench.candidates if c not in before.effects]
    told = screened(kernel, series, before, bench.base, left, predictor=predictor)
    names = _promising(kernel, told, tried)
    bench.progress(f"refits with {', '.join(names)}")
    found = each(lambda name: _refit(bench, before, name, told[name], predictor), names)
    found.sort(key=lambda t: -t.total)
    least = before.total + PART_OF_BEST * max(found[0].total - before.total, 0.0)
    best = each(bench.settled, [t for t in found[:CONTENDERS] if t.total > least])
    ordered = sorted([*best, *found[len(best) :]], key=lambda t: -t.total)
    return Round(bare, before, {c: f.gain for c, f in told.items()}, tuple(ordered))


def _refit(
    bench: Bench, before: Trialled, name: str, told: Foretold, predictor: Sequence[Filtered]
) -> Trialled:
    start = {**before.fit.by_label(), **(told.start if told.gain > 0 else {})}
    found = bench.refit((*before.effects, name), before, start, predictor)
    if np.isfinite(found.total) or told.gain <= 0:
        return found
    return bench.refit((*before.effects, name), before, predictor=predictor)


def _promising(kernel: Kernel, told: Mapping[str, Foretold], count: int) -> list[str]:
    """The best foretold, and those with a shape: a step at strength 0 foretells these badly."""
    ranked = sorted(told, key=lambda c: -told[c].gain)
    best = [c for c in ranked[:count] if told[c].gain > 0]
    shaped = [c for c in ranked if _has_shape(kernel, c) and c not in best
              and np.isfinite(told[c].gain)]  # fmt: skip
    return best + shaped


def _has_shape(kernel: Kernel, name: str) -> bool:
    frees, strengths = candidate_frees(kernel.system, name)
    return len(frees) > strengths


def shaped(bench: Bench, model: Trialled) -> Trialled:
    """A model with the shapes of its effects free, where that pays: a law may have another form
    than the candidate's, and what that leaves over must not pass for a further cause.
    """
    held = held_shapes(bench.kernel, model)
    if not held:
        return model
    bench.progress(f"form of {', '.join(model.effects)}")
    free = bench.settled(bench.refit(model.effects, model, {**model.fit.by_label(), **held}))
    gain = (free.total - model.total) / free.inflation
    return free if gain > LEAST_FOR_SHAPE and free.inflation <= 2 * model.inflation else model


def pruned(bench: Bench, model: Trialled, bare: Trialled) -> tuple[Trialled, dict[str, Trialled]]:
    """A model without the effects that no longer pay, and what it is without each of the rest."""
    while True:
        names, less = model.effects, partial(bench.less, model)
        without = dict(zip(names, each(less, [[e] for e in names]), strict=True))
        idle = [e for e in model.effects[:-1]
                if np.isfinite(without[e].total) and not pays(without[e], model, bare)]  # fmt: skip
        if not idle:
            return model, without
        model = max((without[e] for e in idle), key=lambda t: t.total)


def _places(
    bench: Bench, chosen: Trialled, without: Mapping[str, Trialled], bare: Trialled,
    rounds: Sequence[Round],
) -> dict[str, Round]:  # fmt: skip
    """Chosen effect -> the round in which it competes beside the others: an old one or a new."""
    before = {frozenset(r.before.effects): r for r in reversed(rounds)}
    return {
        e: before.get(frozenset(without[e].effects)) or one_round(bench, without[e], bare)
        for e in chosen.effects
    }


def pays(before: Trialled, after: Trialled, bare: Trialled | None = None) -> bool:
    """Whether the held-out gain is clear and the new effects' strengths are sure.

    bare: the model without effects, from which the gain of all effects together is counted.
    """
    gain = after.total - before.total
    if after.side - before.side > TOLD_ASIDE and gain > 0:
        return True
    part = gain / max(after.total - (bare or before).total, 1e-9)
    p_value = max((after.p_value[e] for e in after.effects if e not in before.effects), default=0.0)
    if after.inflation > MOST_INFLATED * before.inflation and part < MUCH:
        return False
    return any(
        gain / after.inflation > least and p_value < most and part > share
        for least, most, share in CLAIMS
    )
