"""The glass tank's ideal detector: its sigma is that of the scatter of least-squares fits."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from glass_tank_cases import cause_of, robot_of, trials_of

from validation.generators.glass_tank import camera, detector
from validation.generators.glass_tank.dynamics import Setting, simulate
from validation.generators.glass_tank.form import DT, Clock, Disturbance
from validation.generators.glass_tank.observe import Pose, label_pixels
from validation.generators.glass_tank.weather import Calm, draw_noise, ornstein_uhlenbeck

SECONDS, STEPS, COPIES = 5.0, 210, 240
TIMES = np.arange(int(SECONDS / detector.STEP) + 1) * detector.STEP


class RandomPush:
    """Random tail forces, nothing else."""

    def __init__(self, rng, trials, steps, noise):
        linear, turning = noise["linear_m_s2"], noise["turning_rad_s2"]
        push = ornstein_uhlenbeck(rng, (3, trials), steps + 2, DT, 1 / noise["pole_rad_s"])
        self.push = np.array([linear, linear, turning])[:, None] * push

    def disturbance(self, step, *_):
        return Disturbance(self.push[step], 0.0, 0.0)


def quiet_study():
    """Six trials with a fin and a drag; only tail forces and white errors of the labels matter."""
    rng, robot, coefficients = robot_of(11)
    causes = [cause_of(rng, robot, "tail_fin_lift", "abs_u", 0.8),
              cause_of(rng, robot, "viscous_drag", "linear", 0.6)]  # fmt: skip
    flap = np.array([1, 1, 1, 0.6, 0.6, 0.6])
    trials = trials_of(robot, np.radians([0, 30, -45, 0, -30, 45]), flap)
    quiet = {"water_m_s": 1e-7, "servo_deg": 1e-5, "corner_px": 1e-4, "slow_px": 1e-4,
             "gap_share": 0.0, "outlier_share": 0.0}  # fmt: skip
    noise = draw_noise(rng, robot) | quiet
    study = SimpleNamespace(
        robot=robot, coefficients=coefficients, causes=causes, trials=trials, noise=noise,
        camera=camera.draw_camera(rng, robot.pool, 0.0, fisheye=False), index_stated=1.333,
        fps=1 / detector.STEP, size_stated=np.array(robot.pool), mark_height=0.0,
        label_factor=np.ones(5), weather=Calm(6),
    )  # fmt: skip
    return rng, study


def motion_of(study, parameters, first, trials=None, weather=None):
    setting = Setting(study.robot, study.trials if trials is None else trials, study.causes)
    return simulate(first, STEPS, setting, parameters, weather or study.weather)


def poses(motion):
    """x, y and core direction at the filter's times, (3, times, trials)."""
    return motion.at(np.repeat(TIMES[:, None], motion.states.shape[2], 1))[0][:3]


def pose_sensitivities(study, parameters, first):
    """Changes of the poses with each parameter and with each row of the first pose."""
    base, shared, own = poses(motion_of(study, parameters, first)), [], []
    for j, value in enumerate(parameters):
        more = parameters.copy()
        more[j] += 1e-4 * value
        shared.append((poses(motion_of(study, more, first)) - base) / (1e-4 * value))
    for j in range(3):
        moved = first.copy()
        moved[j] += 1e-5
        own.append((poses(motion_of(study, parameters, moved)) - base) / 1e-5)
    return np.stack(shared), np.stack(own)


def pose_covariance(study, pose, trial):
    """Covariance (times, 3, 3) of a pose (3, times) seen by four labels with white errors."""
    clock = Clock(TIMES, np.zeros(TIMES.size, int), TIMES)
    phi, head = study.trials.phi[trial] + 0 * TIMES, study.trials.head[trial] + 0 * TIMES

    def seen(pose):
        pixels = label_pixels(study, Pose(*pose, phi, head), clock, [0.0, 0.0])[:4]
        return np.concatenate([pixels.real, pixels.imag])

    steps = 1e-6 * np.eye(3)[:, :, None]
    changes = np.stack([(seen(pose + step) - seen(pose)) / 1e-6 for step in steps], axis=-1)
    changes = changes.swapaxes(0, 1)
    variance = study.noise["white_px"] ** 2 + 0.02**2
    return np.linalg.inv(changes.swapaxes(1, 2) @ changes) * variance


def noisy_poses(rng, study, parameters, first):
    """Poses of many copies of the trials with random pushes and starts, (3, times, copies, 6)."""
    many = study.trials.take(np.tile(np.arange(6), COPIES))
    starts = np.tile(first, COPIES)
    starts[3:5] += rng.normal(0, 0.01 * study.robot.body_length, starts[3:5].shape)
    starts[5] += rng.normal(0, 0.02, starts[5].shape)
    push = RandomPush(rng, 6 * COPIES, STEPS, study.noise)
    motion = motion_of(study, parameters, starts, many, push)
    return poses(motion).reshape(3, TIMES.size, COPIES, 6)


def test_sigma_is_that_of_the_scatter_of_least_squares_fits(monkeypatch):
    monkeypatch.setattr(detector, "LABEL_PRIOR", 1e-6)
    rng, study = quiet_study()
    first = np.zeros((6, 6))
    first[:2] = np.array([[0.4], [0.5]]) * np.array(study.robot.pool)[:, None]
    parameters = np.array(study.coefficients + [cause.strength for cause in study.causes])
    true = motion_of(study, parameters, first)
    expected = detector.judge(study, true, np.full(6, SECONDS))[1][7]
    shared, own = pose_sensitivities(study, parameters, first)
    base, noisy = poses(true), noisy_poses(rng, study, parameters, first)
    fisher, right = np.diag([*1 / (2 * parameters[:6]) ** 2, 0, 0]), np.zeros((8, COPIES))
    for i in range(6):
        error = noisy[..., i] - base[:, :, None, i]
        covariance = pose_covariance(study, base[:, :, i], i)
        white = rng.standard_normal((TIMES.size, 3, COPIES))
        seen = error + np.einsum("kij,kjm->ikm", np.linalg.cholesky(covariance), white)
        total = np.zeros((3, TIMES.size, 3, TIMES.size))
        every = np.arange(TIMES.size)
        total[:, every, :, every] = covariance
        total = total.reshape(3 * TIMES.size, -1) + np.cov(error.reshape(-1, COPIES))
        a, b = shared[..., i].reshape(8, -1).T, own[..., i].reshape(3, -1).T
        weight = np.linalg.inv(total)
        weight -= weight @ b @ np.linalg.solve(b.T @ weight @ b, b.T @ weight)  # free first pose
        fisher += a.T @ weight @ a
        right += a.T @ weight @ seen.reshape(-1, COPIES)
    scatter = np.linalg.solve(fisher, right).std(axis=1)[7]
    assert scatter == pytest.approx(expected, rel=0.3)
