"""All families of laws by name."""

from __future__ import annotations

import numpy as np

from .drag_laws import DRAG_FAMILIES
from .drive_laws import DRIVE_FAMILIES
from .here import Family, Law
from .unlisted_laws import UNLISTED_FAMILIES
from .water_laws import WATER_FAMILIES

PHYSICS = {f.name: f for f in (*DRIVE_FAMILIES, *DRAG_FAMILIES, *WATER_FAMILIES)}
UNLISTED = {f.name: f for f in UNLISTED_FAMILIES}
FAMILIES: dict[str, Family] = PHYSICS | UNLISTED


def _optical(
    name: str, forms: tuple[str, ...], sizes: tuple[float, float, float], unit: str, meaning: str
) -> Family:
    """sizes: low, high, probe."""
    low, high, probe = sizes
    return Family(name, "sight", lambda _law, _here: None, forms, low, high, unit, meaning, probe)


MEASUREMENT = {f.name: f for f in (
    _optical("scale_error", ("pool_length", "rim"), (0.006, 0.12, 0.01), "1",
             "stated over true pool, less one"),
    _optical("clock_error", ("all_trials", "later_trials"), (0.004, 0.12, 0.01), "1",
             "stated over true frame rate, less one"),
    _optical("camera_shift", ("step", "turn", "returning"), (0.004, 0.12, 0.01), "1",
             "shift over body length, or angle (rad)"),
    _optical("uncorrected_refraction", ("index", "depth"), (0.1, 1.0, 0.2), "1",
             "share of the refraction that is left out"),
    _optical("lens_error", ("cubic", "quintic", "tangential"), (0.004, 0.3, 0.01), "1",
             "missing coefficient of distortion"),
    _optical("time_offset", ("video_first", "by_trial"), (0.05, 1.5, 0.1), "s",
             "rest at the start of a video"),
    _optical("keypoint_bias", ("core_center", "core_labels"), (0.003, 0.12, 0.01), "1",
             "displacement over body length"),
)}  # fmt: skip
SIZED: dict[str, Family] = FAMILIES | MEASUREMENT
NAMES = (*PHYSICS, *MEASUREMENT)


def draw_law(rng: np.random.Generator, name: str) -> Law:
    """A law of a family with a form and a middling size."""
    family = SIZED[name]
    size = float(np.sqrt(family.low * family.high) * rng.uniform(0.6, 1.6))
    shape = (float(rng.random()), float(rng.random()))
    return Law(name, str(rng.choice(family.forms)), size, shape, int(rng.choice([-1, 1])))


def probe_law(name: str) -> Law:
    """The leading form at a small size, as a rival."""
    family = SIZED[name]
    return Law(name, family.forms[0], family.probe, (0.4, 0.6), 1)
