"""Forward choice of effects, while an addition pays; rivals kept with their weights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..fitting import Free, Noise, Series
from ..integrate import Kernel
from .search import Trialled, folds, held_out_worth, screened, try_effects

LEAST_GAIN_PER_TRIAL = 2.0
LEAST_T = 3.0
TRIED = 7
MOST_CAUSES = 4
TEMPERATURE = 6.0
"""Held-out log likelihoods are divided by this before they become weights: errors within a trial
are correlated, so that raw differences would be far too sure (calibrated on simulated studies)."""


@dataclass(frozen=True)
class Choice:
    """What the search ended with.

    bare: the model without effects. chosen: with those that pay. tried: for each round the
    candidates refitted then. screens: for each round the gains foretold. rivals: for each chosen
    effect the alternatives in its place, with weights that sum to 1 with its own.
    """

    bare: Trialled
    chosen: Trialled
    tried: tuple[tuple[Trialled, ...], ...]
    screens: tuple[dict[str, float], ...]


def choose(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    bare: Trialled,
    candidates: Sequence[str],
    noise: Noise,
    *,
    progress: Callable[[str], None],
) -> Choice:
    """Forward selection: screen all, refit the most promising, keep the best while it pays."""
    coefficients = list(bare.fit.free)
    current, rounds, screens = bare, [], []
    while len(current.effects) < MOST_CAUSES:
        left = [c for c in candidates if c not in current.effects]
        gains = screened(kernel, series, current, base, left, noise)
        screens.append(gains)
        promising = [c for c in sorted(gains, key=lambda c: -gains[c])[:TRIED] if gains[c] > 0]
        tried = []
        for name in [*promising, *_hard_to_foretell(kernel, left, promising)]:
            progress(f"refit {', '.join((*current.effects, name))}")
            tried.append(
                try_effects(kernel, series, base, coefficients, (*current.effects, name), noise,
                            start=current.fit.by_label())
            )  # fmt: skip
        rounds.append(tuple(tried))
        best = max(tried, key=lambda t: t.total, default=None)
        if best is None or not pays(current, best):
            break
        current = best
    return Choice(bare, current, tuple(rounds), tuple(screens))


def _hard_to_foretell(kernel: Kernel, left: Sequence[str], known: Sequence[str]) -> list[str]:
    """Effects with a shape parameter, whose gain a step at strength 0 foretells badly."""
    shaped = [c for c in left if len(kernel.system.effect(c).parameters)
              > kernel.system.effect(c).strengths]  # fmt: skip
    return [c for c in shaped if c not in known and c != "tail_fin_lift"]


def pays(before: Trialled, after: Trialled) -> bool:
    """Whether the held-out gain is large enough and shared by the trials (t statistic)."""
    gain = after.worth - before.worth
    return bool(gain.sum() > LEAST_GAIN_PER_TRIAL * len(gain) and shared(gain) > LEAST_T)


def shared(gain: Float) -> float:
    """A t statistic of gains by trial: of their signed roots, so that no single trial decides."""
    root = np.sign(gain) * np.sqrt(np.abs(gain))
    spread = float(np.std(root, ddof=1)) if len(root) > 1 else np.inf
    return float(np.mean(root) / (spread / np.sqrt(len(root)))) if spread > 0 else np.inf


def weights(totals: dict[str, float], temperature: float = TEMPERATURE) -> dict[str, float]:
    """Weights that sum to 1 from held-out log likelihoods."""
    top = max(totals.values())
    raw = {name: float(np.exp((value - top) / temperature)) for name, value in totals.items()}
    total = sum(raw.values())
    return {name: value / total for name, value in raw.items()}


def without(
    kernel: Kernel, series: Sequence[Series], base: Float, choice: Choice, name: str, noise: Noise
) -> Trialled:
    """The chosen model with one of its effects taken away and all else refitted."""
    rest = [e for e in choice.chosen.effects if e != name]
    start = {k: v for k, v in choice.chosen.fit.by_label().items() if not k.startswith(name + ".")}
    return try_effects(kernel, series, base, coefficients_of(choice), rest, noise, start=start)


def coefficients_of(choice: Choice) -> list[Free]:
    """The model's own numbers."""
    return list(choice.bare.fit.free)


__all__ = ["Choice", "choose", "folds", "held_out_worth", "pays", "shared", "weights", "without"]
