"""Shuffled decks: which group, fin and causes each index of a block of sixty gets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .registry import FORMS, UNLISTED

LARGE = [("null", 6), ("one", 14), ("two", 12), ("faint", 4), ("unlisted", 4)]
SMALL = [("null", 4), ("one", 16)]


@dataclass
class Order:
    """What one index asks for."""

    group: str
    fin: bool
    names: list[str]
    unlisted: int
    trials: int


def _deal(rng: np.random.Generator, table: list[tuple[str, int]]) -> list[tuple[str, bool]]:
    """Groups with fins in half of each, shuffled."""
    cards: list[tuple[str, bool]] = []
    odd = bool(rng.integers(2))
    for group, count in table:
        fins = [bool((i + odd) % 2) for i in range(count)]
        cards += [(group, one) for one in fins]
    return [cards[i] for i in rng.permutation(len(cards))]


def orders(seed: int, block: int) -> list[Order]:
    """The sixty orders of a block."""
    rng = np.random.default_rng([seed, block, 58])
    names = [name for name in FORMS if name != "tail_fin_lift"]
    deck = [names[i] for _ in range(3) for i in rng.permutation(len(names))]
    extra = [int(i) for i in rng.permutation(len(UNLISTED))]
    out = []
    for place, (group, fin) in enumerate(_deal(rng, LARGE) + _deal(rng, SMALL)):
        trials = int(rng.integers(24, 31)) if place < 40 else 9
        causes: list[str] = []
        if group in ("one", "faint"):
            causes = [deck.pop(0)]
        elif group == "two":
            causes = [deck.pop(0)]
            other = next(i for i, name in enumerate(deck) if name != causes[0])
            causes.append(deck.pop(other))
        which = extra.pop(0) if group == "unlisted" else -1
        out.append(Order(group, fin, causes, which, trials))
    return out
