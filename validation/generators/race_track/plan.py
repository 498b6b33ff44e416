"""Which kind of study each index of a series is, and which causes it hides.

Blocks of 20 hold 3 without a missing cause, 8 with one, 5 with two, 2 with an unlisted force and 2
with an error of measurement alone; half of each block's robots have a fin, which counts beside
these. Two of the five second causes are errors of measurement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import body_laws, drive_laws, head_laws, unlisted_laws, water
from .faults import FAULTS
from .form import Family

BLOCK = ("null",) * 3 + ("one",) * 8 + ("two",) * 5 + ("unlisted",) * 2 + ("measurement",) * 2
STREAM = 5051
FAMILIES: tuple[Family, ...] = (
    body_laws.FAMILIES + drive_laws.FAMILIES + head_laws.FAMILIES + water.FAMILIES
)
CAUSES = {family.name: family for family in FAMILIES}
UNLISTED = {family.name: family for family in unlisted_laws.FAMILIES}
LOOKALIKES = (
    {"viscous_drag", "coulomb_friction"},
    {"wave_drag", "thrust_loss_with_speed"},
    {"battery_sag", "sinking", "wake_reentry"},
    {"motor_spin_up", "time_offset", "added_mass"},
    {"servo_lag", "lift_lag", "stall"},
    {"trim_moment", "head_angle_offset", "port_starboard_asymmetry", "keypoint_bias"},
    {"thrust_line_offset", "centre_of_mass_shift", "keypoint_bias"},
    {"uniform_current", "pool_gyre"},
    {"linear_yaw_damping", "crossflow_drag"},
    {"scale_error", "clock_error"},
)
"""Causes that no careful trial separates are not hidden together."""


@dataclass(frozen=True)
class Plan:
    """A study to be made. decks: causes in the order in which they are tried, one deck a cause."""

    group: str
    fin: bool
    decks: tuple[tuple[str, ...], ...]
    unlisted: tuple[str, ...] = ()
    fault: str | None = None


def draw_plan(seed: int, index: int) -> Plan:
    """Plan of study `index` in the series `seed`."""
    block, place = divmod(index, len(BLOCK))
    rng = np.random.default_rng([seed, block, STREAM])
    order = rng.permutation(len(BLOCK))
    fins = (np.arange(len(BLOCK)) + rng.integers(2)) % 2
    kind = int(order[place])
    own = np.random.default_rng([seed, index, STREAM + 1])
    group = BLOCK[kind]
    names = _deck(seed, index)
    unlisted = tuple(str(name) for name in own.permutation(list(UNLISTED)))
    physics = {"one": 1, "two": 2}.get(group, 0)
    fault = group == "measurement" or (group == "two" and kind - BLOCK.index("two") < 2)
    if group == "two" and fault:
        physics = 1
    return Plan(
        group=group, fin=bool(fins[kind]),
        decks=tuple(names[i::physics] for i in range(physics)),
        unlisted=unlisted if group == "unlisted" else (),
        fault=str(own.choice(list(FAULTS))) if fault else None,
    )  # fmt: skip


def _deck(seed: int, index: int) -> tuple[str, ...]:
    """Causes in an order that starts elsewhere for each study, so that all have their turn."""
    rng = np.random.default_rng([seed, STREAM + 2])
    names = [str(name) for name in rng.permutation(list(CAUSES))]
    start = (7 * index) % len(names)
    return tuple(names[start:] + names[:start])


def compatible(name: str, others: list[str]) -> bool:
    """Whether a cause may stand beside the others."""
    return not any(name in alike and other in alike for alike in LOOKALIKES for other in others)
