"""An ideal detector: Fisher information of hidden strengths, all forms and noises being known.

It sees head tip, hinge, core centre and tail base at 15 Hz. Projected out: the six coefficients,
the fin, the other hidden laws, six starting states, the errors of servo and flapping frequency and
the gusts of each trial, and the errors of the labels. By finite differences of the simulator.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from . import evidence
from .articulated import laws_of_stage, simulate_motion
from .camera import with_fitted_pose
from .form import HiddenLaw
from .placing import PlacedMotion
from .robots import FLAP_STD, GUST_KNOTS, SERVO_STD, ParallelTrials, Robot
from .scene import (
    Scene,
    body_points,
    exposure_times,
    keypoint_depth,
    pixels_after_camera_shift,
    stated_setup,
    with_label_bias,
)
from .tracking import Tracker, error_covariance
from .water import WaterMotion, gust_covariance

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
OBSERVATION_RATE_HZ = 15.0
LABEL_STD = 3e-4
MOTION_STAGES = ("force", "memory", "thrust", "drive", "servo", "water", "inertia", "mass", "sink")


@dataclass(frozen=True)
class StudySetup:
    """What a study consists of beside its hidden laws; wanted: durations, s."""

    robot: Robot
    lanes: ParallelTrials
    pool: tuple[float, float, float]
    scene: Scene
    tracker: Tracker
    sea: WaterMotion
    fps: float
    wanted: Array
    logged: bool


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of what is seen, (times, 4, trials, columns), complex, m; times in s.

    Columns: coefficients and laws, `shared` of them; then starts, servo, frequency and gusts.
    """

    times: Array
    seen: Complex
    slopes: Complex
    shared: int


def _perturbed_lanes(lanes: ParallelTrials, count: int) -> tuple[ParallelTrials, Array]:
    """All trials, unchanged and with each parameter moved in turn; the sizes of the steps."""
    n = lanes.count
    columns = 6 + count + 8 + 2 * GUST_KNOTS
    many = lanes.take(np.tile(np.arange(n), columns + 1))
    grid = [replace(many)]
    step = np.ones((columns, n))
    view = {name: getattr(grid[0], name).reshape(*getattr(lanes, name).shape[:-1], columns + 1, n)
            for name in ("coef", "size", "start", "angle", "flap", "gust")}  # fmt: skip
    targets = [(view["coef"][i], 1e-3 * lanes.coef[i]) for i in range(6)]
    targets += [(view["size"][i], 0.02 * lanes.size[i]) for i in range(count)]
    targets += [(view["start"][i], np.full(n, 1e-4)) for i in range(6)]
    targets += [(view["angle"], np.full(n, 1e-3)), (view["flap"], 1e-3 * lanes.flap)]
    targets += [(view["gust"][i], np.full(n, 1e-4)) for i in range(GUST_KNOTS)]
    targets += [(view["gust"][i], 1j * np.full(n, 1e-4)) for i in range(GUST_KNOTS)]
    for j, (array, by) in enumerate(targets):
        array[j + 1] += by
        step[j] = np.abs(by)
    return grid[0], step


def sensitivity(setup: StudySetup, motion: PlacedMotion, laws: Sequence[HiddenLaw]) -> Sensitivity:
    """Derivatives by one run of all trials with all parameters moved."""
    own = [law for law in laws if law.form.stage in MOTION_STAGES]
    lanes, step = _perturbed_lanes(motion.lanes, len(own))
    seconds = float(motion.ends.max())
    times = np.arange(0, seconds, 1 / OBSERVATION_RATE_HZ)
    film = simulate_motion(lanes, setup.robot, own, seconds + 0.05)
    points = body_points(film.at(times), lanes, setup.robot, own, times)
    if laws_of_stage(own, "sink"):
        depth = keypoint_depth(setup.robot, lanes, own, times)[:, None]
        camera = setup.scene.camera
        level = camera.surface(points, depth, rounds=3)
        points = camera.cast(level[..., 0] + 1j * level[..., 1], setup.robot.depth)
    points = points.reshape(len(times), 4, -1, motion.lanes.count)
    slopes = (points[:, :, 1:] - points[:, :, :1]) / step
    return Sensitivity(times, points[:, :, 0], slopes.transpose(0, 1, 3, 2), 6 + len(own))


def fault_signal(
    setup: StudySetup, motion: PlacedMotion, laws: Sequence[HiddenLaw], times: Array
) -> Complex:
    """Change of the places seen, m, (times, 4, trials), that the faults among the laws cause."""
    camera, robot, said = (
        setup.scene.camera,
        setup.robot,
        stated_setup(setup.scene, setup.robot, laws),
    )
    lens = replace(camera, matrix=said.matrix, distortion=said.distortion, index=said.index)
    believed = with_fitted_pose(lens, said.pool, setup.scene.height, said.marks)
    physical = [law for law in laws if law.form.stage in MOTION_STAGES]
    out = []
    for k in range(motion.lanes.count):
        lane = motion.lanes.take(np.array([k]))
        at = exposure_times(laws, times, k, motion.lanes.count)
        states = [
            replace(
                motion.film,
                states=motion.film.states[:, :, k : k + 1],
                rates=motion.film.rates[:, :, k : k + 1],
            ).at(t)
            for t in (times, at)
        ]
        true, seen = [body_points(s, lane, robot, physical, t)[..., 0]
                      for s, t in zip(states, (times, at), strict=True)]  # fmt: skip
        seen = with_label_bias(seen, lane.angle + 0 * times, laws)
        depth = keypoint_depth(robot, lane, laws, times)
        px = pixels_after_camera_shift(camera.see(seen, depth), times, k, laws, camera)
        out.append(believed.back(px, said.depth, seen) - true)
    return np.stack(out, -1)


