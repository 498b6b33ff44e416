"""Which studies a challenge has: kinds, effects, levels, sizes, dealt out from a seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..synthetic.concealed.effects import OUTSIDE, PHYSICS
from ..synthetic.concealed.faults import FAULTS
from ..synthetic.concealed.recipe import Recipe, draw_recipe

SHARES: Mapping[str, float] = {
    "null": 0.18, "single": 0.40, "double": 0.14, "outside": 0.12, "measurement": 0.16,
}  # fmt: skip
SMALL_EVERY = 5
"""One study in so many is a small campaign of nine trials."""
UNFIT_FOR_FILM = ("keypoint_bias",)


@dataclass(frozen=True)
class Entry:
    """One study as dealt: its kind, what is concealed, how strong, how many trials, filmed."""

    name: str
    kind: str
    effects: tuple[str, ...]
    level: str
    trials: int
    footage: bool = False


def deal(seed: int, count: int, *, footage: int = 0) -> list[Entry]:
    """Studies of a challenge in shuffled order; effects of a kind come round evenly."""
    rng = np.random.default_rng([seed, 1])
    kinds = _kinds(count)
    decks = {kind: _deck(rng, kind) for kind in SHARES}
    order = [kinds[i] for i in rng.permutation(count)]
    levels = {kind: int(rng.integers(2)) for kind in SHARES}
    out = []
    for number, kind in enumerate(order, start=1):
        level = ("clear", "faint")[levels[kind] % 2]
        levels[kind] += 1
        trials = 9 if number % SMALL_EVERY == 0 else 24
        out.append(Entry(f"S{number:03d}", kind, next(decks[kind]), level, trials))
    return _filmed(rng, out, footage)


def _kinds(count: int) -> list[str]:
    """Kinds by their shares, whole numbers by largest remainder."""
    exact = {kind: share * count for kind, share in SHARES.items()}
    whole = {kind: int(value) for kind, value in exact.items()}
    by_rest = sorted(exact, key=lambda kind: whole[kind] - exact[kind])
    for kind in by_rest[: count - sum(whole.values())]:
        whole[kind] += 1
    return [kind for kind, number in whole.items() for _ in range(number)]


def _deck(rng: np.random.Generator, kind: str) -> Iterator[tuple[str, ...]]:
    """Endless effects of a kind, each as often as the others."""
    if kind == "null":
        while True:
            yield ()
    names = {
        "single": list(PHYSICS),
        "double": [n for n in PHYSICS if n != "tail_fin_lift"],
        "outside": list(OUTSIDE),
        "measurement": list(FAULTS),
    }[kind]
    while True:
        dealt = [names[i] for i in rng.permutation(len(names))]
        size = 2 if kind == "double" else 1
        yield from (tuple(dealt[i : i + size]) for i in range(0, len(dealt) - size + 1, size))


def _filmed(rng: np.random.Generator, entries: Sequence[Entry], count: int) -> list[Entry]:
    """Entries with `count` of them filmed; what is put into keypoints alone stays unfilmed."""
    fit = [i for i, e in enumerate(entries) if not set(e.effects) & set(UNFIT_FOR_FILM)]
    chosen = set(rng.permutation(fit)[:count].tolist())
    return [replace(e, footage=i in chosen) for i, e in enumerate(entries)]


def recipe_of(entry: Entry, seed: int, attempt: int = 0) -> Recipe:
    """The recipe of an entry; a later attempt draws robot, law and noise anew."""
    number = int(entry.name[1:])
    drawn = draw_recipe(
        (seed, number, attempt),
        entry.name,
        kind=entry.kind,
        trials=entry.trials,
        effects=entry.effects,
        level=entry.level,
    )
    return replace(drawn, footage=entry.footage)
