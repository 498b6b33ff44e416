"""One round of the search: every candidate beside what a model has already."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..fitting import Passes, filter_all
from ..integrate import Kernel
from ..integrate.batch import each
from .bench import Bench
from .judge import Trialled, candidate_frees
from .paying import TOLD_ASIDE, WRONG, pays
from .search import Foretold, likeliest_start, starts_of

TRIED = 6
CONTENDERS = 3
PART_OF_BEST = 0.3
"""Of those that gained at least this part of the best's gain so many are settled, and every one
further that would stand above them. Beside a wrong model so is the one that was foretold most:
under noise that passes what is missing for chance a fold left out may tell against the truth.
"""
HOPELESS, ANYWAY = 0.5, 2
"""A candidate of which a step foretells less than this over the inflation is not refitted, unless
it is one of the first so many, of which a rival and the next trial are told: of 800 refits of less,
in 130 concealed studies, none has paid.
"""
UNLIKELY = 0.01


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
        """What paid most; the start of the round where nothing pays. Of causes level with it that
        side measurements tell as well, the surest by its paths.
        """
        paying = [t for t in self.tried if pays(self.before, t, self.bare)]
        best = max(paying, key=lambda t: t.total, default=self.before)
        told = [t for t in paying if t.side - self.before.side > TOLD_ASIDE
                and t.total > best.total - best.inflation]  # fmt: skip
        return min(told, key=lambda t: t.p_value[t.effects[-1]]) if best in told else best


def is_sure(model: Trialled) -> bool:
    """Whether the strength of the effect added last is not likely nothing."""
    return model.p_value[model.effects[-1]] < UNLIKELY


def one_round(bench: Bench, before: Trialled, bare: Trialled, *, tried: int = TRIED) -> Round:
    """All candidates screened, the most promising refitted, the best of these settled."""
    kernel, series = bench.kernel, bench.series
    predictor = filter_all(kernel, series, bench.points(before), before.noise)
    left = [c for c in bench.candidates if c not in before.effects]
    told = bench.foretold(before, left, predictor)
    names = promising(kernel, told, tried, before.inflation)
    bench.progress(f"refits with {', '.join(names)}")
    longest_first = sorted(names, key=lambda c: -len(candidate_frees(kernel.system, c)[0]))
    found = each(lambda name: _refit(bench, before, name, told[name], predictor), longest_first)
    hopeful = {c for c in names[:1] if before.inflation > WRONG and told[c].gain > 0}
    ordered = _best_settled(bench, before, found, hopeful)
    return Round(bare, before, {c: f.gain for c, f in told.items()}, tuple(ordered))


def _best_settled(
    bench: Bench, before: Trialled, found: Sequence[Trialled], hopeful: Collection[str]
) -> list[Trialled]:
    """Refits, best first, of which the most promising and the `hopeful` are settled."""
    found = sorted(found, key=lambda t: -t.total)
    most = max((t.total - before.total for t in found), default=0.0)
    least = before.total + PART_OF_BEST * max(most, 0.0)
    chosen = [t for i, t in enumerate(found)
              if (i < CONTENDERS and t.total > least) or t.effects[-1] in hopeful]  # fmt: skip
    rest = [t for t in found if t.effects[-1] not in {c.effects[-1] for c in chosen}]
    best = each(partial(settled, bench, before), chosen)
    while rest and rest[0].total > max([before.total, *(t.total for t in best)]):
        best.append(settled(bench, before, rest.pop(0)))
    return sorted([*best, *rest], key=lambda t: -t.total)


def _refit(
    bench: Bench, before: Trialled, name: str, told: Foretold, predictor: Passes
) -> Trialled:
    """A candidate's refit; one of which side measurements tell also with gains that follow: a wrong
    lens was far from where the fit began, and its paths had come out worse than without it.
    """
    start = {**before.fit.by_label(), **(told.start if told.gain > 0 else {}),
             **likeliest_start(bench.kernel, bench.points(before), name,
                               noise=before.noise, predictor=predictor)}  # fmt: skip
    found = bench.refit((*before.effects, name), before, start, predictor)
    aside = found.side - before.side > TOLD_ASIDE and found.total < before.total
    if np.isfinite(found.total) and not aside:
        return found
    again = bench.followed((*before.effects, name), before)
    return max(found, again, key=lambda t: t.total) if aside else again


def settled(bench: Bench, before: Trialled, model: Trialled) -> Trialled:
    """The model under its own noise; where the fit runs away, by another way or as it was."""
    found = bench.settled(model)
    if np.isfinite(found.total):
        return found
    again = bench.followed(model.effects, before)
    options = (bench.settled(again), again) if np.isfinite(again.total) else ()
    return next((m for m in options if np.isfinite(m.total)), model)


def promising(
    kernel: Kernel, told: Mapping[str, Foretold], count: int, inflation: float
) -> list[str]:
    """The best foretold that are not hopeless, and those with starts of their own; beside a model
    that is wrong all of the hopeful with a shape too.
    """
    ranked = sorted(told, key=lambda c: -told[c].gain)
    least = HOPELESS * inflation if np.isfinite(inflation) else 0.0
    hopeful = [c for i, c in enumerate(ranked) if told[c].gain > (0.0 if i < ANYWAY else least)]
    wrong = inflation > WRONG
    others = [c for c in ranked if c not in hopeful[:count] and (
        starts_of(kernel, c) or (wrong and c in hopeful and _has_shape(kernel, c)))]  # fmt: skip
    return hopeful[:count] + others


def _has_shape(kernel: Kernel, name: str) -> bool:
    frees, strengths = candidate_frees(kernel.system, name)
    return len(frees) > strengths
