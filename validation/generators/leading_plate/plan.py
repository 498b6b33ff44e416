"""What each study hides: blocks of twenty studies with fixed shares, names from shuffled decks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .registry import MEASUREMENT, NAMES, UNLISTED

BLOCK = ("null",) * 3 + ("one",) * 7 + ("two",) * 6 + ("faint",) * 2 + ("unlisted",) * 2
ALIKE = (
    {"scale_error", "uncorrected_refraction", "lens_error", "sinking"},
    {"uniform_current", "pool_gyre", "wall_effect"},
    {"trim_moment", "head_angle_offset", "port_starboard_asymmetry", "thrust_line_offset"},
    {"viscous_drag", "coulomb_friction", "wave_drag", "thrust_loss_with_speed"},
    {"motor_spin_up", "time_offset", "added_mass", "servo_lag", "lift_lag"},
    {"battery_sag", "wake_reentry", "sinking"},
    {"crossflow_drag", "linear_yaw_damping", "stall"},
    {"keypoint_bias", "centre_of_mass_shift", "camera_shift", "thrust_area"},
)
"""Causes that are not hidden together."""


@dataclass(frozen=True)
class Plan:
    """names: causes in order of preference; as many are hidden as the group says."""

    group: str
    fin: bool
    few_trials: bool
    names: tuple[str, ...]

    @property
    def count(self) -> int:
        """Number of hidden laws beside a fin."""
        return {"null": 0, "two": 2}.get(self.group, 1)


def draw_plan(seed: int, index: int) -> Plan:
    """The plan of study `index`."""
    block, place = divmod(index, len(BLOCK))
    rng = np.random.default_rng([57, seed, block])
    groups = rng.permutation(BLOCK)
    fins = _fins(rng, groups)
    few = rng.random(len(BLOCK)) < 0.15
    group = str(groups[place])
    before = int((groups[:place] != "null").sum())
    deck = [*UNLISTED] if group == "unlisted" else [*NAMES]
    cards = 4 * list(np.random.default_rng([58, seed, block]).permutation(deck))
    if group != "unlisted":  # the next cards of the block, then of a deck of its own
        cards = cards[2 * before % len(deck) :]
    else:
        cards = [str(n) for n in rng.permutation(len(BLOCK) * [*UNLISTED])[place:]]
    return Plan(group, bool(fins[place]), bool(few[place] and group in ("null", "one")),
                tuple(str(n) for n in cards))  # fmt: skip


def _fins(rng: np.random.Generator, groups: np.ndarray) -> np.ndarray:
    """A fin for half of the block, shared evenly between the groups."""
    fins = np.zeros(len(groups), dtype=bool)
    order = np.argsort([(sorted(set(groups)).index(g) + rng.random() / 2) for g in groups])
    fins[order[int(rng.integers(2)) :: 2]] = True
    return fins


def choices(plan: Plan, start: int) -> tuple[str, ...]:
    """The names to try at an attempt: from a place in the deck on, none alike."""
    if plan.count == 0:
        return ()
    first = plan.names[start % len(plan.names)]
    if plan.count == 1:
        return (first,)
    for step in range(1, len(plan.names)):
        other = plan.names[(start + step) % len(plan.names)]
        alike = any({first, other} <= group for group in ALIKE)
        both_measured = first in MEASUREMENT and other in MEASUREMENT
        if other != first and not alike and not both_measured:
            return first, other
    raise ValueError(f"nothing to hide beside {first}")
