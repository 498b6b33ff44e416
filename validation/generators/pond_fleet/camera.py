"""Camera above the pool: Brown's or the equidistant fisheye lens, and a flat water surface.

Pool frame: z up from the water surface. Camera frame: z forward, x right, y down in the image.
Points under water are imaged where their ray, bent by Snell's law, leaves the surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from .robots import Array

SIZES = ((1280, 720), (1920, 1080), (2704, 1520), (3840, 2160), (1440, 1080), (2448, 2048))
MARGIN = 0.02
"""Margin of the pool's corners from the image's rim, in image sizes."""


@dataclass(frozen=True)
class Camera:
    """Model `pinhole` or `fisheye`; size, focal length and centre in px.

    distortion: k1, k2, p1, p2, k3, or k1 to k4. turn: rotation vector from pool to camera (rad).
    position (m).
    """

    model: str
    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    turn: Array
    position: Array

    def project(self, points: Array) -> Array:
        """Image (px) of points in air or on the surface, (..., 3) -> (..., 2)."""
        ray = (points - self.position) @ Rotation.from_rotvec(self.turn).as_matrix().T
        plane = distorted(ray[..., :2] / ray[..., 2:], self.model, self.distortion)
        return plane * np.array(self.focal) + np.array(self.centre)

    def film(self, x: Array, y: Array, depth: Array | float, index: float) -> Array:
        """Image (px) of points at a depth (m) below the surface."""
        away = np.stack([x - self.position[0], y - self.position[1]], axis=-1)
        distance = np.hypot(away[..., 0], away[..., 1]) + 1e-12
        reached = crossing(distance, float(self.position[2]), depth, index)
        place = self.position[:2] + away * (reached / distance)[..., None]
        return self.project(np.concatenate([place, np.zeros((*place.shape[:-1], 1))], axis=-1))

    def locate(self, pixels: Array, depth: float, index: float) -> tuple[Array, Array]:
        """Place (m) at a stated depth of points seen at pixels: the inverse of `film`."""
        plane = (pixels - np.array(self.centre)) / np.array(self.focal)
        ideal = undistorted(plane, self.model, self.distortion)
        ray = np.concatenate([ideal, np.ones((*ideal.shape[:-1], 1))], axis=-1)
        ray = ray @ Rotation.from_rotvec(self.turn).as_matrix()
        surface = self.position[:2] - ray[..., :2] / ray[..., 2:] * self.position[2]
        away = surface - self.position[:2]
        distance = np.hypot(away[..., 0], away[..., 1]) + 1e-12
        sine = distance / np.hypot(distance, self.position[2]) / index
        further = depth * sine / np.sqrt(1 - sine**2)
        place = surface + away * (further / distance)[..., None]
        return place[..., 0], place[..., 1]


def distorted(plane: Array, model: str, k: tuple[float, ...]) -> Array:
    """Lens model of OpenCV on ideal image coordinates (..., 2)."""
    x, y = plane[..., 0], plane[..., 1]
    square = x**2 + y**2
    if model == "fisheye":
        radius = np.sqrt(square) + 1e-12
        angle = np.arctan(radius)
        bent = angle * (1 + sum(c * angle ** (2 * n) for n, c in enumerate(k, 1)))
        return np.asarray(plane * (bent / radius)[..., None])
    k1, k2, p1, p2, k3 = k
    radial = 1 + square * (k1 + square * (k2 + square * k3))
    return np.stack([
        x * radial + 2 * p1 * x * y + p2 * (square + 2 * x**2),
        y * radial + p1 * (square + 2 * y**2) + 2 * p2 * x * y,
    ], axis=-1)  # fmt: skip


def undistorted(plane: Array, model: str, k: tuple[float, ...]) -> Array:
    """Inverse of `distorted` by damped fixed-point iteration."""
    ideal = plane.copy()
    for _ in range(60):
        ideal = ideal + 0.7 * (plane - distorted(ideal, model, k))
    return ideal


def crossing(distance: Array, height: float, depth: Array | float, index: float) -> Array:
    """Horizontal distance (m) at which the ray to a point leaves the water, by bisection.

    sin(air) = index sin(water), with the camera `height` above and the point `depth` below.
    """
    low, high = np.zeros_like(distance), distance.copy()
    for _ in range(50):
        middle = (low + high) / 2
        rest = distance - middle
        bent = index * rest / np.hypot(rest, np.maximum(depth, 1e-9))
        short = middle / np.hypot(middle, height) < bent
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return (low + high) / 2


def corner_points(pool: tuple[float, float], height: float) -> Array:
    """Marks at the pool's corners in the order of study.yaml, (4, 3) in m."""
    length, width = pool
    return np.array([[0, 0, height], [length, 0, height], [length, width, height],
                     [0, width, height]])  # fmt: skip


def draw_camera(rng: np.random.Generator, pool: tuple[float, float], mark_height: float) -> Camera:
    """A camera over the middle of a pool, with the pool filling the image as far as it fits."""
    length, width = pool
    size = SIZES[rng.integers(len(SIZES))]
    height = float(np.hypot(length, width) * rng.uniform(0.55, 1.15))
    middle = np.array([length / 2, width / 2]) + rng.uniform(-0.06, 0.06, 2) * np.array(pool)
    down = Rotation.from_euler("x", np.pi)
    tilt = Rotation.from_euler("xyz", np.radians([*rng.uniform(-4, 4, 2), rng.uniform(-3, 3)]))
    fisheye = rng.random() < 0.3
    camera = Camera(
        "fisheye" if fisheye else "pinhole", size, (1.0, 1.0), (0.0, 0.0),
        _draw_distortion(rng, fisheye=fisheye), (tilt * down).as_rotvec(),
        np.array([*middle, height]),
    )  # fmt: skip
    return _filling(rng, camera, corner_points(pool, mark_height))


def _draw_distortion(rng: np.random.Generator, *, fisheye: bool) -> tuple[float, ...]:
    if fisheye:
        first = rng.uniform(-0.03, 0.06)
        return tuple(round(float(v), 5) for v in (first, rng.normal(0, 0.006), 0.001, 0.0))
    first = rng.uniform(-0.22, 0.03)
    second = 0.25 * first**2 + rng.normal(0, 0.008)
    values = (first, second, *rng.normal(0, 0.0006, 2), 0.0)
    return tuple(round(float(v), 5) for v in values)


def _filling(rng: np.random.Generator, camera: Camera, marks: Array) -> Camera:
    """The camera with the longest focal length at which all marks are in the image."""
    size = np.array(camera.size)
    centre = size / 2 + rng.uniform(-0.012, 0.012, 2) * size
    plane = camera.project(marks)
    room = np.where(plane > 0, size * (1 - MARGIN) - centre, centre - size * MARGIN)
    focal = float((room / np.abs(plane)).min()) * rng.uniform(0.93, 1.0)
    skew = 1 + rng.normal(0, 0.001)
    return replace(
        camera, focal=(round(focal, 2), round(focal * skew, 2)),
        centre=(round(float(centre[0]), 2), round(float(centre[1]), 2)),
    )  # fmt: skip


def with_fitted_pose(camera: Camera, marks: Array, pixels: Array) -> Camera:
    """The camera with the pose that best explains where marks (m) are seen (px)."""

    def misfit(pose: Array) -> Array:
        moved = replace(camera, turn=pose[:3], position=pose[3:])
        return (moved.project(marks) - pixels).ravel()

    found = least_squares(misfit, np.concatenate([camera.turn, camera.position]), x_scale="jac")
    return replace(camera, turn=found.x[:3], position=found.x[3:])
