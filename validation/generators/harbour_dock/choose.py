"""Which group and causes a study gets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from . import laws_drag, laws_head, laws_measure, laws_thrust, laws_water
from .law import Law
from .typical import Typical

_MODULES = {
    laws_drag: ("viscous_drag", "wave_drag", "coulomb_friction", "crossflow_drag",
                "linear_yaw_damping", "added_mass", "trim_moment"),
    laws_thrust: ("thrust_loss_with_speed", "thrust_area", "battery_sag", "motor_spin_up",
                  "thrust_line_offset"),
    laws_head: ("stall", "lift_lag", "servo_lag", "head_angle_offset",
                "port_starboard_asymmetry", "centre_of_mass_shift"),
    laws_water: ("uniform_current", "pool_gyre", "wall_effect", "wake_reentry", "sinking"),
    laws_measure: ("scale_error", "clock_error", "camera_shift", "uncorrected_refraction",
                   "lens_error", "time_offset", "keypoint_bias"),
}  # fmt: skip
LAWS: dict[str, Callable[[Generator, Typical], Law]] = {
    name: getattr(module, name) for module, names in _MODULES.items() for name in names
}
NEEDS_LOG = ("time_offset",)
ALIKE = [
    {"servo_lag", "lift_lag", "added_mass"},
    {"motor_spin_up", "time_offset", "clock_error", "added_mass", "servo_lag"},
    {"battery_sag", "sinking", "wake_reentry", "motor_spin_up"},
    {"uniform_current", "pool_gyre", "wall_effect"},
    {"scale_error", "lens_error", "uncorrected_refraction", "sinking", "clock_error"},
    {"head_angle_offset", "trim_moment", "port_starboard_asymmetry", "thrust_line_offset"},
    {"keypoint_bias", "centre_of_mass_shift", "thrust_line_offset", "camera_shift"},
    {"viscous_drag", "coulomb_friction", "thrust_loss_with_speed", "wave_drag", "thrust_area"},
    {"crossflow_drag", "linear_yaw_damping"},
    {"stall", "lift_lag", "port_starboard_asymmetry"},
]
BLOCK = 20
GROUPS = {"null": 4, "one": 8, "two": 5, "unlisted": 3}
"""Studies of each group among `BLOCK` consecutive indices."""
CAUSES = {"null": 0, "one": 1, "two": 2, "unlisted": 0}
"""Listed causes of a study of each group, the fin not counted."""
GIVE_UP = 4
"""Attempts after which another cause is drawn."""


def alike(name: str, other: str) -> bool:
    """Whether two causes are nearly the same thing."""
    return name == other or any(name in kin and other in kin for kin in ALIKE)


def group_and_fin(seed: int, index: int) -> tuple[str, bool, int]:
    """Group, fin, and the number of causes that earlier studies of this seed have drawn."""
    block, at = divmod(index, BLOCK)
    ordered = [group for group, count in GROUPS.items() for _ in range(count)]
    rng = np.random.default_rng([seed, block, 77])
    groups = [ordered[i] for i in rng.permutation(BLOCK)]
    fin = {}
    for group in GROUPS:
        members = [i for i in range(BLOCK) if groups[i] == group]
        first = int(rng.integers(2))
        for rank, i in enumerate(rng.permutation(members)):
            fin[int(i)] = (rank + first) % 2 == 0
    causes_of_block = sum(CAUSES[group] * count for group, count in GROUPS.items())
    used = causes_of_block * block + sum(CAUSES[group] for group in groups[:at])
    return groups[at], fin[at], used


def draw_names(rng: Generator, seed: int, count: int, used: int, attempt: int) -> list[str]:
    """Causes from a shuffled deck of the seed; at random after repeated failure."""
    if count == 0:
        return []
    every = list(LAWS)
    deck: list[str] = []
    shuffler = np.random.default_rng([seed, 4711])
    while len(deck) < used + count + 1:
        deck += [str(name) for name in shuffler.permutation(every)]
    names = deck[used : used + count]
    if attempt >= GIVE_UP:
        names[0] = str(rng.choice(every))
    if count == 2:
        while alike(*names) or (attempt >= GIVE_UP and rng.random() < 0.3):
            names[1] = str(rng.choice(every))
    return names
