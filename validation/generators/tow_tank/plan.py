"""What a study hides: kinds in fixed shares of each twenty studies, causes and forms at random."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from . import blades, drive, head, resistance, water
from .faults import FAULTS, SINKING
from .form import Form
from .motion import HiddenLaw, straight_growth_rate
from .robots import ParallelTrials, Robot

KIND_COUNTS = MappingProxyType({"null": 3, "single": 9, "pair": 3, "unlisted": 2, "measurement": 3})
FIN_CAUSE = "tail_fin_lift"
UNLISTED_NAME = "unexplained"
LEAST, MOST, FAINT = 10.0, 60.0, 25.0
CATALOGUE: tuple[Form, ...] = (*blades.FORMS, *resistance.FORMS, *drive.FORMS, *head.FORMS,
                               *water.FORMS, *FAULTS, *SINKING)  # fmt: skip
MEASUREMENT = frozenset(f.cause for f in FAULTS)
PHYSICS = frozenset(f.cause for f in CATALOGUE) - MEASUREMENT - {UNLISTED_NAME}
CONFUSABLE_PAIRS = (("motor_spin_up", "battery_sag"), ("stall", "lift_lag"), ("lift_lag", "stall"),
         ("uniform_current", "pool_gyre"))  # fmt: skip
"""Pairs that share an internal state or a place in the drive, not hidden together."""


@dataclass(frozen=True)
class StudyKind:
    """Kind of a study, whether its robot has a fin, whether it has nine trials."""

    name: str
    fin: bool
    few: bool


def study_kind(seed: int, index: int) -> StudyKind:
    """Kind of one study of a series; shares hold over each block of twenty."""
    rng = np.random.default_rng([seed, index // 20, 7013])
    names = [n for n, count in KIND_COUNTS.items() for _ in range(count)]
    order, fins, few = (rng.permutation(20) for _ in range(3))
    k = index % 20
    return StudyKind(names[order[k]], bool(fins[k] < 10), bool(few[k] < 4))


def draw_forms(rng: np.random.Generator, name: str) -> list[Form]:
    """Forms that a study of this kind hides, beside its fin."""
    single = sorted(PHYSICS - {FIN_CAUSE, "head_angle_offset"})
    if name == "null":
        return []
    if name == "measurement":
        causes = [str(rng.choice(sorted(MEASUREMENT | {"head_angle_offset"})))]
    elif name == "unlisted":
        causes = [UNLISTED_NAME]
    elif name == "single":
        causes = [str(rng.choice(single))]
    else:
        causes = [str(c) for c in rng.choice(sorted(set(single) - {"sinking"}), 2, replace=False)]
        if tuple(causes) in CONFUSABLE_PAIRS or tuple(causes[::-1]) in CONFUSABLE_PAIRS:
            return draw_forms(rng, name)
    return [_choose_one(rng, [f for f in CATALOGUE if f.cause == cause]) for cause in causes]


def _choose_one(rng: np.random.Generator, among: list[Form]) -> Form:
    return among[int(rng.integers(len(among)))]


def draw_hidden_law(
    rng: np.random.Generator, form: Form, pool: tuple[float, float, float]
) -> HiddenLaw:
    """A form with its shape and a strength in the middle of its range."""
    shape = form.draw(rng)
    if "length" in shape:
        shape |= {"length": pool[0], "width": pool[1]}
    sign = rng.choice([-1, 1]) if form.signed else 1
    return HiddenLaw(form, float(sign * np.sqrt(form.low * form.high)), shape)


def draw_fin(rng: np.random.Generator, robot: Robot, lanes: ParallelTrials) -> HiddenLaw:
    """A fin between marginal and strong stability: slowest rate of return -0.1 to -2.5 1/s."""
    form = _choose_one(rng, [f for f in blades.FORMS if f.cause == FIN_CAUSE])
    shape = form.draw(rng)
    target = -np.exp(rng.uniform(np.log(0.1), np.log(2.5)))
    grid = np.geomspace(form.low, form.high, 70)
    rates = np.array(
        [straight_growth_rate(robot, [HiddenLaw(form, k, shape)], lanes) for k in grid]
    )
    reached = np.flatnonzero(rates < target)
    best = int(reached[0]) if len(reached) else int(rates.argmin())
    return HiddenLaw(form, float(grid[best]), shape)