def detectability_sigmas(
    rng: np.random.Generator,
    setup: StudySetup,
    motion: PlacedMotion,
    laws: Sequence[HiddenLaw],
    *,
    seen: Sensitivity | None = None,
) -> Array:
    """Strength over its standard deviation, for every law; the fin is one of them."""
    own = [law for law in laws if law.form.stage in MOTION_STAGES]
    rest = [law for law in laws if law.form.stage not in MOTION_STAGES]
    seen = seen or sensitivity(setup, motion, own)
    extra = np.zeros((*seen.seen.shape, 0), complex)
    if rest:
        signal = fault_signal(setup, motion, laws, seen.times)
        extra = signal[..., None] / rest[0].strength
    order = own + rest
    total = _information(rng, setup, motion, seen, extra)
    for i, law in enumerate(order):
        total[6 + i, 6 + i] += evidence.direct_information(
            law, motion, setup.tracker, setup.scene, logged=setup.logged
        )
    scale = 1 / np.sqrt(np.diag(total))
    spread = np.linalg.inv(total * scale * scale[:, None])
    std = scale * np.sqrt(np.diag(spread))
    found = {id(law): law.strength / std[6 + i] for i, law in enumerate(order)}
    return np.array([found[id(law)] for law in laws])


def _information(
    rng: np.random.Generator,
    setup: StudySetup,
    motion: PlacedMotion,
    seen: Sensitivity,
    extra: Complex,
) -> Array:
    """Information of the shared parameters: coefficients, laws, faults and the eight labels."""
    camera = setup.scene.camera
    metre = camera.place[2] / camera.matrix[0, 0]
    noise = error_covariance(setup.tracker, seen.times, OBSERVATION_RATE_HZ / setup.fps) * metre**2
    root = np.linalg.cholesky(noise)
    shared = seen.shared + extra.shape[-1] + 8
    total = np.zeros((shared, shared))
    total[-8:, -8:] = np.eye(8) / LABEL_STD**2
    for k, end in enumerate(motion.ends):
        n = int(np.count_nonzero(seen.times < end))
        labels = _label_slopes(seen.seen[:n, :, k])
        columns = np.concatenate([seen.slopes[:n, :, k, : seen.shared], extra[:n, :, k], labels,
                                  seen.slopes[:n, :, k, seen.shared :]], -1)  # fmt: skip
        flat = np.concatenate([columns.real, columns.imag], 1).reshape(n, -1)
        white = solve_triangular(root[:n, :n], flat, lower=True).reshape(-1, columns.shape[-1])
        total += _project_out(
            white.T @ white, shared, _trial_prior_information(rng, setup, motion, seen, k=k, n=n)
        )
    return total


def _label_slopes(points: Complex) -> Complex:
    """Derivatives (times, 4, 8) by the labels' displacements along and across head and core."""
    nose, axis = points[:, 0] - points[:, 1], points[:, 1] - points[:, 3]
    out = np.zeros((*points.shape, 8), complex)
    for i in range(4):
        way = nose if i == 0 else axis
        out[:, i, 2 * i] = way / np.abs(way)
        out[:, i, 2 * i + 1] = 1j * out[:, i, 2 * i]
    return out


def _trial_prior_information(
    rng: np.random.Generator,
    setup: StudySetup,
    motion: PlacedMotion,
    seen: Sensitivity,
    *,
    k: int,
    n: int,
) -> Array:
    """Prior information of the parameters of one trial: starts, servo, frequency, gusts."""
    start = 1 / np.array([1.0, 1, 1, 0.05, 0.05, 0.2]) ** 2
    errors = 1 / np.array([SERVO_STD, FLAP_STD * motion.lanes.flap[k]]) ** 2
    gusts = gust_covariance(rng, setup.sea, seen.seen[:n, 2, k], seen.times[:n])
    out = np.zeros((8 + 2 * GUST_KNOTS, 8 + 2 * GUST_KNOTS))
    out[:8, :8] = np.diag(np.concatenate([start, errors]))
    out[8:, 8:] = np.linalg.inv(gusts)
    return out


def _project_out(whole: Array, shared: int, prior: Array) -> Array:
    """Information of the first `shared` parameters with the others projected out."""
    cross = whole[:shared, shared:]
    inner = cho_factor(whole[shared:, shared:] + prior)
    return np.asarray(whole[:shared, :shared] - cross @ cho_solve(inner, cross.T))
