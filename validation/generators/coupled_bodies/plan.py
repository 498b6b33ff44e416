"""Kinds of studies in fixed shares, and the causes they hide in turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import control_laws, drag_laws, faults, fin_laws, head_laws, place_laws, unlisted_laws
from .form import Form

KINDS = {"null": 3, "single": 9, "pair": 3, "unlisted": 2, "measurement": 3}
"""Of 20 studies."""
BLOCK = sum(KINDS.values())
FIN = "tail_fin_lift"
UNLISTED = "unexplained"
CATALOGUE: tuple[Form, ...] = (
    *fin_laws.FORMS, *drag_laws.FORMS, *head_laws.FORMS, *control_laws.FORMS, *place_laws.FORMS,
    *unlisted_laws.FORMS, *faults.FORMS,
)  # fmt: skip
MEASUREMENT = tuple(dict.fromkeys(f.cause for f in faults.FORMS))
PHYSICS = tuple(c for c in dict.fromkeys(f.cause for f in CATALOGUE)
                if c not in (FIN, UNLISTED, *MEASUREMENT))  # fmt: skip


@dataclass(frozen=True)
class Kind:
    """Kind of a study; whether the robot has a fin, and whether there are only nine trials."""

    name: str
    fin: bool
    few: bool


def kind(seed: int, index: int) -> Kind:
    """Kind of study `index`: each twenty has the shares of KINDS, ten fins, four of nine trials."""
    rng = np.random.default_rng([seed, index // BLOCK, 77])
    names = rng.permutation([name for name, n in KINDS.items() for _ in range(n)])
    fin, few = rng.permutation(BLOCK) < BLOCK // 2, rng.permutation(BLOCK) < BLOCK // 5
    at = index % BLOCK
    return Kind(str(names[at]), bool(fin[at]), bool(few[at]))


def causes(seed: int, index: int) -> list[str]:
    """Names hidden in study `index`; a series takes all of them in turn."""
    own = kind(seed, index).name
    if own == "null":
        return []
    if own == "unlisted":
        return [UNLISTED]
    if own == "measurement":
        before = sum(kind(seed, i).name == own for i in range(index))
        return [_turn(seed, MEASUREMENT, before)]
    used = {"single": 1, "pair": 2}
    before = sum(used.get(kind(seed, i).name, 0) for i in range(index))
    names = [_turn(seed, PHYSICS, before + i) for i in range(used[own])]
    return list(dict.fromkeys(names))


def _turn(seed: int, names: tuple[str, ...], number: int) -> str:
    """Name number n of rounds through all names, each round in another order."""
    rng = np.random.default_rng([seed, number // len(names), len(names)])
    return str(rng.permutation(names)[number % len(names)])


def draw_forms(rng: np.random.Generator, names: list[str]) -> list[Form]:
    """A form for each cause; only one may have a memory."""
    forms: list[Form] = []
    for name in names:
        free = [f for f in CATALOGUE if f.cause == name]
        if any(f.stage == "memory" for f in forms):
            free = [f for f in free if f.stage != "memory"] or free
        forms.append(free[rng.integers(len(free))])
    if sum(f.stage == "memory" for f in forms) > 1:
        return forms[:1]
    return forms
