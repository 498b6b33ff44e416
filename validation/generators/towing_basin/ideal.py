"""The ideal detector: sigma of a hidden cause, all noise known and the baseline refitted.

The motion is linearised about the true path in steps of one knot. A deviation from the baseline
obeys xi' = F xi + b, and z = H xi + d is seen of it: b is the effect of a law over one step, d that
of a measurement error. A Kalman filter with the true covariances (random accelerations, release,
servo, white and correlated tracking errors) whitens it. Six coefficients and the fin's two sizes
are refitted by linear least squares; sigma is the norm of what is left. The log likelihood ratio
has the mean sigma^2 / 2 (Van Trees 1968, Detection, Estimation, and Modulation Theory I, ch. 4).

Augmented state: 6 of the rigid body, 3 accelerations, 1 servo, 4 correlated tracking errors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .filming import FilmedMotion, Scene, mass_offset, perceived_poses, with_measurement_errors
from .form import Array, HiddenCause, ParallelTrials
from .motion import STEP_S, advance
from .robots import COEFFICIENT_NAMES, Robot
from .water import RandomAccelerations

KNOT_STEPS = 4
"""Steps of the integration in a knot, 1/15 s."""
SERVO_STD_RAD = np.radians(0.3)
"""Standard deviation of the servo's error, rad."""
RELATIVE_STD = 0.01
STATE_SIZE = 14
RELEASE_STDS = (0.01, 0.02)
"""Prior standard deviations of place (m) and heading (rad) at release."""
UNOBSERVED_VARIANCE = 1e3
"""Variance (rad^2) of the head angle where it is not to count."""


@dataclass(frozen=True)
class Noise:
    """What is random in a study."""

    unrest: RandomAccelerations
    scene: Scene
    fps: float


def _knots(film: FilmedMotion) -> tuple[Array, Array]:
    """Times (knots,) and states (8, trials, knots)."""
    states = np.moveaxis(film.states[::KNOT_STEPS], 0, -1)
    return np.arange(states.shape[-1]) * KNOT_STEPS * STEP_S, states


def _advance_one_knot(
    t: Array, state: Array, lanes: ParallelTrials, robot: Robot, hidden: Sequence[HiddenCause] = ()
) -> Array:
    """The rigid state (6, ...) a knot later."""
    for j in range(KNOT_STEPS):
        state = advance(t + j * STEP_S, state, lanes, robot, hidden)
    return state[:6]


def _transition(
    t: Array, states: Array, lanes: ParallelTrials, robot: Robot, unrest: RandomAccelerations
) -> Array:
    """F (trials, knots, 14, 14)."""
    base = _advance_one_knot(t, states, lanes, robot)
    F = np.zeros((*states.shape[1:], STATE_SIZE, STATE_SIZE))
    for j, delta in enumerate((1e-4, 1e-4, 1e-4, 1e-5, 1e-5, 1e-5)):
        moved = states.copy()
        moved[j] += delta
        F[..., :6, j] = np.moveaxis(_advance_one_knot(t, moved, lanes, robot) - base, 0, -1) / delta
    turned = replace(lanes, angle=lanes.angle + 1e-4)
    F[..., :6, 9] = np.moveaxis(_advance_one_knot(t, states, turned, robot) - base, 0, -1) / 1e-4
    dt = KNOT_STEPS * STEP_S
    c, s = np.cos(states[2]), np.sin(states[2])
    for row, gain in ((0, dt * dt / 2), (3, dt)):
        F[..., row, 6], F[..., row, 7] = gain * c, -gain * s
        F[..., row + 1, 6], F[..., row + 1, 7] = gain * s, gain * c
    F[..., 2, 8], F[..., 5, 8] = dt * dt / 2, dt
    F[..., [6, 7, 8], [6, 7, 8]] = np.exp(-dt / unrest.memory)
    F[..., 9, 9] = 1
    return F


