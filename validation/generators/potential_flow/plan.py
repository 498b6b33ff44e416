"""What each study of a series contains: its kind, its fin and its causes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .catalogue import CATALOGUE, MEASUREMENT, PHYSICS, UNLISTED_FORMS
from .form import OPTICAL_STAGES, Form

KIND_COUNTS = (("null", 3), ("single", 9), ("pair", 3), ("unlisted", 2), ("measurement", 3))
"""Kinds of twenty studies in a row."""
CAUSES_BY_KIND = {"single": sorted({f.cause for f in PHYSICS}),
         "measurement": sorted({f.cause for f in MEASUREMENT}),
         "unlisted": [f.name for f in UNLISTED_FORMS]}  # fmt: skip


@dataclass(frozen=True)
class StudyKind:
    """Kind of a study; `number` counts the studies of this kind in the series."""

    name: str
    number: int
    fin: bool
    few: bool


def study_kind(seed: int, index: int) -> StudyKind:
    """The kind of study `index`; shares are exact in each twenty studies."""
    block, row = divmod(index, 20)
    rng = np.random.default_rng([seed, block, 52361])
    names = rng.permutation([name for name, count in KIND_COUNTS for _ in range(count)])
    fins = rng.permutation(np.arange(20) < 10)
    few = rng.permutation(np.arange(20) < 4)
    name = str(names[row])
    number = block * dict(KIND_COUNTS)[name] + int(np.count_nonzero(names[:row] == name))
    return StudyKind(name, number, bool(fins[row]), bool(few[row]))


def cause_in_turn(seed: int, name: str, number: int) -> str:
    """The cause whose turn it is: all causes in a random order before one comes again."""
    rounds, row = divmod(number, len(CAUSES_BY_KIND[name]))
    order = np.random.default_rng([seed, rounds, 911, len(name)]).permutation(CAUSES_BY_KIND[name])
    return str(order[row])


def forms_of(cause: str) -> list[Form]:
    """The forms of a cause."""
    return [f for f in CATALOGUE if f.cause == cause]


def draw_forms(rng: np.random.Generator, seed: int, what: StudyKind) -> list[Form]:
    """The hidden forms of a study, the fin of its robot apart."""
    if what.name == "null":
        return []
    if what.name == "unlisted":
        name = cause_in_turn(seed, "unlisted", what.number)
        return [f for f in UNLISTED_FORMS if f.name == name]
    if what.name == "measurement":
        return [_draw_form(rng, cause_in_turn(seed, "measurement", what.number))]
    if what.name == "single":
        return [_draw_form(rng, cause_in_turn(seed, "single", what.number))]
    names = [n for n in CAUSES_BY_KIND["single"] if n != "tail_fin_lift" or not what.fin]
    first, second = rng.choice(names, 2, replace=False)
    forms = [_draw_form(rng, str(first)), _draw_form(rng, str(second))]
    return sorted(forms, key=lambda f: f.stage in OPTICAL_STAGES)


def _draw_form(rng: np.random.Generator, cause: str) -> Form:
    forms = forms_of(cause)
    return forms[int(rng.integers(len(forms)))]
