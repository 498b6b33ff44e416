"""A session as the ideal detector sees it: what a set of laws and coefficients would show.

A trial is cut into SEGMENTS parts of 2 to 4 body lengths, each with its own starting state, because
a robot without a fin forgets its start within a few body lengths (MODEL.md, 6). An observation is
the labelled centre (x, y in m) and the heading (rad) at SAMPLES instants of a trial, an equal
number in each segment, shape (variants, trials, SAMPLES, 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .dynamics import FAST, SLOW, THETA, Motion, Plant, Unrest, X, Y, flow_at, integrate
from .flow import Setting
from .law import Law
from .robots import Array, Robot
from .trials import Session

SEGMENTS = 4
PER_SEGMENT = 6
SAMPLES = SEGMENTS * PER_SEGMENT
STEPS = 72
"""Steps in a segment."""
STATE_SCALES = ("x", "y", "theta", "surge", "sway", "rate")


@dataclass(frozen=True)
class Variant:
    """Departures from the session's model, the same in every trial.

    coefficients: logarithms of the factors on the six coefficients. fin_area: logarithm of the
    factor on the fin's area; fin_arm: shift in body lengths. start: shifts of x, y, theta, surge,
    sway, yaw rate in units of 0.01 L, rad and U0 (and U0 / L). servo (rad). quality: log factor.
    """

    coefficients: Array = field(default_factory=lambda: np.zeros(6))
    fin_area: float = 0.0
    fin_arm: float = 0.0
    sizes: tuple[float, ...] = ()
    start: Array = field(default_factory=lambda: np.zeros(6))
    servo: float = 0.0
    quality: float = 0.0


@dataclass(frozen=True)
class Experiment:
    """Robot, pool and session."""

    robot: Robot
    pool: tuple[float, float]
    session: Session

    @property
    def start_units(self) -> Array:
        """Units of the shifts of the starting state, (6,)."""
        robot = self.robot
        spin = 1 / robot.body_time
        return 0.01 * np.array([robot.body_length] * 2 + [1.0] + [robot.speed] * 2 + [spin])

    def plant(
        self, variants: Sequence[Variant], laws: Sequence[Law], unrest: Unrest | None = None
    ) -> Plant:
        """All variants as columns: segment by segment, trial by trial, variant by variant."""
        session, robot, count = self.session, self.robot, self.session.count
        times = len(variants)

        def per_trial(values: Array) -> Array:
            return np.tile(np.repeat(values, SEGMENTS), times)

        def per_variant(values: Sequence[float]) -> Array:
            return np.repeat(np.asarray(values, dtype=float), count * SEGMENTS)

        servo = per_variant([v.servo for v in variants])
        setting = Setting(
            per_trial(session.flap), per_trial(session.phi) + servo,
            per_trial(session.head), per_trial(session.order), per_trial(session.duration),
        )  # fmt: skip
        factors = np.exp([v.coefficients for v in variants])
        fin = robot.fin
        area, arm = (fin.area * fin.slope, fin.arm) if fin else (0.0, 0.0)
        sized = tuple(
            replace(law, size=per_variant([v.sizes[k] for v in variants]))
            for k, law in enumerate(laws)
        )
        return Plant(
            robot, self.pool, setting,
            np.repeat((robot.coefficients * factors).T, count * SEGMENTS, axis=1),
            area * np.exp(per_variant([v.fin_area for v in variants])),
            arm + robot.body_length * per_variant([v.fin_arm for v in variants]),
            np.exp(per_variant([v.quality for v in variants])), sized, unrest,
        )  # fmt: skip

    def segment_starts(self, laws: Sequence[Law], sizes: tuple[float, ...]) -> Array:
        """States at the starts of all segments of the undisturbed session, (rows, segments)."""
        plant = self.plant([Variant(sizes=sizes)], laws)
        start = np.repeat(self.session.start, SEGMENTS, axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            motion = integrate(plant, settled(plant, start), SEGMENTS * STEPS, STEPS)
        column = np.arange(start.shape[1])
        return np.asarray(motion.states[column % SEGMENTS, :, column].T)

    def observe(self, variants: Sequence[Variant], laws: Sequence[Law], starts: Array) -> Array:
        """What the variants show from segment starts, (variants, trials, SAMPLES, 3)."""
        shifts = np.array([v.start for v in variants]) * self.start_units
        start = np.tile(starts, len(variants))
        start[:6] += np.repeat(shifts.T, starts.shape[1], axis=1)
        return self.seen(self.plant(variants, laws), start)

    def seen(self, plant: Plant, start: Array) -> Array:
        """Observation of a plant of whole variants."""
        begin = np.arange(start.shape[1]) % SEGMENTS / SEGMENTS
        with np.errstate(over="ignore", invalid="ignore"):
            motion = integrate(
                plant, start, STEPS, STEPS // PER_SEGMENT, part=(begin, 1 / SEGMENTS)
            )
            x, y = labelled_centre(plant, motion)
        shown = np.stack([x, y, motion.states[:, THETA]], axis=-1)[1:]
        shown = shown.reshape(PER_SEGMENT, -1, self.session.count, SEGMENTS, 3)
        shown = np.moveaxis(shown, 0, 3)
        return shown.reshape(shown.shape[0], self.session.count, SAMPLES, 3)


def settled(plant: Plant, start: Array) -> Array:
    """Starting states with the lag states at the quasi-steady coefficient."""
    start = start.copy()
    alpha = flow_at(plant, 0 * plant.setting.duration, start)[0].alpha
    start[SLOW] = start[FAST] = np.sin(2 * alpha)
    return start


def labelled_centre(plant: Plant, motion: Motion) -> tuple[Array, Array]:
    """Design centre in the pool (m), (instants, columns)."""
    x, y = motion.states[:, X], motion.states[:, Y]
    if not plant.of_stage("centre"):
        return x, y
    moved = [
        flow_at(plant, time, state)[1]
        for time, state in zip(motion.times, motion.states, strict=True)
    ]
    forward, port = (np.array([m[i] for m in moved]) for i in (0, 1))
    c, s = np.cos(motion.states[:, THETA]), np.sin(motion.states[:, THETA])
    return x - (forward * c - port * s), y - (forward * s + port * c)