def pose_covariance(robot: Robot, head: float) -> Array:
    """Covariance (4, 4) of x, y (core axes), heading and head angle for unit errors of points."""
    offsets = np.array([robot.hinge_to_com + head, robot.hinge_to_com, 0.0, -robot.base])
    J = np.zeros((8, 4))
    J[:4, 0] = J[4:, 1] = 1
    J[4:, 2] = offsets
    J[4, 3] = -head
    return np.linalg.inv(J.T @ J)


def whitened(
    F: Array, noise: Noise, film: FilmedMotion, effects: Array, shown: Array, *, blind: bool
) -> Array:
    """Whitened innovations (trials, knots, 4, signals) of effects b (trials, knots, 6, signals)
    and shown errors d (trials, knots, 4, signals). blind: without the head angle.
    """
    trials, knots = F.shape[:2]
    dt = KNOT_STEPS * STEP_S
    tracker, camera = noise.scene.tracker, noise.scene.camera
    metre = (camera.eye[2] / camera.focal[0]) ** 2  # m^2 per px^2
    C = np.array([pose_covariance(film.robot, float(h)) for h in film.lanes.head]) * metre
    fade = np.exp(-dt / tracker.memory)
    F = F.copy()
    F[..., range(10, 14), range(10, 14)] = fade
    Q, P = np.zeros((trials, STATE_SIZE, STATE_SIZE)), np.zeros((trials, STATE_SIZE, STATE_SIZE))
    still = 1 - np.exp(-2 * dt / noise.unrest.memory)
    accelerations = noise.unrest.deviations**2
    Q[:, [6, 7, 8], [6, 7, 8]] = accelerations * still
    Q[:, 10:, 10:] = C * tracker.slow**2 * (1 - fade**2)
    (place, heading), (speed, rate) = RELEASE_STDS, noise.unrest.release
    first = [place, place, heading, speed, speed, rate, *noise.unrest.deviations, SERVO_STD_RAD]
    P[:, range(10), range(10)] = np.square(first)
    P[:, 10:, 10:] = C * tracker.slow**2
    R = C * tracker.white**2 / (noise.fps * dt)
    R[:, 3, 3] += UNOBSERVED_VARIANCE if blind else 0.0
    headings = film.states[::KNOT_STEPS, 2].T
    error = np.zeros((trials, STATE_SIZE, effects.shape[-1]))
    out = np.empty((trials, knots, 4, effects.shape[-1]))
    for j in range(knots):
        H, turn = _observation_matrices(headings[:, j])
        S = H @ P @ H.mT + turn @ R @ turn.mT
        gain = np.linalg.solve(S, H @ P).mT
        innovation = H @ error + shown[:, j]
        out[:, j] = np.linalg.solve(np.linalg.cholesky(S), innovation)
        error = F[:, j] @ (error - gain @ innovation)
        error[:, :6] += effects[:, j]
        keep = np.eye(STATE_SIZE) - gain @ H
        P = keep @ P @ keep.mT + gain @ turn @ R @ turn.mT @ gain.mT
        P = F[:, j] @ P @ F[:, j].mT + Q
    return out


def _observation_matrices(heading: Array) -> tuple[Array, Array]:
    """H (trials, 4, 14) and the turn (trials, 4, 4) of core axes into the pool's."""
    turn = np.tile(np.eye(4), (heading.size, 1, 1))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(heading)
    turn[:, 1, 0] = np.sin(heading)
    turn[:, 0, 1] = -turn[:, 1, 0]
    H = np.zeros((heading.size, 4, STATE_SIZE))
    H[:, :3, :3] = np.eye(3)
    H[:, 3, 9] = 1
    H[:, :, 10:] = turn
    return H, turn


def _perturbed_robots(robot: Robot) -> list[tuple[Robot, float]]:
    """Robots with one size each made larger, and the relative step."""
    k = robot.coefficients
    moved = [
        replace(robot, coefficients=replace(k, **{n: getattr(k, n) * (1 + RELATIVE_STD)}))
        for n in COEFFICIENT_NAMES
    ]
    if robot.fin is not None:
        for name in ("area", "arm"):
            fin = replace(robot.fin, **{name: getattr(robot.fin, name) * (1 + RELATIVE_STD)})
            moved.append(replace(robot, fin=fin))
    return [(m, RELATIVE_STD) for m in moved]


