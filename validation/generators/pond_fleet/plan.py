"""Which causes a study hides.

A block of twenty studies has four nulls, seven of one cause, five pairs, two unlisted forces and
two errors of measurement; one pair joins physics and an error of measurement. Half of each kind
(rounded to the block's ten) has a fin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .drag_laws import DRAG_FAMILIES
from .drive_laws import DRIVE_FAMILIES
from .head_laws import HEAD_FAMILIES
from .unlisted_laws import UNLISTED_FAMILIES
from .water_laws import WATER_FAMILIES

FAMILIES = {f.name: f for f in (*DRAG_FAMILIES, *DRIVE_FAMILIES, *HEAD_FAMILIES, *WATER_FAMILIES)}
UNLISTED = {f.name: f for f in UNLISTED_FAMILIES}
FAULTS = ("scale_error", "clock_error", "camera_shift", "uncorrected_refraction", "lens_error",
          "time_offset", "keypoint_bias")  # fmt: skip
BLOCK = (
    *(("null", fin) for fin in (True, True, False, False)),
    *(("one", fin) for fin in (True, True, True, True, False, False, False)),
    *(("two", fin) for fin in (True, True, False, False, False)),
    ("unlisted", True), ("unlisted", False), ("measurement", True), ("measurement", False),
)  # fmt: skip
GROUPS = (
    {"viscous_drag", "coulomb_friction", "thrust_loss_with_speed", "wave_drag"},
    {"battery_sag", "wake_reentry"},
    {"motor_spin_up", "added_mass", "time_offset", "servo_lag", "lift_lag"},
    {"crossflow_drag", "linear_yaw_damping", "added_mass"},
    {"stall", "thrust_line_offset", "centre_of_mass_shift", "crossflow_drag"},
    {"stall", "lift_lag", "added_mass"},
    {"trim_moment", "head_angle_offset", "port_starboard_asymmetry", "magnetic_moment"},
    {"centre_of_mass_shift", "keypoint_bias", "trim_moment", "head_angle_offset"},
    {"uniform_current", "pool_gyre", "wall_effect", "tether_pull"},
    {"thrust_area", "centre_of_mass_shift"},
    {"scale_error", "lens_error", "uncorrected_refraction", "clock_error", "wall_effect"},
    {"camera_shift", "keypoint_bias", "uniform_current"},
    {"battery_sag", "surge_in_time", "wake_reentry"},
)
"""Causes that imitate each other: no two of a group are drawn together."""


@dataclass(frozen=True)
class Plan:
    """group: kind of study. candidate_lists: for each hidden law the causes to try, in order.

    fault: error of measurement, if any.
    """

    group: str
    fin: bool
    candidate_lists: tuple[tuple[str, ...], ...]
    fault: str | None


def draw_plan(seed: int, index: int) -> Plan:
    """Plan of study `index`; blocks of twenty are complete."""
    block, place = divmod(index, len(BLOCK))
    rng = np.random.default_rng([seed, block, 90210])
    places = rng.permutation(len(BLOCK))
    group, fin = BLOCK[places[place]]
    fault_order = rng.permutation(len(FAULTS))
    mixed = places[place] == int(rng.choice([11, 12, 13, 14, 15]))
    own = np.random.default_rng([seed, index, 4711])
    laws = {"one": 1, "two": 1 if mixed else 2}.get(group, 0)
    candidate_lists = [tuple(own.permutation(list(FAMILIES)).tolist()) for _ in range(laws)]
    if group == "unlisted":
        candidate_lists.append(tuple(own.permutation(list(UNLISTED)).tolist()))
    fault = None
    if group == "measurement" or mixed:
        number = 0 if mixed else 1 + int(places[place] - 18)
        fault = FAULTS[fault_order[(number + 3 * block) % len(FAULTS)]]
    return Plan(group, bool(fin), tuple(candidate_lists), fault)


def compatible(name: str, taken: list[str]) -> bool:
    """Whether a cause can be distinguished from those already hidden."""
    return name not in taken and not any(
        name in group and other in group for group in GROUPS for other in taken
    )
