"""How much a hidden law matters: path error after a refit of the published model.

The path is cut into segments of 2.5 body lengths' time at full speed. The six coefficients of the
published model (with the true fin, where there is one) are fitted to the positions in all segments
together by Gauss and Newton's method in their logarithms. The floor is the same error of trials
without the law in moving water, with errors of thrust, and with the noise of a smoothed keypoint;
errors of the servo are left out of it, since the labels show the actual head angle. A law's size is
such that its own error in still water is a drawn multiple of the floor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .form import Family, Law
from .loads import Bench
from .motion import CHI, ROWS, H, P, Path, Z, at_rest, core_direction, integrate
from .robots import Array, Robot
from .trials import Schedule, bench_of, inside
from .water import Unrest

STEP = 1 / 40
LOWEST, HIGHEST = 2.0, 8.0
"""Allowed errors over the floor."""
PRIOR = 1.0
"""Deviation of a coefficient's logarithm."""


@dataclass(frozen=True)
class Gauge:
    """What is needed to judge a law: the trials, the model with its fin, the floor (m)."""

    robot: Robot
    pool: tuple[float, float]
    schedule: Schedule
    floor: float = 0.0


def segment_steps(robot: Robot) -> int:
    """Steps in a segment."""
    return max(8, round(2.5 * robot.body_length / robot.speed / STEP))


def _segments(path: Path, gauge: Gauge) -> tuple[Array, Array]:
    """Start samples and trials of the segments inside pool and duration."""
    steps = segment_steps(gauge.robot)
    starts = np.arange(0, len(path.times) - steps, steps)
    ends = path.times[starts + steps]
    z = path.y[:, Z]
    stays = np.logical_and.accumulate(inside(z, gauge.pool, 0.3 * gauge.robot.body_length), axis=0)
    use = stays[starts + steps] & (ends[:, None] <= gauge.schedule.duration + STEP)
    rows, trials = np.nonzero(use)
    return starts[rows], trials


def _predictor(path: Path, gauge: Gauge, starts: Array, trials: Array) -> tuple[Bench, Array]:
    """Bench and starting unknowns of the model's segments, seven times side by side."""
    schedule, robot = gauge.schedule, gauge.robot
    columns = np.tile(trials, 7)
    bench = Bench(
        robot, gauge.pool, np.zeros((6, len(columns))), schedule.flap[columns],
        phi=schedule.phi[columns], head=schedule.head[columns],
    )  # fmt: skip
    y = np.zeros((ROWS, len(trials)), complex)
    y[Z], y[P] = path.y[starts, Z, trials], robot.mass * path.v[starts, trials]
    y[CHI] = path.psi[starts, trials] - core_direction(0.0, schedule.phi)[trials]
    y[H] = robot.inertia * path.r[starts, trials]
    return bench, np.tile(y, 7)


def refit_error(path: Path, gauge: Gauge) -> float:
    """Root mean square of the path error (m) after the refit."""
    starts, trials = _segments(path, gauge)
    bench, y = _predictor(path, gauge, starts, trials)
    steps, count = segment_steps(gauge.robot), len(trials)
    picks = np.array([steps // 3, 2 * steps // 3, steps])
    seen = path.y[starts + picks[:, None], Z, trials]
    logs, best = np.log(gauge.robot.coefficients), np.inf
    for _ in range(4):
        trial_logs = np.tile(logs, (7, 1))
        trial_logs[1:] += 0.02 * np.eye(6)
        coefficients = np.repeat(np.exp(trial_logs), count, axis=0).T
        model = integrate(replace(bench, coefficients=coefficients), y, steps * STEP, STEP)
        off = (model.y[picks, Z].reshape(3, 7, count) - seen[:, None]).transpose(1, 0, 2)
        flat = np.concatenate([off.real.reshape(7, -1), off.imag.reshape(7, -1)], axis=1)
        error = float(np.sqrt(2 * np.mean(flat[0] ** 2)))
        best = min(best, error) if np.isfinite(error) else best
        jacobian = (flat[1:] - flat[0]).T / 0.02
        weight = 0.1 * error**2 + 1e-12
        normal = jacobian.T @ jacobian + weight / PRIOR**2 * np.eye(6)
        logs = logs - np.clip(np.linalg.solve(normal, jacobian.T @ flat[0]), -0.7, 0.7)
    return best


def simulate(gauge: Gauge, robot: Robot, laws: list[Law], unrest: Unrest | None = None) -> Path:
    """Coarse path of all trials."""
    bench = bench_of(robot, gauge.pool, gauge.schedule, laws=laws, unrest=unrest)
    y = at_rest(bench, gauge.schedule.z, gauge.schedule.psi)
    return integrate(bench, y, float(gauge.schedule.duration.max()), STEP)


def with_floor(gauge: Gauge, unrest: Unrest, point_noise: float) -> Gauge:
    """The gauge with its floor; point_noise: of a smoothed keypoint (m)."""
    held = replace(gauge, schedule=replace(gauge.schedule, servo=0 * gauge.schedule.servo))
    error = refit_error(simulate(held, gauge.robot, [], unrest), held)
    return replace(gauge, floor=float(np.hypot(error, point_noise)))


def fin_error(gauge: Gauge) -> float:
    """Path error (m) of the published model, without a fin, on the robot with its fin."""
    bare = replace(gauge, robot=replace(gauge.robot, fin=None))
    return refit_error(simulate(gauge, gauge.robot, []), bare)


def fin_that_matters(gauge: Gauge, unrest: Unrest, point_noise: float) -> tuple[Gauge, float]:
    """The gauge with floor and a fin enlarged until it matters, and its path error (m)."""
    for _ in range(7):
        gauge = with_floor(gauge, unrest, point_noise)
        error, fin = fin_error(gauge), gauge.robot.fin
        if error > LOWEST * gauge.floor or fin is None:
            break
        larger = replace(fin, area=1.4 * fin.area)
        gauge = replace(gauge, robot=replace(gauge.robot, fin=larger))
    return gauge, error


def sized(rng: np.random.Generator, family: Family, gauge: Gauge) -> tuple[Law, float] | None:
    """A law of the family that matters as drawn, with its path error (m); None where none can."""
    form = str(rng.choice(list(family.forms)))
    sign = float(rng.choice([-1, 1])) if family.odd else 1.0
    shape, target = float(rng.random()), float(np.exp(rng.uniform(np.log(2.3), np.log(7))))
    size = float(np.sqrt(family.low * family.high))
    for _ in range(6):
        law = Law(family, form, sign * size, shape)
        with np.errstate(all="ignore"):
            error = refit_error(simulate(gauge, gauge.robot, [law]), gauge)
        ratio = error / gauge.floor
        if abs(np.log(ratio / target)) < 0.12:
            break
        better = float(np.clip(size * (target / ratio), family.low, family.high))
        if better == size:
            break
        size = better
    return (law, error) if LOWEST <= ratio <= HIGHEST else None