def detectability_sigmas(film: FilmedMotion, noise: Noise, ends: Array) -> Mapping[str, float]:
    """Sigma of each hidden cause, and of the fin as `tail_fin_lift`.

    Each cause is left over from the refitted baseline and the other causes. Trials count up to
    their ends, s. The head angle is not shown where a cause turns the head: the sigma is then that
    of the path alone.
    """
    t, states = _knots(film)
    lanes, robot = film.lanes.columns(), film.robot
    base = _advance_one_knot(t, states, lanes, robot)
    shape = states.shape[1:]
    effects, shown = [], []
    for moved, step in _perturbed_robots(robot):
        effects.append((_advance_one_knot(t, states, lanes, moved) - base) / step)
        shown.append(np.zeros((*shape, 4)))
    baseline = len(effects)
    for h in film.hidden:
        effects.append(_advance_one_knot(t, states, lanes, robot, [h]) - base)
        shown.append(_observed_change(film, noise.scene, h, t))
    if robot.fin is not None:
        effects.append(base - _advance_one_knot(t, states, lanes, replace(robot, fin=None)))
        shown.append(np.zeros((*shape, 4)))
    blind = any(h.form.stage == "angle" for h in film.hidden)
    F = _transition(t, states, lanes, robot, noise.unrest)
    b = np.moveaxis(np.array(effects), (0, 1), (-1, -2))
    white = whitened(F, noise, film, b, np.moveaxis(np.array(shown), 0, -1), blind=blind)
    white[t[None, :] > ends[:, None]] = 0
    flat = white.reshape(-1, white.shape[-1])
    return _residual_norms(
        flat, baseline, [h.form.cause for h in film.hidden], fin=robot.fin is not None
    )


def _residual_norms(
    flat: Array, baseline: int, causes: Sequence[str], *, fin: bool
) -> Mapping[str, float]:
    """Norms of the columns of the causes and the fin beside their refitted rivals."""
    last = baseline + len(causes)
    found = {}
    for j, cause in enumerate(causes, start=baseline):
        rivals = [i for i in range(last) if i != j]
        found[cause] = _residual_norm(flat[:, j], flat[:, rivals])
    if fin:
        rivals = [*range(len(COEFFICIENT_NAMES)), *range(baseline, last)]
        found["tail_fin_lift"] = _residual_norm(flat[:, last], flat[:, rivals])
    return found


def _residual_norm(column: Array, rivals: Array) -> float:
    scale = np.maximum(np.linalg.norm(rivals, axis=0), 1e-12)
    coefficients = np.linalg.lstsq(rivals / scale, column, rcond=1e-9)[0]
    return float(np.linalg.norm(column - rivals / scale @ coefficients))


def _observed_change(film: FilmedMotion, scene: Scene, hidden: HiddenCause, t: Array) -> Array:
    """D (trials, knots, 4) of one cause: what a measurement error adds to the seen poses."""
    if hidden.form.stage == "arm":
        return _mass_shift_offset(film, hidden)
    if hidden.form.stage != "fault":
        return np.zeros((film.lanes.angle.size, t.size, 4))
    views = [with_measurement_errors(scene, causes) for causes in ([hidden], [])]
    wrong, right = (perceived_poses(film, scene, view, t) for view in views)
    return wrong - right


def _mass_shift_offset(film: FilmedMotion, hidden: HiddenCause) -> Array:
    """The label stays where the mass was stated: -s along the core."""
    place = mass_offset(film, [hidden])[:, :, None] * np.stack(
        [np.cos(film.states[::KNOT_STEPS, 2].T), np.sin(film.states[::KNOT_STEPS, 2].T)], axis=-1
    )
    return np.concatenate([-place, np.zeros_like(place)], axis=-1)
