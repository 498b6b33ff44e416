"""What each study of a series hides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from . import drive_laws, head_laws, hull_laws, place_laws, view_faults
from .form import MEASUREMENT, PHYSICS, UNLISTED, Form, HiddenCause

CATALOGUE: tuple[Form, ...] = (
    *hull_laws.FORMS, *drive_laws.FORMS, *head_laws.FORMS, *place_laws.FORMS, *view_faults.FORMS,
)  # fmt: skip
"""All forms but those of the fin."""
BLOCK = (
    *[("null", True)] * 2, *[("null", False)] * 2,
    *[("single", True)] * 5, *[("single", False)] * 4,
    *[("pair", True)] * 1, *[("pair", False)] * 2,
    ("measurement", True), ("measurement", False), ("unlisted", True), ("unlisted", False),
)  # fmt: skip
"""Kind of a study and whether its robot has a fin, for twenty studies before they are shuffled."""


def study_kind(seed: int, index: int) -> tuple[str, bool]:
    """Kind and fin of one study."""
    block, place = divmod(index, len(BLOCK))
    order = np.random.default_rng([seed, block, 401]).permutation(len(BLOCK))
    return BLOCK[order[place]]


def _pick(rng: np.random.Generator, kind: str, without: Sequence[str] = ()) -> Form:
    """A cause of a kind with equal chances, then one of its forms."""
    causes = sorted({f.cause for f in CATALOGUE if f.kind == kind} - set(without))
    cause = causes[rng.integers(len(causes))]
    forms = [f for f in CATALOGUE if f.kind == kind and f.cause == cause]
    return forms[rng.integers(len(forms))]


def hidden_forms(rng: np.random.Generator, kind: str) -> list[Form]:
    """Forms hidden in a study of a kind."""
    if kind == "null":
        return []
    if kind == "measurement":
        return [_pick(rng, MEASUREMENT)]
    if kind == "unlisted":
        return [_pick(rng, UNLISTED)]
    first = _pick(rng, PHYSICS)
    if kind == "single":
        return [first]
    second = MEASUREMENT if rng.random() < 0.25 else PHYSICS
    return [first, _pick(rng, second, [first.cause])]


def with_shape(rng: np.random.Generator, form: Form) -> HiddenCause:
    """A form with its first strength, of a random sign where it has one, and drawn parameters."""
    parameters = {k: round(float(rng.uniform(a, b)), 4) for k, (a, b) in form.shape.items()}
    sign = float(rng.choice([-1.0, 1.0])) if form.signed else 1.0
    return HiddenCause(form, sign * form.start, parameters)
