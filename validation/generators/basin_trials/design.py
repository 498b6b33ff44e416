"""A study before it is filmed: robot, trials, water, noise, and the laws with their sizes.

The floor of a study is the root of the sum of squares of (1) the path error with moving water and
errors of servo and frequency alone, and (2) the noise of a tracked point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .camera import Camera, draw_camera
from .catalogue import CAUSES, draw_law
from .form import Array, HiddenLaw, Runs
from .keypoints import Noise, draw_noise
from .plan import CLEAR, FAINT, PAIR, UNLISTED_GROUP, Plan
from .refit import RefitBench
from .robots import Robot, draw_fin, draw_robot
from .trials import MARGIN, WALL_MARGIN, draw_starts, draw_trials
from .water import ResidualWater

TARGETS = {CLEAR: (4.0, 7.0), FAINT: (2.2, 3.2), PAIR: (3.5, 6.0), UNLISTED_GROUP: (4.0, 7.0)}
"""Wanted path error of a law over the floor."""
REACHED_RANGE = (0.6, 2.5)
"""Path error over the wanted one between which a law is kept."""
LEAST_FIN_ERROR = 3
"""Path error over the floor that a fin leaves at least."""
MAX_ATTEMPTS, SAME_LAW_ATTEMPTS = 7, 3
"""Draws of a study, and those after which another law takes the place of one that is too weak."""
MAX_SIZES = 8
SIZE_TOLERANCE = 0.12


@dataclass(frozen=True)
class StudySetup:
    """All that is drawn for a study but its hidden laws; arrays are (trials,).

    runs, true_runs: as commanded, and with the errors of servo (rad) and frequency (relative).
    duration: s. power: %. start: first states (8, trials). first_turn: of the shaft. tail_phase:
    between shaft and tail, rad. floor, fin_error: m, the latter left by the model without the fin.
    """

    robot: Robot
    camera: Camera
    noise: Noise
    runs: Runs
    true_runs: Runs
    duration: Array
    power: Array
    start: Array
    servo_error: Array
    flap_error: Array
    bench: RefitBench
    water: ResidualWater
    floor: float
    first_turn: Array
    tail_phase: float
    fin_error: float = 0.0

    @property
    def trials(self) -> int:
        """Number of trials."""
        return len(self.duration)


def draw_setup(rng: np.random.Generator, names: Sequence[str], *, fin: bool) -> StudySetup:
    """A study that is to hide these laws, and the bench on which they get their sizes."""
    robot, camera = draw_robot(rng), draw_camera(rng)
    if fin:
        robot = replace(robot, fin=draw_fin(rng, robot))
    pixels_per_m = camera.focal[0] / camera.position[2]
    noise = draw_noise(rng, pixels_per_m)
    runs, duration, power = draw_trials(rng, robot, names)
    margin = WALL_MARGIN if "wall_effect" in names else MARGIN
    start = draw_starts(rng, robot, runs, duration, margin=margin)
    count = len(duration)
    servo, flap = rng.normal(0, np.radians(0.3), count), rng.normal(0, 0.003, count)
    point = noise.point_error(pixels_per_m)
    bench = RefitBench(robot, runs, start, duration, noise=point, camera=camera.position)
    water = ResidualWater(rng, count, noise.water_rms_m_s)
    true_runs = replace(runs, phi=runs.phi + servo, flap=runs.flap * (1 + flap))
    floor = float(np.hypot(point, bench.path_error((), true_runs, water)))
    return StudySetup(
        robot, camera, noise, runs, true_runs, duration, power, start, servo, flap, bench, water,
        floor, first_turn=rng.random(count), tail_phase=rng.uniform(0, 2 * np.pi),
    )  # fmt: skip


def draw_hidden(rng: np.random.Generator, plan: Plan) -> tuple[StudySetup, list[HiddenLaw]]:
    """Set-up and laws with sizes.

    A draw is repeated where a law or the fin is too weak; at last another law is taken.
    """
    names = plan.names
    for attempt in range(MAX_ATTEMPTS):
        setup = draw_setup(rng, names, fin=plan.fin)
        sized = [_draw_sized_law(rng, setup, name, plan.group) for name in names]
        laws, weak = [law for law, _ in sized], {law.name for law, reached in sized if not reached}
        if plan.fin:
            bare = setup.bench.judged_by(replace(setup.robot, fin=None))
            setup = replace(setup, fin_error=bare.path_error())
        hidden_fin = plan.fin and setup.fin_error < LEAST_FIN_ERROR * setup.floor
        if not weak and not hidden_fin and np.isfinite(setup.bench.path(laws)).all():
            break
        if attempt >= SAME_LAW_ATTEMPTS and plan.group != UNLISTED_GROUP:
            others = [str(c) for c in rng.permutation(CAUSES) if c not in names]
            names = tuple(others.pop() if n in weak else n for n in names)
    return setup, laws


def _draw_sized_law(
    rng: np.random.Generator, setup: StudySetup, name: str, group: str
) -> tuple[HiddenLaw, bool]:
    """A law with its size, and whether it reaches the path error wanted for the group."""
    target = rng.uniform(*TARGETS[group]) * setup.floor
    law = fit_size(setup.bench, draw_law(rng, name), target)
    low, high = REACHED_RANGE
    return law, bool(low * target < law.path_error < high * target)


def fit_size(bench: RefitBench, law: HiddenLaw, target: float) -> HiddenLaw:
    """The law with the size whose path error is `target` (m), or with the largest plausible one.

    By proportion, and by bisection of the logarithm once the size is enclosed.
    """
    limit, sign = law.family.limit, np.sign(law.size)
    size, low, high = abs(law.size), None, None
    best = None
    for _ in range(MAX_SIZES):
        tried = law.sized(float(sign * size))
        error = bench.path_error([tried])
        if best is None or abs(np.log(error / target)) < abs(np.log(best.path_error / target)):
            best = replace(tried, path_error=error)
        if abs(error / target - 1) < SIZE_TOLERANCE or (size >= limit and error < target):
            break
        low, high = (size, high) if error < target else (low, size)
        if low and high:
            size = float(np.sqrt(low * high))
        else:
            size = min(limit, size * float(np.clip(target / max(error, 1e-6), 0.25, 4.0)))
    return best or law
