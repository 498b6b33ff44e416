"""What the camera sees of the robot, and what a reader of the study makes of it.

``StudyTruth`` holds the truth; ``stated_camera`` is the camera that study.yaml describes. Without
an effect of channel ``report`` or ``observe`` the two agree.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from .camera import Camera, pixels_to_pool, pool_corners, project, to_pixels, with_fitted_pose
from .dynamics import Robot, StudyWorld, Trials
from .effects import centre_of_mass_shift
from .noise import Noise

KEYPOINT_NAMES = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class StudyTruth:
    """The truth of one study."""

    world: StudyWorld
    trials: Trials
    noise: Noise
    gusts: np.ndarray
    camera: Camera
    fps: float
    corner_height: float
    homography: bool

    def report(self, name: str, shape: int | None = None) -> float:
        """Signed strength of a reporting or observation error, 0 where it is absent."""
        for h in self.world.hidden:
            if h.form.name == name and (
                shape is None or int(h.constants.get("shape", -1)) == shape
            ):
                return h.strength * h.constants["side"]
        return 0.0


def stated_pool(study: StudyTruth) -> tuple[float, float]:
    """Length and width (m) that study.yaml states."""
    L, W = study.world.pool
    both, length = study.report("scale_error", 0), study.report("scale_error", 1)
    return L * (1 + both + length), W * (1 + both)


def stated_optics(study: StudyTruth) -> tuple[float, float]:
    """Depth of the keypoints (m) and refractive index that study.yaml states."""
    dry = abs(study.report("uncorrected_refraction", 0))
    return (dry, 1.0) if dry else (study.world.robot.depth, 1.333)


def true_depth(study: StudyTruth, t: np.ndarray) -> np.ndarray:
    """Depth (m) of the keypoints at robot time ``t``."""
    depth = study.world.robot.depth + abs(study.report("uncorrected_refraction", 1))
    depth = abs(study.report("uncorrected_refraction", 0)) or depth
    sinks = [abs(study.report("sinking", k)) for k in range(3)]
    fall = sinks[0] * t + sinks[1] * t * t / 6 + sinks[2] * 4 * (1 - np.exp(-t / 2.5))
    return np.minimum(depth + fall, 0.29)


def corner_pixels(study: StudyTruth) -> np.ndarray:
    """Images (4, 2) of the marks that the lab took for the pool's corners."""
    marks = pool_corners(study.world.pool, study.corner_height)
    middle = marks.mean(0)
    return to_pixels(study.camera, middle + (marks - middle) / (1 + study.report("scale_error", 2)))


def stated_camera(study: StudyTruth, pixels: np.ndarray) -> Camera:
    """The stated lens, posed by the stated corners."""
    distortion = study.camera.distortion.copy()
    distortion[0] += study.report("lens_error", 0)
    distortion[1] += study.report("lens_error", 1)
    matrix = study.camera.matrix.copy()
    matrix[2:] += study.report("lens_error", 2) * np.array([0.8, 0.6])
    lens = replace(study.camera, distortion=distortion, matrix=matrix)
    return with_fitted_pose(lens, pool_corners(stated_pool(study), study.corner_height), pixels)


def robot_time(study: StudyTruth, t: np.ndarray, trial: np.ndarray) -> np.ndarray:
    """Time (s) since the robot started at the stated time ``t`` of the recording."""
    half = np.where(trial % 2 == 0, 1.0, 0.0)
    rate = 1 + study.report("clock_error", 0) + half * study.report("clock_error", 1)
    spread = 0.4 + 1.2 * ((trial * 0.618) % 1)
    delay = abs(study.report("time_offset", 0)) + spread * abs(study.report("time_offset", 1))
    return np.maximum(t * rate - delay, 0)


def pixels_after_camera_shift(
    study: StudyTruth, pixels: np.ndarray, t: np.ndarray, trial: np.ndarray
) -> np.ndarray:
    """Pixels (N, 2) after movements of the camera at recording time ``t`` (N,)."""
    step, drift, roll = (study.report("camera_shift", k) for k in range(3))
    when = study.trials.duration[trial] * (0.35 + 0.3 * ((trial * 0.618) % 1))
    displaced = step * (t > when) * (trial % 3 != 0)
    direction = 2.4 * trial
    move = np.column_stack([np.cos(direction), np.sin(direction)]) * displaced[:, None]
    move = move + np.outer(drift * t / 5, [0.6, -0.8])
    turn = np.exp(1j * np.radians(roll) * t / 5)
    middle = np.array(study.camera.size) / 2
    d = ((pixels - middle) @ np.array([1, 1j])) * turn
    return middle + np.column_stack([d.real, d.imag]) + move


