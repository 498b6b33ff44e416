"""What each study of a series hides; kinds and causes come in turn by the seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import body_laws, drive_laws, faults, place_laws
from .form import MEASUREMENT, PHYSICS, UNLISTED, Form, HiddenCause

CATALOGUE: tuple[Form, ...] = (
    *body_laws.FORMS, *drive_laws.FORMS, *place_laws.FORMS, *faults.FORMS,
)  # fmt: skip
"""All forms."""
BLOCK_SIZE = 20
KINDS_OF_BLOCK = (
    *[("null", True)] * 2, *[("null", False)] * 2,
    *[("single", True)] * 5, *[("single", False)] * 4,
    *[("pair", True)] * 1, *[("pair", False)] * 2,
    *[("measurement", True)] * 1, *[("measurement", False)] * 1,
    *[("unlisted", True)] * 1, *[("unlisted", False)] * 1,
)  # fmt: skip
"""Kind and fin of the twenty studies of a block, before they are shuffled."""
TARGET_SIGMA_RANGE = (13.0, 38.0)
"""Range of the wanted sigma, log-uniform."""


@dataclass(frozen=True)
class StudyKind:
    """Kind of a study, whether its robot has a fin, and its number among those of its kind."""

    group: str
    fin: bool
    turn: int


def causes_of_kind(kind: str) -> list[str]:
    """Names of all causes of a kind (`physics`, `measurement`, `unlisted`)."""
    return sorted({f.cause for f in CATALOGUE if f.kind == kind})


def study_kind(seed: int, index: int) -> StudyKind:
    """Kind of one study of a series."""
    block, place = divmod(index, BLOCK_SIZE)
    order = np.random.default_rng([seed, block, 11]).permutation(BLOCK_SIZE)
    kinds = [KINDS_OF_BLOCK[i] for i in order]
    group, fin = kinds[place]
    per_block = sum(k[0] == group for k in KINDS_OF_BLOCK)
    return StudyKind(group, fin, block * per_block + sum(k[0] == group for k in kinds[:place]))


def _name_in_turn(names: Sequence[str], seed: int, stream: int, turn: int) -> str:
    """One of the names; all come before one comes again."""
    lap, place = divmod(turn, len(names))
    return names[np.random.default_rng([seed, stream, lap]).permutation(len(names))[place]]


def _draw_form(rng: np.random.Generator, cause: str) -> Form:
    forms = [f for f in CATALOGUE if f.cause == cause]
    return forms[rng.integers(len(forms))]


def hidden_forms(rng: np.random.Generator, seed: int, kind: StudyKind, attempt: int) -> list[Form]:
    """Forms of the hidden causes of a study.

    attempt: counts from 0; a cause that cannot be made visible gives way to the next in turn.
    """
    physics, errors = causes_of_kind(PHYSICS), causes_of_kind(MEASUREMENT)
    turn = kind.turn + 1000 * attempt
    if kind.group == "null":
        return []
    if kind.group == "single":
        return [_draw_form(rng, _name_in_turn(physics, seed, 21, turn))]
    if kind.group == "measurement":
        return [_draw_form(rng, _name_in_turn(errors, seed, 22, turn))]
    if kind.group == "unlisted":
        forms = [f.name for f in CATALOGUE if f.kind == UNLISTED]
        name = _name_in_turn(forms, seed, 23, turn)
        return [next(f for f in CATALOGUE if f.kind == UNLISTED and f.name == name)]
    first = _name_in_turn(physics, seed, 24, turn)
    others = errors if kind.turn % 3 == 2 else [c for c in physics if c != first]
    return [_draw_form(rng, first), _draw_form(rng, others[rng.integers(len(others))])]


def with_drawn_shape(rng: np.random.Generator, form: Form) -> HiddenCause:
    """A form with its first strength and random shape; odd causes and errors have either sign."""
    parameters = {
        name: round(float(rng.uniform(low, high)), 4) for name, (low, high) in form.shape.items()
    }
    positive = {"time_offset", "uncorrected_refraction", "wall_effect", "uniform_current"}
    either = (form.odd or form.kind == MEASUREMENT) and form.cause not in positive
    sign = rng.choice([-1.0, 1.0]) if either else 1.0
    return HiddenCause(form, float(sign * form.start), parameters)
