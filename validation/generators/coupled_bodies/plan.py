"""Kinds of studies in fixed shares, and the causes they hide in turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import control_laws, drag_laws, faults, fin_laws, head_laws, place_laws, unlisted_laws
from .form import Form

KIND_COUNTS = {"null": 3, "single": 9, "pair": 3, "unlisted": 2, "measurement": 3}
"""Of 20 studies."""
BLOCK_SIZE = sum(KIND_COUNTS.values())
FIN_CAUSE = "tail_fin_lift"
UNLISTED_NAME = "unexplained"
CATALOGUE: tuple[Form, ...] = (
    *fin_laws.FORMS, *drag_laws.FORMS, *head_laws.FORMS, *control_laws.FORMS, *place_laws.FORMS,
    *unlisted_laws.FORMS, *faults.FORMS,
)  # fmt: skip
MEASUREMENT = tuple(dict.fromkeys(f.cause for f in faults.FORMS))
PHYSICS = tuple(c for c in dict.fromkeys(f.cause for f in CATALOGUE)
                if c not in (FIN_CAUSE, UNLISTED_NAME, *MEASUREMENT))  # fmt: skip


@dataclass(frozen=True)
class StudyKind:
    """Kind of a study; whether the robot has a fin, and whether there are only nine trials."""

    name: str
    fin: bool
    few: bool


def study_kind(seed: int, index: int) -> StudyKind:
    """Kind of study `index`: each twenty has the kinds of KIND_COUNTS, ten fins, four of nine
    trials.
    """
    rng = np.random.default_rng([seed, index // BLOCK_SIZE, 77])
    names = rng.permutation([name for name, n in KIND_COUNTS.items() for _ in range(n)])
    fin, few = (
        rng.permutation(BLOCK_SIZE) < BLOCK_SIZE // 2,
        rng.permutation(BLOCK_SIZE) < BLOCK_SIZE // 5,
    )
    at = index % BLOCK_SIZE
    return StudyKind(str(names[at]), bool(fin[at]), bool(few[at]))


def hidden_causes(seed: int, index: int) -> list[str]:
    """Names hidden in study `index`; a series takes all of them in turn."""
    own = study_kind(seed, index).name
    if own == "null":
        return []
    if own == "unlisted":
        return [UNLISTED_NAME]
    if own == "measurement":
        before = sum(study_kind(seed, i).name == own for i in range(index))
        return [_name_in_turn(seed, MEASUREMENT, before)]
    used = {"single": 1, "pair": 2}
    before = sum(used.get(study_kind(seed, i).name, 0) for i in range(index))
    names = [_name_in_turn(seed, PHYSICS, before + i) for i in range(used[own])]
    return list(dict.fromkeys(names))


def _name_in_turn(seed: int, names: tuple[str, ...], number: int) -> str:
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
