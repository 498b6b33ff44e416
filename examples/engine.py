"""The search for what was left out, for any system: one place where the examples meet the engine.

The steps of the first finder: the bare model by prediction errors with its
noise, candidates chosen by held-out conditions, each chosen one taken away again. What differs from
recording to recording is the system, its series and what an error means there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bluekoi.data import Float
from bluekoi.fitting import (
    Free,
    Noise,
    Series,
    Shot,
    fit,
    fit_noise,
    jackknife_cov,
    moving,
    shoot,
    trial_values,
)
from bluekoi.integrate import Kernel, System, compiled
from bluekoi.mismatch import Bench, Choice, Trialled, choose, trialled, try_effects, weights
from bluekoi.mismatch.rounds import one_round
from bluekoi.mismatch.search import candidate_frees, with_starts
from bluekoi.mismatch.select import in_place, pruned

MOST_AT_ONCE = 4


@dataclass(frozen=True)
class Case:
    """A system, its trials, the noise to begin with, and what is open in the search.

    coefficients: numbers of the bare model that are fitted, those of the effects in `within`
    among them; candidates: names of the effects that may have been left out.
    """

    system: System
    series: tuple[Series, ...]
    noise: Noise
    coefficients: tuple[Free, ...]
    candidates: tuple[str, ...]
    within: tuple[str, ...] = ()

    @property
    def kernel(self) -> Kernel:
        """The compiled system."""
        return compiled(self.system)

    @property
    def base(self) -> Float:
        """Parameter vector of the bare model, effects outside it absent, (parameters,)."""
        return with_starts(self.kernel, self.system.values({}), self.within)

    def bench(self, progress: Callable[[str], None]) -> Bench:
        """What the rounds of the search share."""
        return Bench(
            self.kernel, self.series, self.base, self.candidates, self.coefficients, progress
        )


@dataclass(frozen=True)
class Outcome:
    """What the search came to; std: deviation of the chosen model's numbers, over trials."""

    choice: Choice
    std: dict[str, float]

    @property
    def chosen(self) -> Trialled:
        """The model with all that pays."""
        return self.choice.chosen

    def gains(self) -> dict[str, float]:
        """Chosen effect -> held-out log likelihood lost without it, the largest first."""
        total = self.chosen.total
        lost = {name: total - model.total for name, model in self.choice.without.items()}
        return dict(sorted(lost.items(), key=lambda item: -item[1]))

    def weights(self, name: str) -> dict[str, float]:
        """Weights of the candidates that competed for a chosen effect's place.

        By the inflation of the chosen model: that of a rival which bends the numbers to single
        trials would make all of them look alike.
        """
        return weights(in_place(self.choice, name), self.chosen.inflation)


def case(
    system: System,
    series: Sequence[Series],
    noise: Noise,
    *,
    known: Sequence[str] = (),
    within: Sequence[str] = (),
    apart: Sequence[str] = (),
) -> Case:
    """A `Case`: all coefficients but the `known` ones are fitted, and all effects are tried but
    those that are `within` the bare model or kept `apart`.
    """
    own = [Free(p.name) for p in system.coefficients if p.name not in known]
    own += [f for name in within for f in candidate_frees(system, name)[0]]
    names = [e.name for e in system.effects if e.kind in ("physics", "measurement")]
    open_ = tuple(name for name in names if name not in (*within, *apart))
    return Case(system, tuple(series), noise, tuple(own), open_, tuple(within))


def bare_model(given: Case) -> Trialled:
    """The model without effects: numbers, then noise, then numbers again."""
    kernel, series, base, free = given.kernel, given.series, given.base, given.coefficients
    first = fit(kernel, series, base, free, given.noise)
    points = [trial_values(kernel, base, free, first.values, s.group) for s in series]
    noise = fit_noise(kernel, series, points, given.noise, rounds=4)
    again = fit(kernel, series, base, free, noise, start=first.by_label())
    return trialled(kernel, (), again, noise, series)


def investigate(given: Case, progress: Callable[[str], None] = lambda _: None) -> Outcome:
    """The whole search."""
    choice = choose(given.bench(progress), bare_model(given))
    return Outcome(choice, deviations(given, choice.chosen))


