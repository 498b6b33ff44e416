"""All causes that can be hidden, and the plausible range of their strengths."""

from __future__ import annotations

import numpy as np

from . import laws_camera, laws_drive, laws_hull, laws_plate, laws_pool
from .form import MEASUREMENT, PHYSICS, Cause, Family
from .laws_unlisted import FORCES, unlisted_family
from .robots import Robot

_MODULES = (laws_camera, laws_drive, laws_hull, laws_plate, laws_pool)
FAMILIES: dict[str, Family] = {f.name: f for module in _MODULES for f in module.FAMILIES}
FIN = "tail_fin_lift"
GROUPS = {"null": 0.2, "single": 0.4, "pair": 0.2, "unlisted": 0.1, "measurement": 0.1}
"""Share of the studies in each group."""


def names_of(kind: str) -> list[str]:
    """Names of causes that may be hidden; the fin is drawn apart."""
    return [name for name, f in FAMILIES.items() if f.kind == kind and name != FIN]


def bounds(robot: Robot, cause: Cause) -> tuple[float, float]:
    """Weakest and strongest plausible strength, SI (px for pixels)."""
    unit = {
        "1": 1.0,
        "s": 1.0,
        "px": 1.0,
        "T": robot.top_thrust,
        "TL": robot.top_thrust * robot.body_length,
        "V": robot.top_speed,
        "L": robot.body_length,
        "Z": robot.pool_depth,
    }[cause.family.scale]
    return cause.family.span[0] * unit, cause.family.span[1] * unit


def draw_names(rng: np.random.Generator, group: str) -> list[str]:
    """Names of the hidden causes of a study of this group."""
    if group == "null":
        return []
    if group == "unlisted":
        return ["unlisted"]
    if group == "measurement":
        return [str(rng.choice(names_of(MEASUREMENT)))]
    count = 2 if group == "pair" else 1
    return [str(name) for name in rng.choice(names_of(PHYSICS), count, replace=False)]


def draw_cause(rng: np.random.Generator, robot: Robot, name: str) -> Cause:
    """A cause of this name in one of its forms, with the strength 1."""
    if name == "unlisted":
        form = str(rng.choice(list(FORCES)))
        family = unlisted_family(form, robot)
    else:
        family = FAMILIES[name]
        form = str(rng.choice(family.forms))
    return Cause(family, form, family.draw(rng, robot, form))