def body_points(  # noqa: PLR0917
    robot: Robot,
    pose: np.ndarray,
    phi: np.ndarray,
    head: np.ndarray,
    labels: np.ndarray,
    swing: np.ndarray,
) -> np.ndarray:
    """Complex positions (N, 5) of ``KEYPOINT_NAMES``.

    ``pose`` (3, N): label of the centre (m) and theta.
    ``labels`` (5,) complex (m): placement errors, along the head for the first, along the core for
    the others; ``swing`` (rad) bends the tail about the caudal base.
    """
    centre, front, core = pose[0] + 1j * pose[1], np.exp(1j * pose[2]), np.exp(1j * (pose[2] + phi))
    hinge = centre + robot.hinge_to_com * core
    base = centre - robot.tail_base * core
    tip = base - robot.tail_length * core * np.exp(1j * swing)
    points = np.stack([hinge + head * front, hinge, centre, base, tip], 1)
    points[:, 0] += labels[0] * front
    points[:, 1:] += labels[None, 1:] * core[:, None]
    return points


def label_bias(study: StudyTruth) -> np.ndarray:
    """Systematic label errors (5,) in m."""
    labels = np.zeros(5, complex)
    labels[2] = -study.report("keypoint_bias", 0) + 1j * study.report("keypoint_bias", 1)
    labels[0] = 1j * study.report("keypoint_bias", 2)
    return labels


def labelled_pose(study: StudyTruth, state: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Pose (3, N) of the intended centre label for states (>= 3, N): the centre of mass unless
    shifted.
    """
    pose = state[:3].copy()
    for h in study.world.active("mass_centre"):
        core = np.exp(1j * (pose[2] + phi))
        shift = -centre_of_mass_shift(_CoreAxis(core), h.strength, h.constants)
        pose[0] += shift.real
        pose[1] += shift.imag
    return pose


@dataclass(frozen=True)
class _CoreAxis:
    core: np.ndarray


def keypoint_pixels(
    study: StudyTruth, points: np.ndarray, t: np.ndarray, trial: np.ndarray
) -> np.ndarray:
    """Pixels (N, parts, 2) of complex points (N, parts) at recording time ``t``, of trial
    ``trial``.
    """
    n, parts = points.shape
    depth = true_depth(study, robot_time(study, t, trial))
    place = np.column_stack([points.real.ravel(), points.imag.ravel()])
    pixels = project(study.camera, place, np.repeat(depth, parts), 1.333)
    moved = pixels_after_camera_shift(study, pixels, np.repeat(t, parts), np.repeat(trial, parts))
    return moved.reshape(n, parts, 2)


def observed_change(study: StudyTruth, path: np.ndarray, per_second: int, t: np.ndarray) -> tuple:
    """Change (K, B, 3) of observed x, y, heading and (K, B) of log size that misreporting makes."""
    B = path.shape[2]
    clean = path[:: round((t[1] - t[0]) * per_second)][: len(t)]
    trial, when = np.tile(np.arange(B), len(t)), np.repeat(t, B)
    late = robot_time(study, t[:, None], np.arange(B)[None])
    spline = CubicSpline(np.arange(len(path)) / per_second, path[:, :3], axis=0)
    moved = np.stack(
        [spline(np.minimum(late[:, b], t[-1] * 1.0 + 0.09))[..., b] for b in range(B)], -1
    )
    state = np.moveaxis(moved, 1, 0).reshape(3, -1)
    trials = study.trials.take(trial)
    phi = study.world.head_angle(late.ravel(), trials)
    robot = study.world.robot
    pose = labelled_pose(study, state, phi)
    points = body_points(robot, pose, phi, trials.head, label_bias(study), 0 * phi)
    camera = stated_camera(study, corner_pixels(study))
    pixels = keypoint_pixels(study, points, when, trial).reshape(-1, 2)
    found = pixels_to_pool(camera, pixels, *stated_optics(study)).reshape(-1, 5, 2) @ np.array(
        [1, 1j]
    )
    heading = np.angle((found[:, 0] - found[:, 1]) * np.exp(-1j * state[2])) + state[2]
    size = np.log(np.abs(found[:, 1] - found[:, 3]) / (robot.hinge_to_com + robot.tail_base))
    seen = np.stack([found[:, 2].real, found[:, 2].imag, heading], -1).reshape(len(t), B, 3)
    return seen - np.moveaxis(clean[:, :3], 1, 2), size.reshape(len(t), B)


def length_and_label_sigma(
    study: StudyTruth, i: int, size: np.ndarray, inside: np.ndarray, pixel_m: float
) -> float:
    """What body size, label geometry and recoil frequency add to the path, in sigma.

    A label is placed to 0.7 mm; apparent size has the tracking errors of two points over the
    body's length.
    """
    hidden, noise, robot = study.world.hidden[i], study.noise, study.world.robot
    name, trials = hidden.form.name, len(study.trials.phi)
    if name == "keypoint_bias":
        return hidden.strength / 7e-4
    if name == "clock_error":
        half = 1 if int(hidden.constants["shape"]) == 0 else 2
        return hidden.strength / noise.frequency * np.sqrt(trials / half)
    s = size[inside]
    independent = max(2 * noise.matern_tau_s / 0.1, 1)
    error = noise.matern_px**2 * independent + noise.white_px**2 / (study.fps * 0.1)
    varying = np.sum((s - s.mean()) ** 2) / (2 * error * (pixel_m / robot.body_length) ** 2)
    return float(np.sqrt(varying + (s.mean() * robot.body_length / 1e-3) ** 2))
