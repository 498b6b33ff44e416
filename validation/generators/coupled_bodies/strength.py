"""Strengths at which the ideal detector sees a hidden law at the wanted sigma; fins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .articulated import growth_rate
from .form import Form, Hidden, draw
from .ideal import Setup, sensitivity, sigmas
from .placing import Motion, NoRoomError, placed, run
from .robots import KNOTS, Lanes, Robot, with_sizes

Array = NDArray[np.float64]
LEAST, MOST = 10.0, 60.0


class UnsuitableError(Exception):
    """No strength within its bounds is seen at the wanted sigma, or a robot is no good."""


def target(rng: np.random.Generator) -> float:
    """A wanted sigma, evenly spread in its logarithm within 10 to 60."""
    return float(np.exp(rng.uniform(np.log(12), np.log(52))))


def _straight(lanes: Lanes) -> Lanes:
    """The slowest lane with a straight short head in still water."""
    lane = lanes.take(np.array([int(np.argmin(lanes.flap))]))
    return replace(lane, angle=np.zeros(1), head=lanes.head.min(keepdims=True),
                   wander=0 * lane.wander[:, :1] + 1e-9, mean=0j * lane.mean,
                   modes=np.zeros((6, 1, 1)),
                   gust=np.zeros((KNOTS, 1), complex))  # fmt: skip


def stability(lanes: Lanes, robot: Robot, fin: Sequence[Hidden]) -> float:
    """Growth, 1/s, of small deviations from straight swimming at the lowest power."""
    lane = with_sizes(_straight(lanes), [f.strength for f in fin])
    return growth_rate(lane, robot, fin)


def draw_fin(rng: np.random.Generator, lanes: Lanes, robot: Robot, form: Form,
             pool: tuple[float, float, float]) -> Hidden:  # fmt: skip
    """A fin of 1.05 to 4 times the area at which straight swimming becomes stable.

    Raises: UnsuitableError where no fin makes it stable.
    """
    fin = draw(rng, form, pool)
    low, high = form.low, form.high
    if stability(lanes, robot, [replace(fin, strength=high)]) > 0:
        raise UnsuitableError("no stable fin")
    for _ in range(40):
        middle = np.sqrt(low * high)
        stable = stability(lanes, robot, [replace(fin, strength=middle)]) < 0
        low, high = (low, middle) if stable else (middle, high)
    return replace(fin, strength=float(high * np.exp(rng.uniform(np.log(1.05), np.log(4)))))


def sized(lanes: Lanes, laws: Sequence[Hidden]) -> Lanes:
    """The lanes with the strengths of the laws."""
    return with_sizes(lanes, [law.strength for law in laws])


def _moved_on(law: Hidden, factor: float) -> Hidden:
    """The law with another strength within its bounds."""
    s = float(np.clip(law.strength * factor, law.form.low, law.form.high))
    return replace(law, strength=s)


def set_strengths(
    rng: np.random.Generator, setup: Setup, fins: Sequence[Hidden], hidden: Sequence[Hidden]
) -> tuple[Motion, list[Hidden], Array]:
    """Motion, laws and sigmas with each hidden law seen at 10 to 60 sigma.

    Raises: UnsuitableError where strengths at their bounds are seen too well or too badly.
    """
    wanted = [target(rng) for _ in hidden]
    laws, motion = [*fins, *hidden], None
    for _ in range(7):
        lanes = sized(setup.lanes if motion is None else motion.lanes, laws)
        motion = _motion(rng, setup, lanes, laws, fresh=motion is None)
        if not laws:
            return motion, laws, np.zeros(0)
        found = sigmas(rng, setup, motion, laws, seen=sensitivity(setup, motion, laws))
        own = found[len(fins) :]
        if np.all((own > LEAST) & (own < MOST)) and np.all(own / np.array(wanted) < 1.7):
            return motion, laws, found
        factors = np.clip(np.array(wanted) / np.maximum(own, 1e-9), 0.1, 6)
        after = [*fins, *map(_moved_on, laws[len(fins) :], factors)]
        if after == laws:
            break
        laws = after
    raise UnsuitableError("no strength is seen as wanted")


def _motion(rng: np.random.Generator, setup: Setup, lanes: Lanes, laws: Sequence[Hidden], *,
            fresh: bool) -> Motion:  # fmt: skip
    """Motion from starts drawn once; drawn again where a trial leaves the pool too soon."""
    try:
        if not fresh:
            motion = run(lanes, setup.robot, laws, setup.pool, setup.wanted)
            if motion.ends.min() >= 4:
                return motion
        return placed(rng, lanes, setup.robot, laws, pool=setup.pool, wanted=setup.wanted)
    except NoRoomError as error:
        raise UnsuitableError("no room") from error
