"""Choice of effects: forward while an addition pays, back where one no longer does, then rivals.

Each model is judged under its own noise, fitted anew: a model
that lacks something takes its lack for noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ..integrate.batch import each
from .bench import Bench
from .forms import formed, own_shapes, shaped, shaped_anyway
from .judge import Trialled, own_numbers
from .paying import WRONG, explains_aside, opens, pays
from .rounds import CONTENDERS, PART_OF_BEST, Round, is_sure, one_round, settled

LEAST_FOR_FORM = 3.0
"""A candidate that gains this much over the inflation in its held form is tried in another."""
OPENINGS = 2
AHEAD = 1.4
"""Two names gain more than one term without a name by their number alone: 1.06 times what the term
did for `sin 4 alpha`, which has none, and twice for a thrust line and a damping beside a fin. Of
more terms two names need only gain as much: 1.07 times what three did for such a pair.
"""
CLOSE = 6.0
"""A rival that in its round was no further behind than this, in held-out log likelihood over the
inflation, or whose law may have another form, is judged again as the chosen effect was: under all
of its own noise, its forms free.
"""
FAR = 50.0
"""An effect this far ahead of all others in a round, in held-out log likelihood over the inflation,
need not be held against them again beside one effect more.
"""
MOST_CAUSES = 4
MOST_ROUNDS = 8


@dataclass(frozen=True)
class Choice:
    """What the search ended with.

    bare: the model without effects; chosen: with those that pay; rounds: how it got there;
    without: chosen effect -> the model without it; places: chosen effect -> the round in which it
    competes for its place beside all the others that are chosen; ahead: chosen effect -> by how
    much the best term without a name does better in its place, in held-out log likelihood over the
    inflation, where one was tried.
    """

    bare: Trialled
    chosen: Trialled
    rounds: tuple[Round, ...]
    without: Mapping[str, Trialled]
    places: Mapping[str, Round]
    ahead: Mapping[str, float] = field(default_factory=dict)


def choose(bench: Bench, bare: Trialled) -> Choice:
    """Forward and back until nothing changes, then every chosen effect against its rivals."""
    bare = current = settled(bench, bare, bare)
    rounds: list[Round] = []
    seen: set[frozenset[str]] = set()
    without: dict[str, Trialled] = {}
    while len(rounds) < MOST_ROUNDS:
        done = one_round(bench, current, bare)
        rounds.append(done)
        if len(current.effects) >= MOST_CAUSES:
            break
        best = done.best
        if best.effects == current.effects:
            best = in_another_form(bench, done, bare) or best
        if best.effects == current.effects and (free := shaped_anyway(bench, current)):
            current, without = pruned(bench, free, bare)
            if current.effects == free.effects:
                continue
            break
        if best.effects == current.effects:
            both = two_at_once(bench, done, bare) if done.before.inflation >= WRONG else None
            if not both:
                break
            rounds.append(both[0])
            current, without = both[1:]
        else:
            current, without = pruned(bench, shaped(bench, bench.renoised(best)), bare)
        if frozenset(current.effects) in seen:
            break
        seen.add(frozenset(current.effects))
    return _against_rivals(bench, Choice(bare, current, tuple(rounds), without, {}))


def two_more(bench: Bench, choice: Choice, unnamed: Trialled) -> Choice:
    """Choice with two further causes that together gain what several terms without a name,
    `unnamed`, do, or `AHEAD` times what one does, where neither pays alone; else as it was.
    """
    if len(choice.chosen.effects) + 2 > MOST_CAUSES:
        return choice
    chosen = choice.chosen
    beside = [r for r in choice.rounds if set(r.before.effects) == set(chosen.effects)]
    done = beside[-1] if beside else one_round(bench, chosen, choice.bare)
    both = two_at_once(bench, done, choice.bare)
    if not both:
        return choice
    done, model, without = both
    before, terms = bench.renoised(chosen).total, bench.renoised(unnamed).total
    ahead = AHEAD if len(unnamed.effects) == len(chosen.effects) + 1 else 1.0
    if not model.total >= before + ahead * (terms - before):
        return choice
    rounds = (*choice.rounds, done)
    return _against_rivals(bench, Choice(choice.bare, model, rounds, without, {}))


def _against_rivals(bench: Bench, choice: Choice) -> Choice:
    """Choice with every effect held against its rivals; one that another outdoes makes room."""
    bare, current, rounds, without = choice.bare, choice.chosen, list(choice.rounds), choice.without
    places = places_of(bench, current, without, bare, rounds)
    for _ in range(MOST_CAUSES):
        outdone = [e for e in current.effects if _outdone(e, places[e], current)]
        if not outdone:
            break
        rounds.append(places[outdone[0]])
        current, without = pruned(bench, _instead(places[outdone[0]], current), bare)
        places = places_of(bench, current, without, bare, rounds)
    return Choice(bare, current, tuple(rounds), without, places)


def in_another_form(bench: Bench, done: Round, bare: Trialled) -> Trialled | None:
    """Where nothing pays: a candidate that pays once its form is free, nature's law being another.

    Of those that gained most and are not likely nothing, the first that does.
    """
    for one in done.tried[:CONTENDERS]:
        held = own_shapes(bench.kernel, one)
        gain = (one.total - done.before.total) / one.inflation
        if held and gain > LEAST_FOR_FORM and is_sure(one):
            free = formed(bench, one, held)
            if np.isfinite(free.total) and pays(done.before, free, bare):
                return free
    return None


def two_at_once(
    bench: Bench, done: Round, bare: Trialled
) -> tuple[Round, Trialled, dict[str, Trialled]] | None:
    """Where a wrong model gains by no single effect: two of which each pays beside the other.

    One of the best of the round is taken on trust, and so is what gains most beside it: only both
    together, under noise of their own, show whether either is sure. The round of the second,
    the model, and what it is without each of its effects.
    """
    for opening in done.tried[:OPENINGS]:
        if not np.isfinite(opening.total):
            continue
        second = one_round(bench, opening, bare)
        if not (second.tried and second.tried[0].total > opening.total):
            continue
        model = shaped(bench, bench.renoised(second.tried[0]))
        less = each(partial(bench.less, model, bare=bare), [[e] for e in model.effects])
        if all(np.isfinite(t.total) and (pays(t, model, bare) or opens(t, model)) for t in less):
            return second, model, dict(zip(model.effects, less, strict=True))
    return None


def _outdone(name: str, place: Round, chosen: Trialled) -> bool:
    """Whether a rival does clearly better than the chosen effect in its place, one whose strength
    is not likely nothing; one that pays, of fewer numbers, need not be better clearly.
    """
    own = own_numbers(chosen.fit.free, name).sum()

    def better(rival: Trialled) -> bool:
        fewer = own_numbers(rival.fit.free, rival.effects[-1]).sum() < own
        simpler = fewer and pays(place.before, rival, place.bare)
        return rival.total > chosen.total + (0.0 if simpler else chosen.inflation)

    rivals = [t for t in place.tried if t.effects[-1] not in chosen.effects and is_sure(t)
              and explains_aside(t, chosen, place.before)]  # fmt: skip
    return any(better(t) for t in rivals)


def in_place(choice: Choice, name: str) -> dict[str, float]:
    """Held-out log likelihood of a chosen effect and of its rivals for its place."""
    chosen = choice.chosen
    rivals = {
        t.effects[-1]: fairly(t, chosen)
        for t in choice.places[name].tried
        if t.effects[-1] not in chosen.effects and np.isfinite(t.total)
        and explains_aside(t, chosen, choice.without[name])
    }  # fmt: skip
    return {**rivals, name: chosen.total}


def fairly(rival: Trialled, chosen: Trialled) -> float:
    """Held-out log likelihood of a rival. One whose strength may be nothing is worth as much as the
    chosen effect at most, however well it does.
    """
    return rival.total if is_sure(rival) else min(rival.total, chosen.total)


def _instead(place: Round, chosen: Trialled) -> Trialled:
    """The rival, where it pays by itself; else nothing: a name that another outdoes is none."""
    best = place.best
    return place.before if set(best.effects) == set(chosen.effects) else best


def pruned(bench: Bench, model: Trialled, bare: Trialled) -> tuple[Trialled, dict[str, Trialled]]:
    """A model without the effects that no longer pay, and what it is without each of the rest."""
    while True:
        names, less = model.effects, partial(bench.less, model, bare=bare)
        without = dict(zip(names, each(less, [[e] for e in names]), strict=True))
        idle = [e for e in model.effects[:-1]
                if np.isfinite(without[e].total) and not pays(without[e], model, bare)]  # fmt: skip
        if not idle:
            return model, without
        model = max((without[e] for e in idle), key=lambda t: t.total)


def places_of(
    bench: Bench, chosen: Trialled, without: Mapping[str, Trialled], bare: Trialled,
    rounds: Sequence[Round],
) -> dict[str, Round]:  # fmt: skip
    """Chosen effect -> the round in which it competes beside the others: an old one or a new.

    An old one, too, in which fewer stood beside it and no other came near it.
    """
    before = {frozenset(r.before.effects): r for r in reversed(rounds)}
    found: dict[str, Round] = {}
    for e in chosen.effects:
        ahead = _far_ahead(e, without[e], rounds)
        same = before.get(frozenset(without[e].effects))
        found[e] = ahead or _level(bench, e, same or one_round(bench, without[e], bare), chosen)
    return found


def _far_ahead(name: str, without: Trialled, rounds: Sequence[Round]) -> Round | None:
    """The last round beside some of a model's effects that one effect won by `FAR`."""
    for done in reversed(rounds):
        own = next((t for t in done.tried if t.effects[-1] == name), None)
        if own is None or not set(done.before.effects) <= set(without.effects):
            continue
        others = [t.total for t in done.tried if t.effects[-1] not in (name, *without.effects)]
        if own.total - max(others, default=done.before.total) > FAR * own.inflation:
            return done
    return None


def _level(bench: Bench, name: str, place: Round, chosen: Trialled) -> Round:
    """A place whose close rivals are judged as the chosen effect: under all of their own noise.

    Within the round both stood under noise that the model before had left to them; what the one
    gains by noise of its own must not speak against the other.
    """
    own = next((t for t in place.tried if t.effects[-1] == name), None)
    if own is None or not np.isfinite(own.total):
        return place
    near = own.total - CLOSE * own.inflation
    part = place.before.total + PART_OF_BEST * (own.total - place.before.total)
    close = [t for t in place.tried
             if t.effects[-1] not in chosen.effects and t.total < chosen.total
             and t.total > (min(near, part) if own_shapes(bench.kernel, t) else near)]  # fmt: skip
    again = dict(zip((t.effects for t in close), each(partial(anew, bench), close), strict=True))
    tried = (max(t, again.get(t.effects, t), key=lambda one: one.total) for t in place.tried)
    return replace(place, tried=tuple(sorted(tried, key=lambda t: -t.total)))


def anew(bench: Bench, model: Trialled) -> Trialled:
    """A model under all of its own noise, its forms free where that pays."""
    found = shaped(bench, bench.renoised(model))
    return found if np.isfinite(found.total) else model
