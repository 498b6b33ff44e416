"""What is hidden in a study: its group, fin, laws and measurement error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .catalogue import CAUSES, UNLISTED

NULL, CLEAR, FAINT, PAIR = "null", "clear", "faint", "pair"
UNLISTED_GROUP, MEASUREMENT = "unlisted", "measurement"
SHARES = {NULL: 0.18, CLEAR: 0.20, FAINT: 0.20, PAIR: 0.14, UNLISTED_GROUP: 0.12, MEASUREMENT: 0.16}
"""Share of the studies in each group."""
WITH_LISTED_LAW = (CLEAR, FAINT, PAIR)
FAULTS = (
    "scale_error",
    "clock_error",
    "camera_shift",
    "uncorrected_refraction",
    "lens_error",
    "time_offset",
    "keypoint_bias",
)
"""Errors of the measurement."""
INSEPARABLE_PAIRS = (
    {"battery_sag", "sinking"},
    {"motor_spin_up", "servo_lag"},
    {"viscous_drag", "coulomb_friction"},
    {"wave_drag", "thrust_loss_with_speed"},
    {"uniform_current", "pool_gyre"},
    {"trim_moment", "head_angle_offset"},
    {"crossflow_drag", "linear_yaw_damping"},
    {"viscous_drag", "thrust_loss_with_speed"},
    {"viscous_drag", "wave_drag"},
    {"port_starboard_asymmetry", "head_angle_offset"},
    {"wake_reentry", "battery_sag"},
    {"wake_reentry", "sinking"},
    {"centre_of_mass_shift", "thrust_line_offset"},
    {"stall", "thrust_line_offset"},
    {"pool_gyre", "wall_effect"},
)
"""Pairs that one study could not separate."""
GOLDEN_RATIO = 0.6180339887498949


@dataclass(frozen=True)
class Plan:
    """Group, whether the robot has a fin, names of the hidden laws, and the measurement error."""

    group: str
    fin: bool
    names: tuple[str, ...]
    fault: str | None


def group_of(start: float, index: int) -> str:
    """Group of a study.

    The fractions of start + index times the golden ratio fall evenly, so that few studies have
    nearly the stated shares.
    """
    edges = np.cumsum(list(SHARES.values()))
    turn = (start + index * GOLDEN_RATIO) % 1.0
    return list(SHARES)[min(int(np.searchsorted(edges, turn)), len(SHARES) - 1)]


def draw_plan(seed: int, index: int) -> Plan:
    """Plan of a study; laws and errors follow each other in an order drawn for the series."""
    order = np.random.default_rng([seed, 77])
    start = order.random()
    fins = dict(zip(SHARES, order.integers(0, 2, len(SHARES)), strict=True))
    causes, unlisted, faults = (
        [str(name) for name in order.permutation(names)] for names in (CAUSES, UNLISTED, FAULTS)
    )
    group = group_of(start, index)
    before = [group_of(start, i) for i in range(index)]
    turn = before.count(group)
    fin = bool((fins[group] + turn) % 2)  # every other study of a group
    if group in WITH_LISTED_LAW:
        named = sum(g in WITH_LISTED_LAW for g in before)
        return Plan(group, fin, _listed_names(causes, named, pair=group == PAIR), None)
    hidden = (unlisted[turn % len(unlisted)],) if group == UNLISTED_GROUP else ()
    fault = faults[turn % len(faults)] if group == MEASUREMENT else None
    return Plan(group, fin, hidden, fault)


def _listed_names(causes: list[str], turn: int, *, pair: bool) -> tuple[str, ...]:
    """The cause whose turn it is, and for a pair one that can be separated from it."""
    first = causes[turn % len(causes)]
    if not pair:
        return (first,)
    allowed = [c for c in causes if c != first and {first, c} not in INSEPARABLE_PAIRS]
    return first, allowed[(turn * 7 + 3) % len(allowed)]
