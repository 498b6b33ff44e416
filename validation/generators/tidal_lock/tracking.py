"""Keypoints of a beating fish in the camera's image, with the errors of a tracker."""

from dataclasses import dataclass

import numpy as np

from .detector import Noise
from .dynamics import Case
from .laws_body import SINKING_SHAPES
from .observation import Pose, centre_shift, recorded_times, true_pose
from .optics import Camera, project
from .water import first_order_autoregression

BODYPARTS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")


@dataclass(frozen=True)
class KeypointDisturbances:
    """Recoil, tail beat and the tracker's failures, one set a study."""

    recoil_heading: float  # rad
    recoil_sway: float  # body lengths
    recoil_lag: float  # rad
    tail_swing: float  # rad
    outliers: float  # share of points
    certain_outliers: float  # share of the outliers with a high likelihood
    gaps: float  # per trial
    tail_factor: float  # noise of the tail tip over that of the others


def draw_noise(rng: np.random.Generator) -> Noise:
    """White and slow tracking noise and the frame rate."""
    fps = float(rng.choice([25.0, 29.97003, 30.0, 50.0, 59.94006, 60.0]))
    return Noise(rng.uniform(0.3, 1.0), rng.uniform(0.15, 0.6), rng.uniform(0.15, 0.6), fps)


def draw_disturbances(rng: np.random.Generator) -> KeypointDisturbances:
    """Recoil, tail beat and failures of the tracker."""
    return KeypointDisturbances(
        recoil_heading=np.radians(rng.uniform(0.8, 4.0)),
        recoil_sway=rng.uniform(0.003, 0.012),
        recoil_lag=rng.uniform(0, 2 * np.pi),
        tail_swing=np.radians(rng.uniform(12, 30)),
        outliers=rng.uniform(0.002, 0.015),
        certain_outliers=rng.uniform(0.05, 0.35),
        gaps=rng.uniform(0.2, 2.0),
        tail_factor=rng.uniform(1.3, 2.5),
    )


def _label_offsets(case: Case, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    core, tip = 0j * phi, 0j * phi
    for active in case.active:
        if active.form.stage == "label":
            more = active.form.law(phi, active.p)
            core, tip = core + more[0], tip + more[1]
    return core, tip


def body_points(
    pose: Pose,
    phases: tuple[np.ndarray, np.ndarray],
    case: Case,
    disturbances: KeypointDisturbances,
) -> np.ndarray:
    """Keypoints (frames, rows, 5) as x + iy; `phases` holds the tail's phase since the start
    (frames, rows) and at the start (rows,).
    """
    robot = case.robot
    going = np.clip(phases[0] / (2 * np.pi), 0, 1)
    beat = phases[0] + phases[1]
    theta = pose.theta + disturbances.recoil_heading * going * np.sin(
        beat + disturbances.recoil_lag
    )
    core = theta + pose.phi
    sway = disturbances.recoil_sway * robot.length * going * np.sin(beat)
    centre = pose.centre + 1j * sway * np.exp(1j * core)
    for active in case.active:
        if active.form.stage == "centre":
            centre = centre + centre_shift(pose, active, case)
    hinge = centre + robot.hinge_to_com * np.exp(1j * core)
    base = centre - robot.aft * np.exp(1j * core)
    tail = base - robot.tail * np.exp(
        1j * (core + disturbances.tail_swing * going * np.sin(beat + 0.8))
    )
    label, tip = _label_offsets(case, pose.phi)
    nose = hinge + (case.head + tip) * np.exp(1j * theta)
    return np.stack([nose, hinge, centre + label * np.exp(1j * core), base, tail], axis=-1)


def _with_camera_displacements(pixels, frames, case: Case, camera: Camera) -> np.ndarray:
    for active in case.active:
        if active.form.stage == "displacement":
            shift, turn = active.form.law(frames[:, None], active.p, case.trial)
            middle = complex(*(n / 2 for n in camera.image))
            flat = (pixels[..., 0] + 1j * pixels[..., 1] - middle).transpose(2, 0, 1)
            flat = (flat * np.exp(1j * np.asarray(turn)) + shift + middle).transpose(1, 2, 0)
            pixels = np.stack([flat.real, flat.imag], axis=-1)
    return pixels


def perfect_pixels(times, states, case: Case, *, instruments, frames, beat) -> np.ndarray:
    """Raw pixels (frames, rows, 5, 2) without tracking errors.

    `instruments` is (camera, disturbances); `beat` is the tail's phase since the start
    (steps, rows) at `times`, and the phase at the start (rows,).
    """
    (camera, disturbances), (phase, origin) = instruments, beat
    when = recorded_times(case, frames)
    pose = true_pose(times, states, case)
    seen = pose.at(when)
    turned = Pose(times, 0j * phase, phase, phase).at(np.maximum(when, 0)).theta
    points = body_points(seen, (turned, origin), case, disturbances)
    depth = np.full(points.shape, camera.depth)
    for active in case.active:
        if active.form.cause == "sinking":
            gain = active.p.amp * SINKING_SHAPES[active.form.form](np.maximum(when, 0))
            depth = depth + gain[..., None]
    pixels = project(camera, np.stack([points.real, points.imag, -depth], axis=-1))
    return _with_camera_displacements(pixels, frames, case, camera)


def _slow_noise(rng, shape, noise: Noise) -> np.ndarray:
    increments = rng.standard_normal(shape) * noise.slow
    return first_order_autoregression(increments, np.exp(-1 / (noise.fps * noise.slow_time)))


def tracked(
    rng: np.random.Generator, pixels: np.ndarray, noise: Noise, disturbances: KeypointDisturbances
):
    """Detections (frames, 5, 2) of one trial and their likelihoods (frames, 5)."""
    frames, parts = pixels.shape[:2]
    size = np.array([1, 1, 1, 1, disturbances.tail_factor])[:, None]
    errors = noise.white * rng.standard_normal(pixels.shape) + _slow_noise(rng, pixels.shape, noise)
    found = pixels + size * errors
    likelihood = 1 - rng.beta(1.2, 60, (frames, parts))
    wrong = rng.random((frames, parts)) < disturbances.outliers
    jumps = rng.uniform(8, 90, (frames, parts)) * np.exp(2j * np.pi * rng.random((frames, parts)))
    jumps = np.where(wrong, jumps, 0)
    found = found + np.stack([jumps.real, jumps.imag], axis=-1)
    certain = rng.random((frames, parts)) < disturbances.certain_outliers
    likelihood = np.where(wrong & ~certain, rng.uniform(0.02, 0.7, wrong.shape), likelihood)
    for _ in range(rng.poisson(disturbances.gaps)):
        first = rng.integers(0, frames)
        last = first + int(noise.fps * rng.uniform(0.08, 0.5)) + 1
        lost = np.flatnonzero(rng.random(parts) < 0.6)
        likelihood[first:last, lost] = rng.uniform(0.0, 0.08)
        found[first:last, lost] = np.nan if rng.random() < 0.5 else found[first:last, lost] + 15.0
    return found, likelihood
