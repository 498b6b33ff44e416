"""Forward choice of effects, while an addition pays; rivals kept with their weights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..fitting import Filtered, Free, Series, filter_all, fit_noise, trial_values
from ..integrate import Kernel
from .search import Trialled, screened, try_effects

LEAST_GAIN_PER_TRIAL = 2.0
LEAST_T = 3.0
TRIED = 6
CONTENDERS = 3
MOST_CAUSES = 4
TEMPERATURE = 6.0
"""Held-out log likelihoods are divided by this before they become weights: errors within a trial
are correlated, so that raw differences would be far too sure."""


@dataclass(frozen=True)
class Round:
    """One round of the search: the model it started from, the gains foretold, what was refitted.

    The start and the `CONTENDERS` best are judged each under its own noise, fitted anew, since a
    model that lacks something takes its lack for noise; the others under that of the start.
    """

    before: Trialled
    foretold: dict[str, float]
    tried: tuple[Trialled, ...]
    predictor: tuple[Filtered, ...]

    @property
    def best(self) -> Trialled:
        """What did best, the start of the round included."""
        return max((self.before, *self.tried), key=lambda t: t.total)


@dataclass(frozen=True)
class Choice:
    """What the search ended with: the model without effects, with those that pay, the rounds."""

    bare: Trialled
    chosen: Trialled
    rounds: tuple[Round, ...]


def choose(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    bare: Trialled,
    candidates: Sequence[str],
    *,
    progress: Callable[[str], None],
) -> Choice:
    """Forward selection: screen all, refit the most promising, keep the best while it pays."""
    current, rounds = bare, []
    while True:
        left = [c for c in candidates if c not in current.effects]
        done = _round(kernel, series, base, current, left, count=len(bare.fit.free),
                      progress=progress)  # fmt: skip
        rounds.append(done)
        if not pays(done.before, done.best):
            return Choice(bare, current, tuple(rounds))
        current = done.best
        if len(current.effects) >= MOST_CAUSES:
            return Choice(bare, current, tuple(rounds))


def _round(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    current: Trialled,
    left: Sequence[str],
    *,
    count: int,
    progress: Callable[[str], None],
) -> Round:
    coefficients = list(current.fit.free[:count])
    noise = current.noise
    predictor = tuple(filter_all(kernel, series, _points(kernel, series, base, current), noise))

    def refit(effects: tuple[str, ...]) -> Trialled:
        progress(f"refit {', '.join(effects) or 'the model'}")
        return try_effects(kernel, series, base, coefficients, effects, noise=noise,
                           predictor=predictor, start=current.fit.by_label())  # fmt: skip

    before = refit(current.effects)
    gains = screened(kernel, series, before, base, left, noise=noise, predictor=predictor)
    promising = [c for c in sorted(gains, key=lambda c: -gains[c])[:TRIED] if gains[c] > 0]
    names = [*promising, *_hard_to_foretell(kernel, left, promising)]
    tried = sorted((refit((*current.effects, name)) for name in names), key=lambda t: -t.total)
    best = [t for t in tried[:CONTENDERS] if t.total > before.total]
    settled_best = [settled(kernel, series, base, t, count=count) for t in best]
    return Round(
        settled(kernel, series, base, before, count=count),
        gains,
        (*settled_best, *tried[len(best) :]),
        predictor,
    )


def settled(
    kernel: Kernel, series: Sequence[Series], base: Float, model: Trialled, *, count: int
) -> Trialled:
    """A model under its own noise: noise and numbers fitted in turn."""
    noise = fit_noise(kernel, series, _points(kernel, series, base, model), model.noise)
    return try_effects(kernel, series, base, list(model.fit.free[:count]), model.effects,
                       noise=noise, start=model.fit.by_label())  # fmt: skip


def _points(kernel: Kernel, series: Sequence[Series], base: Float, model: Trialled) -> list[Float]:
    return [trial_values(kernel, base, model.fit.free, model.fit.values, s.group) for s in series]


def _hard_to_foretell(kernel: Kernel, left: Sequence[str], known: Sequence[str]) -> list[str]:
    """Effects with a shape parameter, whose gain a step at strength 0 foretells badly."""
    return [
        c
        for c in left
        if c not in known
        and len(kernel.system.effect(c).parameters) > kernel.system.effect(c).strengths
    ]


def pays(before: Trialled, after: Trialled) -> bool:
    """Whether the held-out gain is large enough and shared by the trials (t statistic)."""
    gain = after.worth - before.worth
    return bool(gain.sum() > LEAST_GAIN_PER_TRIAL * len(gain) and shared(gain) > LEAST_T)


def shared(gain: Float) -> float:
    """A t statistic of gains by trial: of their signed roots, so that no single trial decides."""
    root = np.sign(gain) * np.sqrt(np.abs(gain))
    spread = float(np.std(root, ddof=1)) if len(root) > 1 else np.inf
    return float(np.mean(root) / (spread / np.sqrt(len(root)))) if spread > 0 else 0.0


def weights(totals: dict[str, float], temperature: float = TEMPERATURE) -> dict[str, float]:
    """Weights that sum to 1 from held-out log likelihoods."""
    top = max(totals.values())
    raw = {name: float(np.exp((value - top) / temperature)) for name, value in totals.items()}
    total = sum(raw.values())
    return {name: value / total for name, value in raw.items()}


def without(
    kernel: Kernel, series: Sequence[Series], base: Float, choice: Choice, name: str
) -> Trialled:
    """The chosen model with one of its effects taken away, all else refitted in the last round."""
    last = choice.rounds[-1].before
    rest = [e for e in choice.chosen.effects if e != name]
    start = {k: v for k, v in choice.chosen.fit.by_label().items() if not k.startswith(name + ".")}
    coefficients = [Free(f.name, f.group) for f in choice.bare.fit.free]
    return try_effects(kernel, series, base, coefficients, rest, noise=last.noise,
                       start=start)  # fmt: skip
