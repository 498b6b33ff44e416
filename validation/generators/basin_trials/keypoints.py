"""Keypoints as a detector delivers them: recoil, noise, glare, gaps, outliers, likelihoods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .camera import Camera
from .form import Array, Quantity
from .robots import Robot

LABELS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
LABEL_NOISE = np.array([1.1, 0.9, 0.8, 1.0, 1.5])
"""Relative size of the noise of each label."""
WAG_LAG = 0.9
"""Phase by which the tip of the tail follows its base, rad."""


@dataclass(frozen=True)
class Noise:
    """Sizes of everything random in the film.

    freedom: of Student's t of the white part. common_px: noise that all keypoints share.
    """

    white_px: float
    freedom: float
    common_px: float
    correlated_px: float
    correlation_s: float
    outlier_share: float
    gap_share: float
    water_rms_m_s: float
    recoil_heading_rad: float
    recoil_sway_m: float
    tail_wag_m: float

    def point_error(self, pixels_per_m: float) -> float:
        """Error of a tracked point after averaging over neighbouring frames, m."""
        quick = self.white_px**2 + self.correlated_px**2
        return np.sqrt(2 * (quick * 0.3 + self.common_px**2)) / pixels_per_m


@dataclass(frozen=True)
class FilmedPoses:
    """True poses of a trial, each (frames,) but the head length.

    place: centre of mass, complex, m. beat: phase of the tail times its build-up, complex. shift:
    of the centre of mass towards the head, m.
    """

    place: Array
    psi: Array
    phi: Array
    depth: Array
    beat: Array
    head: float
    shift: Quantity


def draw_noise(rng: np.random.Generator, pixels_per_m: float) -> Noise:
    """Noise of a study; pixel noise grows with the resolution."""
    px = pixels_per_m / 600
    drawn = (
        px * rng.uniform(0.35, 0.75),
        rng.uniform(3.2, 6),
        px * rng.uniform(0.15, 0.35),
        px * rng.uniform(0.2, 0.5),
        rng.uniform(0.08, 0.35),
        rng.uniform(0.002, 0.012),
        rng.uniform(0.0, 0.03),
        10 ** rng.uniform(-4, -3.1),
        np.radians(rng.uniform(0.4, 1.6)),
        rng.uniform(0.0006, 0.002),
        rng.uniform(0.014, 0.026),
    )
    return Noise(*(float(v) for v in drawn))


def body_points(robot: Robot, poses: FilmedPoses, noise: Noise) -> tuple[Array, Array]:
    """Keypoints (frames, 5, 2) in the pool frame, and headings with recoil (frames,)."""
    beat = poses.beat
    psi = poses.psi + noise.recoil_heading_rad * beat.imag
    axis = np.exp(1j * psi)
    core = poses.place - poses.shift * axis + 1j * axis * noise.recoil_sway_m * beat.real
    hinge = core + robot.hinge_to_com * axis
    nose = hinge + poses.head * np.exp(1j * (psi - poses.phi))
    base = hinge - (robot.body_length - robot.head_length) * axis
    base = base + 1j * axis * 0.12 * noise.tail_wag_m * beat.imag
    wag = (beat * np.exp(-1j * WAG_LAG)).imag
    tip = base - axis * robot.tail_length + 1j * axis * noise.tail_wag_m * wag
    points = np.stack([nose, hinge, core, base, tip], 1)
    return np.stack([points.real, points.imag], -1), psi


def pixels_of(
    camera: Camera, points: Array, depth: Array, later: tuple[int, Camera] | None = None
) -> Array:
    """Pixels (frames, 5, 2) of keypoints at a depth (frames,); later: first frame of a camera."""
    z = -np.broadcast_to(depth[:, None, None], (*points.shape[:2], 1))
    solid = np.concatenate([points, z], -1)
    pixels = camera.project(solid)
    if later is not None:
        first, moved = later
        pixels[first:] = moved.project(solid[first:])
    return pixels


def ornstein_uhlenbeck(
    rng: np.random.Generator, shape: tuple[int, ...], step: float, tau: float
) -> Array:
    """Unit noise (frames, ...) with the correlation time tau, s."""
    a = np.exp(-step / tau)
    out = rng.standard_normal(shape)
    for k in range(1, shape[0]):
        out[k] = a * out[k - 1] + np.sqrt(1 - a * a) * out[k]
    return out


def detected(
    rng: np.random.Generator, pixels: Array, noise: Noise, fps: float, size: tuple[int, int]
) -> tuple[Array, Array]:
    """Detected pixels (frames, 5, 2) and likelihoods (frames, 5); NaN where a point is not seen.

    Glare at one place of the image raises the noise and lowers likelihoods.
    """
    shape = pixels.shape[:2]
    glare = np.exp(-(((pixels - rng.uniform([0, 0], size)) / (0.06 * size[0])) ** 2).sum(-1))
    seen = pixels + _tracking_error(rng, noise, glare, fps)
    sure = 1 - rng.beta(1.2, 30, shape) - 0.5 * glare * rng.random(shape)
    wrong = rng.random(shape) < noise.outlier_share
    jump = rng.normal(0, 0.02 * size[0], (*shape, 2))
    seen = np.where(wrong[..., None], seen + jump, seen)
    noticed = wrong & (rng.random(shape) < 0.85)
    sure = np.where(noticed, rng.uniform(0.1, 0.7, shape), sure)
    gone = _draw_gaps(rng, shape, noise.gap_share)
    faint = gone & (rng.random(shape) < 0.4)  # with a low likelihood; others are left empty
    lost = np.where(gone[..., None], np.nan, seen)
    seen = np.where(faint[..., None], seen + 3 * jump, lost)
    low = rng.uniform(0.0, 0.08, shape)
    sure = np.where(faint, low, np.where(gone, np.nan, np.clip(sure, 0.11, 1)))
    return seen, sure


def _tracking_error(rng: np.random.Generator, noise: Noise, glare: Array, fps: float) -> Array:
    """White, correlated and common noise, px (frames, 5, 2)."""
    shape = (*glare.shape, 2)
    loud = (1 + 1.5 * glare)[..., None] * LABEL_NOISE[:, None]
    white = noise.white_px * rng.standard_t(noise.freedom, shape)
    white = white * np.sqrt((noise.freedom - 2) / noise.freedom)
    step, tau = 1 / fps, noise.correlation_s
    slow = noise.correlated_px * ornstein_uhlenbeck(rng, shape, step, tau)
    common = noise.common_px * ornstein_uhlenbeck(rng, (len(glare), 1, 2), step, 2 * tau)
    return loud * (white + slow) + common


def _draw_gaps(rng: np.random.Generator, shape: tuple[int, ...], share: float) -> Array:
    """Points (frames, 5) that are not seen: single ones, and bursts of 2 to 11 frames."""
    frames = shape[0]
    gone = rng.random(shape) < share * 0.5
    for _ in range(rng.poisson(share * frames / 8)):
        first = int(rng.integers(5, max(frames - 15, 6)))
        last = first + int(rng.integers(2, 12))
        gone[first:last, rng.permutation(5)[: rng.choice([1, 2, 5])]] = True
    return gone
