"""Strengths at which the ideal detector sees a hidden law at the wanted sigma; fins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .articulated import growth_rate
from .form import Form, HiddenLaw, draw_law
from .ideal import StudySetup, detectability_sigmas, sensitivity
from .placing import NoRoomError, PlacedMotion, simulate_from_starts, simulate_placed
from .robots import GUST_KNOTS, ParallelTrials, Robot, with_strengths

Array = NDArray[np.float64]
LEAST, MOST = 10.0, 60.0


class StrengthNotReachableError(Exception):
    """No strength within its bounds is seen at the wanted sigma, or a robot is no good."""


def draw_target_sigma(rng: np.random.Generator) -> float:
    """A wanted sigma, evenly spread in its logarithm within 10 to 60."""
    return float(np.exp(rng.uniform(np.log(12), np.log(52))))


def _slowest_straight_trial(lanes: ParallelTrials) -> ParallelTrials:
    """The slowest lane with a straight short head in still water."""
    lane = lanes.take(np.array([int(np.argmin(lanes.flap))]))
    return replace(lane, angle=np.zeros(1), head=lanes.head.min(keepdims=True),
                   wander=0 * lane.wander[:, :1] + 1e-9, mean=0j * lane.mean,
                   modes=np.zeros((6, 1, 1)),
                   gust=np.zeros((GUST_KNOTS, 1), complex))  # fmt: skip


def straight_growth_rate(lanes: ParallelTrials, robot: Robot, fin: Sequence[HiddenLaw]) -> float:
    """Growth, 1/s, of small deviations from straight swimming at the lowest power."""
    lane = with_strengths(_slowest_straight_trial(lanes), [f.strength for f in fin])
    return growth_rate(lane, robot, fin)


def draw_fin(rng: np.random.Generator, lanes: ParallelTrials, robot: Robot, form: Form,
             pool: tuple[float, float, float]) -> HiddenLaw:  # fmt: skip
    """A fin of 1.05 to 4 times the area at which straight swimming becomes stable.

    Raises: UnsuitableError where no fin makes it stable.
    """
    fin = draw_law(rng, form, pool)
    low, high = form.low, form.high
    if straight_growth_rate(lanes, robot, [replace(fin, strength=high)]) > 0:
        raise StrengthNotReachableError("no stable fin")
    for _ in range(40):
        middle = np.sqrt(low * high)
        stable = straight_growth_rate(lanes, robot, [replace(fin, strength=middle)]) < 0
        low, high = (low, middle) if stable else (middle, high)
    return replace(fin, strength=float(high * np.exp(rng.uniform(np.log(1.05), np.log(4)))))


def with_law_strengths(lanes: ParallelTrials, laws: Sequence[HiddenLaw]) -> ParallelTrials:
    """The lanes with the strengths of the laws."""
    return with_strengths(lanes, [law.strength for law in laws])


def _with_scaled_strength(law: HiddenLaw, factor: float) -> HiddenLaw:
    """The law with another strength within its bounds."""
    s = float(np.clip(law.strength * factor, law.form.low, law.form.high))
    return replace(law, strength=s)


def set_strengths(
    rng: np.random.Generator,
    setup: StudySetup,
    fins: Sequence[HiddenLaw],
    hidden: Sequence[HiddenLaw],
) -> tuple[PlacedMotion, list[HiddenLaw], Array]:
    """Motion, laws and sigmas with each hidden law seen at 10 to 60 sigma.

    Raises: UnsuitableError where strengths at their bounds are seen too well or too badly.
    """
    wanted = [draw_target_sigma(rng) for _ in hidden]
    laws, motion = [*fins, *hidden], None
    for _ in range(7):
        lanes = with_law_strengths(setup.lanes if motion is None else motion.lanes, laws)
        motion = _simulate_inside_pool(rng, setup, lanes, laws, fresh=motion is None)
        if not laws:
            return motion, laws, np.zeros(0)
        found = detectability_sigmas(
            rng, setup, motion, laws, seen=sensitivity(setup, motion, laws)
        )
        own = found[len(fins) :]
        if np.all((own > LEAST) & (own < MOST)) and np.all(own / np.array(wanted) < 1.7):
            return motion, laws, found
        factors = np.clip(np.array(wanted) / np.maximum(own, 1e-9), 0.1, 6)
        after = [*fins, *map(_with_scaled_strength, laws[len(fins) :], factors)]
        if after == laws:
            break
        laws = after
    raise StrengthNotReachableError("no strength is seen as wanted")


def _simulate_inside_pool(
    rng: np.random.Generator,
    setup: StudySetup,
    lanes: ParallelTrials,
    laws: Sequence[HiddenLaw],
    *,
    fresh: bool,
) -> PlacedMotion:
    """Motion from starts drawn once; drawn again where a trial leaves the pool too soon."""
    try:
        if not fresh:
            motion = simulate_from_starts(lanes, setup.robot, laws, setup.pool, setup.wanted)
            if motion.ends.min() >= 4:
                return motion
        return simulate_placed(rng, lanes, setup.robot, laws, pool=setup.pool, wanted=setup.wanted)
    except NoRoomError as error:
        raise StrengthNotReachableError("no room") from error
