"""A pinhole camera with lens distortion above water, and its inverse for a known depth.

Points: complex x + i y in the pool frame, m. Pixels: complex u + i v, raw.
Depths: m, positive down.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from .form import Array


@dataclass(frozen=True)
class Camera:
    """A camera with its pose.

    focal, middle: (2,) px. distortion: k1, k2, p1, p2, k3. turn: rotation vector after looking
    straight down, rad. place: x, y, z of the lens in the pool frame, m.
    """

    size: tuple[int, int]
    focal: tuple[float, float]
    middle: tuple[float, float]
    distortion: tuple[float, ...]
    turn: tuple[float, float, float]
    place: tuple[float, float, float]

    @property
    def rotation(self) -> Array:
        """Pool axes to camera axes, (3, 3)."""
        down = np.diag([1.0, -1.0, -1.0])
        return Rotation.from_rotvec(self.turn).as_matrix() @ down


def distorted(flat: Array, distortion: tuple[float, ...]) -> Array:
    """Image plane with lens distortion, complex (Brown 1971, Photogramm. Eng. 37)."""
    k1, k2, p1, p2, k3 = distortion
    x, y = flat.real, flat.imag
    square = x * x + y * y
    radial = 1 + square * (k1 + square * (k2 + square * k3))
    side = 2 * p1 * x * y + p2 * (square + 2 * x * x)
    up = p1 * (square + 2 * y * y) + 2 * p2 * x * y
    return flat * radial + side + 1j * up


def undistorted(seen: Array, distortion: tuple[float, ...]) -> Array:
    """Inverse of `distorted` by the secant-like iteration x <- x - (d(x) - seen)."""
    flat = seen
    for _ in range(40):
        flat = flat - (distorted(flat, distortion) - seen)
    return flat


def surface_point(points: Array, depth: Array, camera: Camera, index: float) -> Array:
    """Where the ray from a point under water to the lens crosses the surface, complex, m.

    Snell's law in the vertical plane, Newton's method on the distance from the foot of the lens.
    """
    foot, height = complex(*camera.place[:2]), camera.place[2]
    span = points - foot
    reach = np.abs(span) + 1e-12
    depth = np.broadcast_to(depth, reach.shape)
    a = reach * height / (height + depth / index)
    for _ in range(6):
        b = reach - a
        above, below = np.hypot(a, height), np.hypot(b, depth) + 1e-15
        gap = a / above - index * b / below
        slope = height**2 / above**3 + index * depth**2 / below**3
        a = a - gap / (slope + 1e-15)
    return foot + span / reach * np.where(depth > 1e-6, a, reach)


def image_of(points: Array, height: float, camera: Camera) -> Array:
    """Pixels of points in the air at a height above the surface."""
    rel = np.stack([points.real - camera.place[0], points.imag - camera.place[1],
                    np.full(points.shape, height - camera.place[2])])  # fmt: skip
    x, y, z = np.tensordot(camera.rotation, rel, axes=1)
    flat = distorted((x + 1j * y) / z, camera.distortion)
    return (camera.focal[0] * flat.real + camera.middle[0]
            + 1j * (camera.focal[1] * flat.imag + camera.middle[1]))  # fmt: skip


def image_under_water(points: Array, depth: Array, camera: Camera, index: float) -> Array:
    """Pixels of points at a depth."""
    return image_of(surface_point(points, depth, camera, index), 0.0, camera)


def point_under_water(pixels: Array, depth: float, camera: Camera, index: float) -> Array:
    """Points at a depth that have the pixels."""
    seen = (pixels.real - camera.middle[0]) / camera.focal[0] + 1j * (
        (pixels.imag - camera.middle[1]) / camera.focal[1]
    )
    flat = undistorted(seen, camera.distortion)
    rays = np.stack([flat.real, flat.imag, np.ones(flat.shape)])
    x, y, z = np.tensordot(camera.rotation.T, rays, axes=1)
    way = (x + 1j * y) / -z
    hit = complex(*camera.place[:2]) + camera.place[2] * way
    tangent = np.abs(way)
    sine = tangent / np.sqrt(1 + tangent**2) / index
    below = depth * sine / np.sqrt(1 - sine**2)
    return hit + way / np.maximum(tangent, 1e-12) * below


def corners(pool: tuple[float, float]) -> Array:
    """Pool corners (0,0), (L,0), (L,W), (0,W), complex, m."""
    length, width = pool
    return np.array([0, length, length + 1j * width, 1j * width])


def with_pose_from_corners(
    camera: Camera, marks: Array, pool: tuple[float, float], height: float
) -> Camera:
    """The camera placed so that the corners of a stated pool have the stated pixels."""
    places = corners(pool)

    def misses(pose: Array) -> Array:
        moved = replace(camera, turn=tuple(pose[:3]), place=tuple(pose[3:]))
        miss = image_of(places, height, moved) - marks
        return np.concatenate([miss.real, miss.imag])

    pose = least_squares(misses, [*camera.turn, *camera.place], x_scale="jac", xtol=1e-13,
                         ftol=1e-13).x  # fmt: skip
    return replace(camera, turn=tuple(pose[:3]), place=tuple(pose[3:]))


def draw_camera(rng: np.random.Generator, pool: tuple[float, float]) -> Camera:
    """A camera that sees the whole pool from above, a few degrees off plumb."""
    size = [(1920, 1080), (2704, 1520), (3840, 2160)][rng.integers(3)]
    focal = size[0] * float(rng.uniform(0.55, 0.85))
    need = max(pool[0] / size[0], pool[1] / size[1]) * focal * 1.16
    spread = rng.normal(0, 0.02, 2)
    camera = Camera(
        size,
        (round(focal, 2), round(focal * float(rng.uniform(0.998, 1.002)), 2)),
        (round(size[0] / 2 + float(rng.normal(0, 6)), 1),
         round(size[1] / 2 + float(rng.normal(0, 6)), 1)),
        (round(float(rng.uniform(-0.16, -0.03)), 4), round(float(rng.uniform(0.0, 0.03)), 4),
         round(float(rng.normal(0, 3e-4)), 5), round(float(rng.normal(0, 3e-4)), 5), 0.0),
        tuple(rng.normal(0, [0.025, 0.025, 0.03])),
        (pool[0] / 2 + spread[0] * pool[0], pool[1] / 2 + spread[1] * pool[1], float(need)),
    )  # fmt: skip
    while not _sees(camera, corners(pool), 0.012 * size[0]):
        x, y, z = camera.place
        camera = replace(camera, place=(x, y, 1.02 * z))
    return camera


def _sees(camera: Camera, places: Array, margin: float) -> bool:
    """Whether points at and just above the surface lie in the picture, margin px from its edge."""
    pixels = np.concatenate([image_of(places, height, camera) for height in (0.0, 0.05)])
    inside = (np.abs(pixels.real - camera.size[0] / 2) < camera.size[0] / 2 - margin) & (
        np.abs(pixels.imag - camera.size[1] / 2) < camera.size[1] / 2 - margin
    )
    return bool(np.all(inside))
