"""All forms by cause, and random choices among them."""

import numpy as np

from .form import Form
from .laws_body import BODY_FORMS
from .laws_camera import CAMERA_FORMS
from .laws_drag import DRAG_FORMS
from .laws_drive import DRIVE_FORMS
from .laws_fin import CROSSFLOW, FIN
from .laws_plate import PLATE_FORMS
from .laws_unlisted import UNLISTED

LISTED: list[Form] = [
    *CROSSFLOW,
    *DRAG_FORMS,
    *BODY_FORMS,
    *DRIVE_FORMS,
    *PLATE_FORMS,
    *CAMERA_FORMS,
]


def by_cause(forms: list[Form]) -> dict[str, list[Form]]:
    """Forms grouped by the name of their cause."""
    groups: dict[str, list[Form]] = {}
    for form in forms:
        groups.setdefault(form.cause, []).append(form)
    return groups


def needs_two_heads(form: Form) -> bool:
    """Whether the form shows only where head lengths differ."""
    return form.cause == "thrust_area" or form.form == "with_head_length"


def draw_form(rng: np.random.Generator, taken: list[Form]) -> Form:
    """A random form of a random cause; two causes of a study differ in cause, drive and clock."""
    names = {form.cause for form in taken}
    for pair in ({"battery_sag", "motor_spin_up"}, {"clock_error", "time_offset"}):
        names |= pair if names & pair else set()
    groups = by_cause([form for form in LISTED if form.cause not in names])
    group = groups[str(rng.choice(sorted(groups)))]
    return group[rng.integers(len(group))]


def draw_fin(rng: np.random.Generator) -> Form:
    """A random form of the tail fin."""
    return FIN[rng.integers(len(FIN))]


def draw_unlisted(rng: np.random.Generator) -> Form:
    """A random force that no candidate cause describes."""
    return UNLISTED[rng.integers(len(UNLISTED))]
