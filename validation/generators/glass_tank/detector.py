"""The ideal detector: how many standard deviations a hidden effect stands above zero.

A Kalman filter linearised about the true path of every trial knows the true model, noise and forms.
It estimates the six coefficients, the strength of every cause, the pose of the camera (from the
pool's marks), the placing of four labels on the body, and each trial's starting state. The
sensitivities of its innovations give the Fisher information; sigma is strength over marginal
standard deviation. The prior of the placing of the labels is wider than their errors, so that a
wrong size of the pool does not show in the length of the body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .design import Study
from .dynamics import Motion, Setting, rates, three_eighths
from .form import Array, Clock, Disturbance, Quantity, Situation, Trials, act
from .observe import Pose, corner_marks, frame_times, label_pixels

STEP = 0.12
"""Step of the filter, s."""
LABEL_PRIOR = 0.0015
"""Standard deviation of the placing of the labels, body lengths."""
FREQUENCY_ERROR = 0.003
"""Relative error of the stated flapping frequency, by which the recoil dates the frames."""
PLACES_OF_MOTION = {"motor", "servo", "flow", "thrust", "plate", "load", "inertia"}
PLACES_OF_LABELS = {"servo", "body", "depth", "lens", "pixel"}
RANDOM = 14
"""Random states: push (3), water (2), servo (1), slow errors of the labels (8)."""
NUISANCE = 14
"""Pose of the camera (6) and placing of the labels (8)."""


def head_angle(
    study: Study, t: Array, trials: Trials, servo: Quantity, strengths: Sequence[float] | Array
) -> Array:
    """Actual head angle (rad) at motor times t (s)."""
    now = Situation(t, trials, study.robot, phi=trials.phi + servo)
    act("servo", now, study.causes, strengths)
    return now.phi


def judge(study: Study, motion: Motion, durations: Array) -> tuple[Array, Array]:
    """Sigma of every cause, and standard deviations of coefficients and strengths."""
    fisher = information(study, motion, durations)
    scale = 1 / np.sqrt(np.diag(fisher))
    std = np.sqrt(np.diag(np.linalg.inv(fisher * np.outer(scale, scale)))) * scale
    n = len(study.causes)
    return np.abs([cause.strength for cause in study.causes]) / std[6 : 6 + n], std[: 6 + n]


@dataclass(frozen=True)
class Path:
    """The true path at the steps of the filter; steps and trials are one axis.

    grid: numbers of steps and of trials. start, end: motor times of the step, s.
    """

    study: Study
    setting: Setting
    parameters: Array
    grid: tuple[int, int]
    states: Array
    rates: Array
    disturbance: Disturbance
    clock: Clock
    end: Array

    @property
    def start(self) -> Array:
        """Motor times at which the steps begin, s."""
        return self.clock.t

    def after(self, states: Array, parameters: Array, disturbance: Disturbance) -> Array:
        """States one step of the filter later."""
        dt = (self.end - self.start) / 2

        def rate(t: Quantity, y: Array) -> Array:
            return rates(t, y, self.setting, parameters, disturbance)

        for half in range(2):
            states = three_eighths(rate, self.start + half * dt, states, dt)
        return states

    def seen(
        self,
        states: Array,
        parameters: Array,
        servo: Array,
        late: Quantity = 0.0,
        **changes: Any,
    ) -> Array:
        """Pixels of the first four labels, (8, n); late: s, changes: those of `label_pixels`."""
        t, trials = self.start + late, self.setting.trials
        phi = head_angle(self.study, t, trials, servo, parameters[6:])
        pose = Pose(states[0], states[1], states[2], phi, trials.head)
        clock = replace(self.clock, t=t)
        pixels = label_pixels(self.study, pose, clock, parameters[6:], **changes)[:4]
        return np.concatenate([pixels.real, pixels.imag])


def _path(study: Study, motion: Motion, durations: Array) -> Path:
    """The path sampled at the steps of the filter."""
    parameters = np.array(study.coefficients + [c.strength for c in study.causes], float)
    steps, n = int(max(durations) / STEP) + 1, study.robot.trials
    stated = np.repeat((np.arange(steps) * STEP)[:, None], n, 1)
    trial = np.broadcast_to(np.arange(n), stated.shape)
    start = frame_times(stated, trial, study.causes, parameters[6:])
    end = frame_times(stated + STEP, trial, study.causes, parameters[6:]).ravel()
    states, changes = (a.reshape(len(a), -1) for a in motion.at(start))
    clock = Clock(stated.ravel(), trial.ravel(), start.ravel())
    setting = Setting(study.robot, study.trials.take(clock.trial), study.causes)
    servo, drift = study.weather.servo_and_drift(clock.t, states[0], states[1], clock.trial)
    disturbance = Disturbance(np.zeros((3, 1)), drift, servo)
    return Path(study, setting, parameters, (steps, n), states, changes, disturbance, clock, end)


def _state_sensitivities(path: Path) -> tuple[Array, Array]:
    """Transition (n_a, n_a, n) and observation (8, n_a, n) of states and random states."""
    robot, states, calm = path.study.robot, path.states, path.disturbance
    own, n = states.shape
    base = path.after(states, path.parameters, calm)
    seen = path.seen(states, path.parameters, calm.servo)
    transition = np.zeros((own + RANDOM, own + RANDOM, n))
    look = np.zeros((8, own + RANDOM, n))
    speed, turn = robot.top_speed, robot.reference_yaw_rate
    size = np.array([robot.body_length] * 2 + [1.0] + [speed] * 2 + [turn] + [1.0] * (own - 6))
    for j, step in enumerate(size * 1e-6):
        moved = states.copy()
        moved[j] += step
        transition[:own, j] = (path.after(moved, path.parameters, calm) - base) / step
        if j < 3:
            look[:, j] = (path.seen(moved, path.parameters, calm.servo) - seen) / step

    def change(disturbance: Disturbance, step: float) -> Array:
        return (path.after(states, path.parameters, disturbance) - base) / step

    for j in range(3):
        push = np.zeros((3, 1))
        push[j] = 1e-4
        transition[:own, own + j] = change(replace(calm, push=push), 1e-4)
    for j, way in enumerate((1e-6, 1e-6j)):
        transition[:own, own + 3 + j] = change(replace(calm, drift=calm.drift + way), 1e-6)
    servo = calm.servo + 1e-6
    transition[:own, own + 5] = change(replace(calm, servo=servo), 1e-6)
    look[:, own + 5] = (path.seen(states, path.parameters, servo) - seen) / 1e-6
    look[:, own + 6 :] = np.eye(8)[:, :, None]
    return transition, look


def _by_parameter(path: Path, j: int, seen: Array) -> tuple[Quantity, Quantity, Quantity]:
    """Derivatives of states, labels and marks to parameter j; 0 where it has no effect."""
    study, states, calm, clock = path.study, path.states, path.disturbance, path.clock
    value = abs(path.parameters[j])
    step = 1e-4 * value if j < 6 else 1e-3 * value
    more, less = path.parameters.copy(), path.parameters.copy()
    more[j], less[j] = path.parameters[j] + step, path.parameters[j] - step
    places = set(study.causes[j - 6].family.laws) if j >= 6 else {"plate"}
    moved: Quantity = 0.0
    labels: Quantity = 0.0
    marks: Quantity = 0.0
    if places & PLACES_OF_MOTION:
        moved = (path.after(states, more, calm) - path.after(states, less, calm)) / (2 * step)
    if places & PLACES_OF_LABELS:
        ends = [path.seen(states, p, calm.servo) for p in (more, less)]
        labels = (ends[0] - ends[1]) / (2 * step)
    if "clock" in places:
        times = [frame_times(clock.stated, clock.trial, study.causes, p[6:]) for p in (more, less)]
        late = (times[0] - times[1]) / (2 * step) * 1e-4
        shifted = states + path.rates * late
        labels = (path.seen(shifted, path.parameters, calm.servo, late) - seen) / 1e-4
    if places & {"lens", "corners"}:
        ends = [corner_marks(study, p[6:]) for p in (more, less)]
        marks = ((ends[0] - ends[1]) / (2 * step)).ravel()
    return moved, labels, marks


def _parameter_sensitivities(path: Path) -> tuple[Array, Array, Array]:
    """Derivatives of states (n_a, n_p, n), labels (8, n_p, n) and marks (8, n_p)."""
    study, (own, n), parameters = path.study, path.states.shape, path.parameters
    shared = len(parameters)
    servo = path.disturbance.servo
    seen = path.seen(path.states, parameters, servo)
    corners = corner_marks(study, parameters[6:]).ravel()
    moved = np.zeros((own + RANDOM, shared + NUISANCE, n))
    labels, marks = np.zeros((8, shared + NUISANCE, n)), np.zeros((8, shared + NUISANCE))
    for j in range(shared):
        moved[:own, j], labels[:, j], marks[:, j] = _by_parameter(path, j, seen)
    for j in range(6):
        pose = np.zeros(6)
        pose[j] = 1e-5
        with_pose = path.seen(path.states, parameters, servo, pose_change=pose)
        labels[:, shared + j] = (with_pose - seen) / 1e-5
        changed = corner_marks(study, parameters[6:], pose).ravel()
        marks[:, shared + j] = (changed - corners) / 1e-5
    for j in range(8):
        misplaced = np.zeros(4, complex)
        misplaced[j % 4] = 1e-5 * (1 if j < 4 else 1j)
        with_shift = path.seen(path.states, parameters, servo, misplaced=misplaced)
        labels[:, shared + 6 + j] = (with_shift - seen) / 1e-5
    return moved, labels, marks


def information(study: Study, motion: Motion, durations: Array) -> Array:
    """Fisher information of the six coefficients, strengths, pose (6) and labels (8)."""
    durations = np.asarray(durations)
    path = _path(study, motion, durations)
    transition, look = _state_sensitivities(path)
    moved, labels, marks = _parameter_sensitivities(path)
    per_step = [
        np.ascontiguousarray(np.moveaxis(a.reshape(*a.shape[:2], *path.grid), (2, 3), (0, 1)))
        for a in (transition, look, moved, labels)
    ]
    fisher = _filter(study, per_step, durations)
    fisher += marks.T @ marks / study.noise["corner_px"] ** 2
    fisher[np.arange(6), np.arange(6)] += 1 / (2 * path.parameters[:6]) ** 2
    placing = np.arange(len(fisher) - 8, len(fisher))
    fisher[placing, placing] += 1 / (LABEL_PRIOR * study.robot.body_length) ** 2
    for j, cause in enumerate(study.causes):
        if cause.family.name == "clock_error":
            every = np.arange(study.robot.trials)
            share = (durations / 10) ** 2 if cause.form == "drift" else 1.0
            weight = np.isin(every, cause.shape.get("trials", every)) * share
            fisher[6 + j, 6 + j] += np.sum(weight) / FREQUENCY_ERROR**2
    return fisher


def _random_states(study: Study) -> tuple[Array, Array]:
    """Decay over a step and stationary variance of the random states."""
    noise = study.noise
    push = np.exp(-STEP * noise["pole_rad_s"])
    water, servo = (np.exp(-STEP / noise[key]) for key in ("water_tau_s", "servo_tau_s"))
    label = np.exp(-STEP / noise["slow_tau_s"])
    decay = np.array([push] * 3 + [water] * 2 + [servo] + [label] * 8)
    slow = noise["slow_px"] * np.tile(study.label_factor[:4], 2)
    std = [noise["linear_m_s2"]] * 2 + [noise["turning_rad_s2"]]
    std += [noise["water_m_s"] / np.sqrt(2)] * 2 + [np.radians(noise["servo_deg"]), *slow]
    return decay, np.array(std) ** 2


def _first_variance(study: Study, own: int) -> Array:
    """Variance of the starting states."""
    robot = study.robot
    std = [0.3 * robot.pool[0]] * 2 + [0.5] + [0.01 * robot.body_length] * 2 + [0.02]
    return np.array(std + [0.0] * (own - 6)) ** 2


def _white_noise(study: Study) -> Array:
    """Covariance of the labels averaged over a step, px2."""
    noise = study.noise
    frames = max(1.0, study.fps * STEP) * (1 - noise["gap_share"] - noise["outlier_share"])
    white = noise["white_px"] * np.tile(study.label_factor[:4], 2)
    return np.diag(white**2 / frames + 0.02**2)


def _filter(study: Study, per_step: Sequence[Array], durations: Array) -> Array:
    """Sum over steps and trials of the weighted squares of the innovations' sensitivities.

    per_step: transition, observation, and sensitivities of states and labels; (steps, trials, ...).
    """
    transition, look, moved, labels = per_step
    steps, n, size = transition.shape[:3]
    shared, own = moved.shape[3], size - RANDOM
    decay, variance = _random_states(study)
    rows, every = np.arange(own, size), np.arange(size)
    transition[:, :, rows, rows] = decay
    fresh = np.zeros(size)
    fresh[own:] = variance * (1 - decay**2)
    cover = np.zeros((n, size, size))
    cover[:, every, every] = np.concatenate([_first_variance(study, own), variance])
    white = _white_noise(study)
    miss, fisher = np.zeros((n, size, shared)), np.zeros((shared, shared))
    for k in range(steps):
        live = np.flatnonzero(k * STEP <= durations)
        if not len(live):
            break
        ahead, h = transition[k, live], look[k, live]
        crossed = h @ cover[live]
        spread = crossed @ h.transpose(0, 2, 1) + white
        innovation = h @ miss[live] + labels[k, live]
        solved = np.linalg.solve(spread, np.concatenate([crossed, innovation], axis=2))
        fisher += np.einsum("nij,nik->jk", innovation, solved[:, :, size:])
        gain = crossed.transpose(0, 2, 1)
        filtered = ahead @ (cover[live] - gain @ solved[:, :, :size]) @ ahead.transpose(0, 2, 1)
        filtered = 0.5 * (filtered + filtered.transpose(0, 2, 1))
        filtered[:, every, every] += fresh
        missed = miss[live] - gain @ solved[:, :, size:]
        cover[live], miss[live] = filtered, ahead @ missed + moved[k, live]
    return fisher
