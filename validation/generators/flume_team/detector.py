"""Standard deviations at which an ideal user sees each hidden cause.

The motion is linearised about the simulated one. A Kalman filter whitens the observed pose
(x, y, core direction, head angle) with the true covariance of tracking errors and moving water.
The first state of a trial has a wide prior; servo and frequency errors have their true variance.
Fisher information of coefficients, fin and strengths is the sum of products of whitened
sensitivities; sigma is strength over standard deviation with all others projected out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from .footage import Tracker, images, pose_seen, with_faults
from .form import Array, HiddenCause, Lanes
from .gusts import Gusts
from .motion import acting, centre_offset, head_angle, main_forces, rates
from .robots import Fin, Robot
from .view_faults import View

RATE_HZ = 15.0
SERVO_SD, FLAP_SD = float(np.radians(0.3)), 0.003
MOTION, WATER, TRACK = 8, 6, 4
SIZE = MOTION + WATER + TRACK + 2
FIRST_SD = np.array([1, 1, 1, 0.5, 0.5, 1, 1e-6, 1e-6])
"""Prior of the first state, m, rad, m/s, rad/s."""


@dataclass(frozen=True)
class Setting:
    """All that a study consists of, but its motion."""

    lanes: Lanes
    robot: Robot
    hidden: tuple[HiddenCause, ...]
    view: View
    gusts: Gusts
    tracker: Tracker
    fps: float


def _along(grid: Array, states: Array, *, seen: bool) -> Callable[[Setting], Array]:
    """Function of a changed setting: rates (n, 8, trials), or pose (n, 4, trials) if seen."""
    t, moved = grid[:, None], np.moveaxis(states, 1, 0)

    def derivative(changed: Setting) -> Array:
        found = rates(moved, t, changed.lanes, changed.robot, changed.hidden)
        return np.moveaxis(found, 0, 1)

    def pose(changed: Setting) -> Array:
        phi = head_angle(t, changed.lanes, changed.hidden)
        if acting(changed.hidden, "view") or acting(changed.hidden, "depth"):
            view = with_faults(changed.view, changed.hidden)
            pixels = images(
                grid, grid, states, changed.lanes, changed.robot, hidden=changed.hidden, view=view
            )
            return np.moveaxis(pose_seen(pixels, view), 0, 1)
        shift = centre_offset(phi, changed.hidden) * np.exp(1j * moved[2])
        return np.stack([moved[0] - shift.real, moved[1] - shift.imag, moved[2], phi], axis=1)

    return pose if seen else derivative


def _changes(setting: Setting, share: float) -> list[Setting]:
    """Settings with one parameter larger by a share: each coefficient, the fin, each cause."""
    robot = setting.robot
    c = robot.coefficients
    changed = [
        replace(setting, robot=replace(robot, coefficients=replace(c, **{k: v * (1 + share)})))
        for k, v in vars(c).items()
    ]
    fin = robot.fin or Fin("forward_times_sideways", 0.0, 0.42 * robot.body_length, 0.5)
    size = fin.area or 0.01
    larger = replace(fin, area=fin.area + share * size)
    changed.append(replace(setting, robot=replace(robot, fin=larger)))
    for k, h in enumerate(setting.hidden):
        own = list(setting.hidden)
        own[k] = h.scaled(1 + share)
        changed.append(replace(setting, hidden=tuple(own)))
    return changed


def _sensitivities(setting: Setting, grid: Array, states: Array, *, seen: bool) -> Array:
    """Derivatives to relative changes of the shared parameters, (n, rows, trials, parameters)."""
    value, step = _along(grid, states, seen=seen), 0.01
    if seen and not setting.hidden:
        return np.zeros((grid.size, 4, states.shape[2], 7))
    ends = zip(_changes(setting, step), _changes(setting, -step), strict=True)
    return np.stack([(value(a) - value(b)) / (2 * step) for a, b in ends], axis=-1)


def _lane_sensitivity(setting: Setting, grid: Array, states: Array, *, seen: bool) -> Array:
    """Derivatives to head angle (rad) and share of frequency, (n, rows, trials, 2)."""
    value, lanes, step = _along(grid, states, seen=seen), setting.lanes, 1e-3
    parts = []
    for name, size in (("phi", step), ("flap", step * lanes.flap)):
        ends = [replace(setting, lanes=replace(lanes, **{name: getattr(lanes, name) + sign * size}))
                for sign in (1, -1)]  # fmt: skip
        parts.append((value(ends[0]) - value(ends[1])) / (2 * step))
    return np.stack(parts, axis=-1)


def _jacobian(setting: Setting, grid: Array, states: Array) -> Array:
    """Derivatives of the rates to the state, (n, trials, 8, 8)."""
    n, _, trials = states.shape
    matrix, step = np.zeros((n, trials, MOTION, MOTION)), 1e-5
    for k in range(MOTION):
        ends = []
        for sign in (1, -1):
            moved = states.copy()
            moved[:, k] += sign * step
            ends.append(_along(grid, moved, seen=False)(setting))
        matrix[..., k] = np.moveaxis((ends[0] - ends[1]) / (2 * step), 1, 2)
    return matrix


def _system(setting: Setting, grid: Array, states: Array) -> Array:
    """Matrices of motion, water, tracking errors, servo and frequency, (n, trials, 20, 20)."""
    n, _, trials = states.shape
    matrix = np.zeros((n, trials, SIZE, SIZE))
    matrix[..., :MOTION, :MOTION] = _jacobian(setting, grid, states)
    water = slice(MOTION, MOTION + WATER)
    matrix[..., water, water] = block_diag(*[setting.gusts.rates] * 3)
    for k in range(3):
        matrix[..., 3 + k, MOTION + 2 * k] = 1
    for k in range(TRACK):
        row = MOTION + WATER + k
        matrix[..., row, row] = -1 / setting.tracker.memory
    lane = _lane_sensitivity(setting, grid, states, seen=False)
    matrix[..., :MOTION, SIZE - 2 :] = np.moveaxis(lane, 1, 2)
    return matrix


def pose_errors(setting: Setting) -> Array:
    """Slow and white standard deviations of the pose, (2, 4): m, m, rad, rad."""
    camera, robot = setting.view.camera, setting.robot
    metres = camera.place[2] / camera.focal[0]
    back = robot.body_length - robot.head_length
    turn = np.sqrt(2) * metres / back
    bend = np.hypot(turn, np.sqrt(2) * metres / setting.lanes.head.mean())
    share = np.array([metres, metres, turn, bend])
    white = setting.tracker.white * np.sqrt(RATE_HZ / setting.fps)
    return np.outer([setting.tracker.slow, white], share)


def _covariances(setting: Setting, dt: float) -> tuple[Array, Array, Array]:
    """First covariance, step noise (20, 20) and white observation noise (4, 4)."""
    slow, white = pose_errors(setting)
    _, water = setting.gusts.step(dt)
    stationary = np.diag([1.0, setting.gusts.pole**2])
    sizes = setting.gusts.sizes**2
    keep = np.exp(-2 * dt / setting.tracker.memory)
    lane = np.array([SERVO_SD, FLAP_SD]) ** 2
    first = block_diag(np.diag(FIRST_SD**2), *[v * stationary for v in sizes],
                       np.diag(slow**2), np.diag(lane))  # fmt: skip
    noise = block_diag(np.zeros((MOTION, MOTION)), *[v * water for v in sizes],
                       np.diag(slow**2 * (1 - keep)), np.zeros((2, 2)))  # fmt: skip
    return first, noise, np.diag(white**2)


def _steps(system: Array, dt: float) -> tuple[Array, Array]:
    """Transition matrices and their integrals over a step, by series."""
    unit = np.eye(SIZE)
    term = transition = unit + 0 * system
    integral = dt * term
    for k in range(1, 10):
        term = term @ system * (dt / k)
        transition = transition + term
        integral = integral + term * (dt / (k + 1))
    return transition, integral


def fisher_information(setting: Setting, grid: Array, states: Array, ends: Array) -> Array:
    """Information of the relative shared parameters, (p, p). ends: s, last time of each trial."""
    dt = float(grid[1] - grid[0])
    trials = states.shape[2]
    system = _system(setting, grid, states)
    transition, integral = _steps((system[1:] + system[:-1]) / 2, dt)
    push = np.moveaxis(_sensitivities(setting, grid, states, seen=False), 1, 2)
    push = integral[..., :MOTION] @ ((push[1:] + push[:-1]) / 2)
    direct = np.moveaxis(_sensitivities(setting, grid, states, seen=True), 1, 2)
    first, noise, white = _covariances(setting, dt)
    look = np.zeros((TRACK, SIZE))
    look[[0, 1, 2], [0, 1, 2]] = 1
    look[:, MOTION + WATER : MOTION + WATER + TRACK] = np.eye(TRACK)
    looks = np.tile(look, (grid.size, trials, 1, 1))
    lane = np.moveaxis(_lane_sensitivity(setting, grid, states, seen=True), 1, 2)
    looks[..., 3, SIZE - 2 :] = lane[..., 3, :]
    p = direct.shape[-1]
    cover, miss = np.tile(first, (trials, 1, 1)), np.zeros((trials, SIZE, p))
    information = np.zeros((p, p))
    for n in range(grid.size):
        h = looks[n]
        crossed = h @ cover
        spread = crossed @ h.swapaxes(1, 2) + white
        gain = np.linalg.solve(spread, crossed).swapaxes(1, 2)
        innovation = h @ miss + direct[n]
        live = (grid[n] <= ends)[:, None, None]
        weighted = np.linalg.solve(spread, innovation) * live
        information += np.einsum("tip,tiq->pq", innovation, weighted)
        miss, cover = miss - gain @ innovation, cover - gain @ crossed
        if n + 1 < grid.size:
            f = transition[n]
            miss = f @ miss + push[n]
            cover = f @ cover @ f.swapaxes(1, 2) + noise
            cover = (cover + cover.swapaxes(1, 2)) / 2
    return information


def sigmas(setting: Setting, grid: Array, states: Array, ends: Array) -> tuple[float, Array]:
    """Sigma of the fin (0 without one) and of each hidden cause."""
    every = round(1 / (RATE_HZ * (grid[1] - grid[0])))
    stop = int(ends.max() / (grid[1] - grid[0])) + 1
    few = slice(0, stop, every)
    information = fisher_information(setting, grid[few], states[few], ends)
    size = np.sqrt(np.diag(information)) + 1e-9
    inverse = np.linalg.inv(information / np.outer(size, size) + 1e-9 * np.eye(size.size))
    found = size / np.sqrt(np.diag(inverse))
    return float(found[6] if setting.robot.fin else 0.0), found[7:]


def largest_share(setting: Setting, grid: Array, states: Array, ends: Array, k: int) -> float:
    """Force of hidden cause k over the main force of its channels, rms along the trials."""
    hidden = setting.hidden[k]
    if hidden.form.acts_on in {"view", "angle"}:
        return 0.0
    few = slice(0, None, 4)
    t, live = grid[few], grid[few][:, None] <= ends
    path, moved = states[few], np.moveaxis(states[few], 1, 0)
    without = replace(setting, hidden=setting.hidden[:k] + setting.hidden[k + 1 :])
    derivative = _along(t, path, seen=False)
    change = derivative(setting) - derivative(without)
    body = (change[:, 3] + 1j * change[:, 4]) * np.exp(-1j * path[:, 2]) * setting.robot.mass
    extra = {"surge": body.real, "sway": body.imag, "yaw": change[:, 5] * setting.robot.inertia}
    main = main_forces(moved, t[:, None], setting.lanes, setting.robot)
    rms = {c: [np.sqrt(np.mean(v[live] ** 2)) for v in (extra[c], main[c] + 0 * body.real)]
           for c in hidden.form.channels}  # fmt: skip
    return max(e / m for e, m in rms.values())
