"""Which studies a seed gives: kinds, effects, levels and sizes, dealt in blocks of 50."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from validation.generators.concealed.effects import OUTSIDE, PHYSICS
from validation.generators.concealed.faults import FAULTS
from validation.generators.concealed.recipe import Recipe, draw_recipe

SHARES: Mapping[str, float] = {
    "null": 0.18, "single": 0.40, "double": 0.14, "outside": 0.12, "measurement": 0.16,
}  # fmt: skip
BLOCK = 50
SMALL_EVERY = 5
"""One study in so many is a small campaign of nine trials."""
UNFIT_FOR_FILM = ("keypoint_bias",)


@dataclass(frozen=True)
class Entry:
    """One study as dealt: its kind, what is concealed, how strong, how many trials, filmed."""

    number: int
    kind: str
    effects: tuple[str, ...]
    level: str
    trials: int
    footage: bool = False


def entry_of(seed: int, index: int, *, footage: bool = False) -> Entry:
    """The study of an index: an entry of the block of `BLOCK` studies that the index falls in.

    With footage only what a film can show is dealt (`UNFIT_FOR_FILM` is left out).
    """
    block, place = divmod(index, BLOCK)
    dealt = deal(seed, block)
    if footage:
        dealt = [e for e in dealt if not set(e.effects) & set(UNFIT_FOR_FILM)]
    one = dealt[place % len(dealt)]
    return replace(one, number=index, footage=footage)


def deal(seed: int, block: int = 0) -> list[Entry]:
    """Studies of a block in shuffled order; effects of a kind come round evenly."""
    rng = np.random.default_rng([seed, 1, block])
    kinds = _kinds(BLOCK)
    decks = {kind: _deck(rng, kind) for kind in SHARES}
    order = [kinds[i] for i in rng.permutation(BLOCK)]
    levels = {kind: int(rng.integers(2)) for kind in SHARES}
    out = []
    for number, kind in enumerate(order, start=1):
        level = ("clear", "faint")[levels[kind] % 2]
        levels[kind] += 1
        trials = 9 if number % SMALL_EVERY == 0 else 24
        out.append(Entry(number, kind, next(decks[kind]), level, trials))
    return out


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


def recipe_of(entry: Entry, seed: int, attempt: int = 0) -> Recipe:
    """The recipe of an entry; every attempt draws another robot, law and noise."""
    drawn = draw_recipe(
        (seed, entry.number, attempt),
        f"S{entry.number:03d}",
        kind=entry.kind,
        trials=entry.trials,
        effects=entry.effects,
        level=entry.level,
    )
    return replace(drawn, footage=entry.footage)
