"""Which studies a seed gives: kinds, effects, levels and sizes, dealt in blocks of 50."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from validation.generators.concealed.effects import PHYSICS, UNLISTED
from validation.generators.concealed.faults import FAULTS
from validation.generators.concealed.recipe import Recipe, draw_recipe

KIND_SHARES: Mapping[str, float] = {
    "null": 0.18, "single": 0.40, "double": 0.14, "outside": 0.12, "measurement": 0.16,
}  # fmt: skip
BLOCK_SIZE = 50
SMALL_STUDY_INTERVAL = 5
"""One study in so many is a small campaign of nine trials."""
FAULTS_WITHOUT_FOOTAGE = ("keypoint_bias",)


@dataclass(frozen=True)
class PlannedStudy:
    """One study as dealt: its kind, what is concealed, how strong, how many trials, filmed."""

    number: int
    kind: str
    effects: tuple[str, ...]
    level: str
    trials: int
    footage: bool = False


def planned_study(seed: int, index: int, *, footage: bool = False) -> PlannedStudy:
    """The study of an index: an entry of the block of `BLOCK_SIZE` studies that the index falls in.

    With footage only what a film can show is dealt (`FAULTS_WITHOUT_FOOTAGE` is left out).
    """
    block, place = divmod(index, BLOCK_SIZE)
    dealt = plan_block(seed, block)
    if footage:
        dealt = [e for e in dealt if not set(e.effects) & set(FAULTS_WITHOUT_FOOTAGE)]
    one = dealt[place % len(dealt)]
    return replace(one, number=index, footage=footage)


def plan_block(seed: int, block: int = 0) -> list[PlannedStudy]:
    """Studies of a block in shuffled order; effects of a kind come round evenly."""
    rng = np.random.default_rng([seed, 1, block])
    kinds = _kinds_by_share(BLOCK_SIZE)
    decks = {kind: _effect_cycle(rng, kind) for kind in KIND_SHARES}
    order = [kinds[i] for i in rng.permutation(BLOCK_SIZE)]
    levels = {kind: int(rng.integers(2)) for kind in KIND_SHARES}
    out = []
    for number, kind in enumerate(order, start=1):
        level = ("clear", "faint")[levels[kind] % 2]
        levels[kind] += 1
        trials = 9 if number % SMALL_STUDY_INTERVAL == 0 else 24
        out.append(PlannedStudy(number, kind, next(decks[kind]), level, trials))
    return out


def _kinds_by_share(count: int) -> list[str]:
    """Kinds by their shares, whole numbers by largest remainder."""
    exact = {kind: share * count for kind, share in KIND_SHARES.items()}
    whole = {kind: int(value) for kind, value in exact.items()}
    by_rest = sorted(exact, key=lambda kind: whole[kind] - exact[kind])
    for kind in by_rest[: count - sum(whole.values())]:
        whole[kind] += 1
    return [kind for kind, number in whole.items() for _ in range(number)]


def _effect_cycle(rng: np.random.Generator, kind: str) -> Iterator[tuple[str, ...]]:
    """Endless effects of a kind, each as often as the others."""
    if kind == "null":
        while True:
            yield ()
    names = {
        "single": list(PHYSICS),
        "double": [n for n in PHYSICS if n != "tail_fin_lift"],
        "outside": list(UNLISTED),
        "measurement": list(FAULTS),
    }[kind]
    while True:
        dealt = [names[i] for i in rng.permutation(len(names))]
        size = 2 if kind == "double" else 1
        yield from (tuple(dealt[i : i + size]) for i in range(0, len(dealt) - size + 1, size))


def draw_recipe_of(entry: PlannedStudy, seed: int, attempt: int = 0) -> Recipe:
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
