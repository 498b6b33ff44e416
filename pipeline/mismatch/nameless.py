"""Terms without a name beside the named causes: what they tell of, and which names they refute."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from .bench import Bench
from .forms import formed
from .judge import Trialled
from .paying import TOLD_ASIDE, pays
from .rounds import Round, one_round
from .search import held_shapes
from .select import Choice, anew, fairly, in_place, places_of
from .weighing import beside_nameless, reliability, told_aside, weights

TELLING_SHARE = 0.3
LEAST_PART = 0.1
LEAST_NAMELESS = 5.0
"""Nameless terms tell of something unexplained where they turn this share of the variance that
looked random in a channel into law, and gain this part of what the strongest of the named causes
gains (and over the inflation not less than the last number): a named law in another form than
nature's leaves less. Where nothing has a name the p value tells, whatever was random before: a
faint force may pass for the water's.
"""
PLAIN, PLAIN_SHARE, PLAIN_CHANCE = 15.0, 0.5, 2e-6
"""So they do where they gain this much over the inflation, make law of this share, and the surest
of them has no larger p value, whatever the strongest named cause gains: beside a strong fin little
else is a tenth of it. Lasting errors of a detector, 0.2 mm of path, passed for a force without the
p value.
"""
ALONE_CHANCE, ALONE_MUCH, MUCH_CHANCE = 1e-6, 20.0, 1e-5
"""Where nothing has a name, the surest of them must have no larger p value, or gain this much over
the inflation with this one: fifty are tried. In seven concealed studies of forces outside the list
it was at most 2e-7, in one 2e-6 with a gain of 41; in 85 nulls 4e-6, with a gain of 6.
"""
BESIDE_CHANCE = 1e-3
"""Beside named causes the surest of them must have no larger p value: in nine trials swings that
are none gained 17 and 15 over the inflation (9e-4 and 0.09, not yet times `SWINGS`).
"""
SWING, PULSE, HUMP = "sloshing", "surging", "hump"
HUMP_PLACES, SWINGS = 50.0, 10.0
"""A hump's place and width are chosen where they do best: in noise its p value is 25 to 50 times
too small (best of all places and widths, by simulation). So is a swing's frequency: some ten of
them are independent in a trial of 7 s. Where the trials left out gain as much as is asked for a
large gain, no choice of a place has made it: of 282 concealed studies humps that are none gained 16
over the inflation at most (p = 0.03), the six that are 22 and more (five 7e-7 and less).
"""
MOST_TERMS = 4
CONTESTED = 4
CROWD = 3
"""Causes, of which all but the strongest may stand in for one term: beside a fin crossflow drag and
added mass, 0.94 and 0.99 sure, for the jet of the tail that a turned head bends.
"""
WEAK = 60.0
CLEARLY = 5.0
CLEARLY_PART = 0.15
"""A named cause that gains less than `WEAK` over the inflation must not be outdone by one nameless
term: by `CLEARLY` over the inflation and by this part of its own gain.
"""
DOUBTFUL, LEAST_WEIGHT = 0.3, 0.1
"""Beside other causes one of less weight than the first goes where another is likelier in its
place, one of less than the second anyway; and so does one less likely than none of all candidates.
"""


def nameless(bench: Bench, model: Trialled, bare: Trialled, *, most: int = MOST_TERMS) -> Trialled:
    """A model with the fewest nameless terms that pay beside its effects, one after the other."""
    terms = terms_of(bench)
    for _ in range(most):
        done: Round = one_round(terms, model, bare, tried=CONTESTED)
        if done.best.effects == model.effects:
            break
        model = done.best
    return model


def terms_of(bench: Bench) -> Bench:
    """The bench with all nameless terms, one by one, as candidates."""
    effect = bench.kernel.system.effect("residual")
    terms = tuple(f"residual.{p.name}" for p in effect.parameters)
    return replace(bench, candidates=(*terms, SWING, PULSE, HUMP))


def not_a_crowd(bench: Bench, choice: Choice) -> Choice:
    """Choice with the strongest cause alone where beside it one term without a name does better
    than all the other names together: they had shared its work among them.
    """
    chosen = choice.chosen
    if len(chosen.effects) < CROWD:
        return choice
    weak = sorted(chosen.effects, key=lambda e: choice.without[e].total)[1:]
    if any(chosen.side - choice.without[e].side > TOLD_ASIDE for e in weak):
        return choice
    bench.progress(f"terms without a name in place of {', '.join(weak)}")
    strongest = bench.less(chosen, weak, choice.bare)
    one = anew(bench, one_round(terms_of(bench), strongest, choice.bare, tried=CONTESTED).best)
    if not (one.effects != strongest.effects and one.total > chosen.total + one.inflation):
        return choice
    alone = dropped(bench, choice, weak)
    return alone if tells(alone, one) else choice


def not_outdone(bench: Bench, choice: Choice) -> Choice:
    """Choice without the weaker causes in whose place one nameless term does clearly better; of the
    others it tells how far one is ahead. No force without a name explains a side measurement.
    """
    for name in choice.chosen.effects:
        chosen, before = choice.chosen, choice.without[name]
        gain = chosen.total - before.total
        told = chosen.side - before.side > TOLD_ASIDE
        if told or gain > WEAK * chosen.inflation:
            continue
        bench.progress(f"terms without a name in place of {name}")
        tried = one_round(terms_of(bench), before, choice.bare, tried=CONTESTED)
        if tried.best.total - chosen.total > max(CLEARLY * chosen.inflation, CLEARLY_PART * gain):
            choice = dropped(bench, choice, [name])
            continue
        best = max((fairly(t, chosen) for t in tried.tried), default=-np.inf)
        ahead = (best - chosen.total) / chosen.inflation
        choice = replace(choice, ahead={**choice.ahead, name: ahead})
    return choice


def without_doubtful(bench: Bench, choice: Choice) -> Choice:
    """Choice without the causes beside others that are more likely something else, or nothing; one
    that stands alone goes where it is more likely nothing.
    """
    for _ in choice.chosen.effects[1:]:
        told = {name: shares_in_place(choice, name) for name in choice.chosen.effects}
        doubtful = [name for name in told if _is_doubtful(told[name], name)]
        if not doubtful:
            break
        choice = dropped(bench, choice, [min(doubtful, key=lambda e: told[e][e])])
    alone = choice.chosen.effects if len(choice.chosen.effects) == 1 else ()
    idle = [e for e in alone if _is_likelier_nothing(shares_in_place(choice, e), e)]
    return dropped(bench, choice, idle)


def _is_doubtful(shares: Mapping[str, float], name: str) -> bool:
    """Whether a further cause is more likely something else in its place, or nothing."""
    own, others = shares[name], [share for e, share in shares.items() if e != name]
    likeliest = own > LEAST_WEIGHT and own >= max(others, default=0.0)
    return _is_likelier_nothing(shares, name) or not (own > DOUBTFUL or likeliest)


def _is_likelier_nothing(shares: Mapping[str, float], name: str) -> bool:
    """Whether a cause is less likely than none of all candidates."""
    return shares[name] < 1.0 - sum(shares.values())


def shares_in_place(choice: Choice, name: str, *, beside: bool = True) -> dict[str, float]:
    """A chosen effect and its rivals for its place -> weights; what they lack of 1 is left for a
    cause that is no candidate.

    beside: a force without a name is a rival as well, where one was tried.
    """
    chosen, without = choice.chosen, choice.without[name]
    paths = reliability((chosen.total - without.total) / chosen.inflation)
    sure = max(paths, told_aside(chosen.side - without.side))
    shares = weights(in_place(choice, name), chosen.inflation)
    if beside:
        shares = beside_nameless(shares, name, choice.ahead.get(name, -np.inf))
    return {other: sure * share for other, share in shares.items()}


def without_proxies(bench: Bench, choice: Choice, residual: Trialled) -> tuple[Choice, Trialled]:
    """Choice and nameless model without the named causes that one more nameless term replaces.

    Where something has no name, a candidate may have been picked up in its place: it stays only if
    it pays beside the nameless terms as well. The weakest is tried first.
    """
    idle: list[str] = []
    for name in sorted(
        choice.chosen.effects, key=lambda e: choice.chosen.total - choice.without[e].total
    ):
        bench.progress(f"{name} beside terms without a name")
        bare = nameless(bench, bench.less(residual, [name], choice.bare), choice.bare, most=1)
        if not pays(bare, residual, choice.bare):
            residual = bare
            idle.append(name)
    return dropped(bench, choice, idle), residual


def dropped(bench: Bench, choice: Choice, names: Sequence[str]) -> Choice:
    """Choice without some of its effects: the rest refitted under all of its own noise, and each
    against its rivals anew.
    """
    if not names:
        return choice
    kept = [e for e in choice.chosen.effects if e not in names]
    if not kept:
        return replace(choice, chosen=choice.bare, without={}, places={})
    less = bench.less(choice.chosen, names, choice.bare)
    again = bench.renoised(less)
    chosen = again if np.isfinite(again.total) else less
    without = {e: bench.less(chosen, [e], choice.bare) for e in kept}
    places = places_of(bench, chosen, without, choice.bare, choice.rounds)
    return replace(choice, chosen=chosen, without=without, places=places)


def tells(choice: Choice, residual: Trialled) -> bool:
    """Whether nameless terms beside the chosen effects tell of something more than their form."""
    chosen = choice.chosen
    if residual.effects == chosen.effects:
        return False
    gain = residual.total - chosen.total
    named = max((chosen.total - m.total for m in choice.without.values()), default=0.0)
    law = foretold_randomness(chosen, residual)
    added = {e: p for e, p in residual.p_value.items() if e not in chosen.effects}
    chance = _surest(added, {HUMP: HUMP_PLACES, SWING: SWINGS})
    plain_chance = _surest(added, {SWING: SWINGS})
    much = gain > ALONE_MUCH * residual.inflation
    alone = chance < ALONE_CHANCE or (much and plain_chance < MUCH_CHANCE)
    if not (chance < BESIDE_CHANCE if chosen.effects else alone):
        return False
    if gain > PLAIN * residual.inflation and law > PLAIN_SHARE and plain_chance < PLAIN_CHANCE:
        return True
    enough = gain > max(LEAST_NAMELESS * residual.inflation, LEAST_PART * named)
    return enough and (law > TELLING_SHARE or not chosen.effects)


def _surest(p_values: Mapping[str, float], times: Mapping[str, float]) -> float:
    """The least p value, each times the number of places that its term was tried at."""
    return min(p * times.get(e, 1.0) for e, p in p_values.items())


def only_form(bench: Bench, choice: Choice) -> bool:
    """Whether nameless terms tell of nothing more once the forms of the named causes are free: what
    they told of was a law in another form than the candidate's.
    """
    held = held_shapes(bench.kernel, choice.chosen)
    if not held:
        return False
    free = formed(bench, choice.chosen, held)
    if not np.isfinite(free.total) or free.total <= choice.chosen.total:
        return False
    return not tells(replace(choice, chosen=free), nameless(bench, free, choice.bare))


def nameless_gain(choice: Choice, residual: Trialled) -> float:
    """Held-out log likelihood over the inflation that nameless terms gain beside the chosen."""
    return (residual.total - choice.chosen.total) / residual.inflation


def foretold_randomness(before: Trialled, after: Trialled) -> float:
    """Largest share of a random state's variance that a larger model has turned into law."""
    old, new = (m.noise.disturbance for m in (before, after))
    return float(np.max(1.0 - (new / np.maximum(old, 1e-12))[old > 0] ** 2, initial=0.0))