def deviations(given: Case, model: Trialled) -> dict[str, float]:
    """Deviation of each of a model's numbers, over trials."""
    cov = jackknife_cov(model.fit.normal, moving(given.kernel, model.fit))
    labels = [f.label for f in model.fit.free]
    return dict(zip(labels, np.sqrt(np.diag(cov)).tolist(), strict=True))


def searched_on(given: Case, outcome: Outcome, most: int = 2) -> Outcome:
    """The search gone on for up to `most` effects more, where it ended full.

    The engine names no more than four effects at once; what a ship's linear model lacks is more.
    """
    if len(outcome.chosen.effects) < MOST_AT_ONCE:
        return outcome
    bench, choice = given.bench(lambda _: None), outcome.choice
    current, without = choice.chosen, choice.without
    rounds, places = list(choice.rounds), dict(choice.places)
    for _ in range(most):
        done = one_round(bench, current, choice.bare)
        new = set(done.best.effects) - set(current.effects)
        if not new:
            break
        current, without = pruned(bench, bench.renoised(done.best), choice.bare)
        rounds.append(done)
        places |= dict.fromkeys(new, done)
    more = Choice(choice.bare, current, tuple(rounds), without, places)
    return Outcome(more, deviations(given, current))


@dataclass(frozen=True)
class Beside:
    """A candidate beside a model: the refit, its gain in held-out log likelihood, its weight among
    those asked with it and `nothing`.
    """

    model: Trialled
    gain: float
    weight: float


def beside(given: Case, chosen: Trialled, names: Sequence[str]) -> dict[str, Beside]:
    """Rivals that answer one question, each alone beside what is named apart from them.

    The best comes first; `nothing` stands for none of them.
    """
    named = tuple(e for e in chosen.effects if e not in names)
    before = chosen if named == chosen.effects else refitted(given, named, chosen)
    found = {"nothing": before, **{n: refitted(given, (*named, n), before) for n in names}}
    usable = {n: t.total for n, t in found.items() if np.isfinite(t.total)}
    share = weights(usable, before.inflation)
    rows = {n: Beside(t, t.total - before.total, share.get(n, 0.0)) for n, t in found.items()}
    return dict(sorted(rows.items(), key=lambda row: -row[1].gain))


def refitted(
    given: Case, effects: Sequence[str], like: Trialled, series: Sequence[Series] | None = None
) -> Trialled:
    """A model with these effects under the noise of another, fitted to all trials or to some."""
    return try_effects(
        given.kernel, series or given.series, given.base, given.coefficients, effects,
        noise=like.noise, start=like.fit.by_label(), iterations=25,
    )  # fmt: skip


def with_own_noise(given: Case, model: Trialled, rounds: int = 2) -> Trialled:
    """A model and its noise, fitted in turn to all trials."""
    for _ in range(rounds):
        points = values_of(given, model, given.series)
        noise = fit_noise(given.kernel, given.series, points, model.noise, rounds=4,
                          most=len(given.series))  # fmt: skip
        model = refitted(given, model.effects, replace(model, noise=noise))
    return model


def foretold(
    given: Case, model: Trialled, seen: Sequence[Series] | None = None, *, open_states: int = 6
) -> list[Shot]:
    """Each trial simulated freely by a model that was fitted to the other conditions alone.

    seen: the trials as they are to be foretold (every frame), where the fit takes them thinned.
    The start of each trial is the one that suits it best; everything else is foretold.
    """
    whole = {s.name: s for s in seen or given.series}
    shots: dict[str, Shot] = {}
    for condition in dict.fromkeys(s.condition for s in given.series):
        rest = [s for s in given.series if s.condition != condition]
        out = [whole[s.name] for s in given.series if s.condition == condition]
        values = values_of(given, refitted(given, model.effects, model, rest), out)
        found = shoot(given.kernel, out, values, open_states=open_states)
        shots |= {s.name: shot for s, shot in zip(out, found, strict=True)}
    return [shots[s.name] for s in given.series]


def values_of(given: Case, model: Trialled, series: Sequence[Series]) -> list[Float]:
    """Full parameter vector of each trial under a model."""
    return [trial_values(given.kernel, given.base, model.fit.free, model.fit.values, s.group)
            for s in series]  # fmt: skip


def narrowed(given: Case, series: Sequence[Series]) -> Case:
    """The same case with other trials."""
    return replace(given, series=tuple(series))
