"""A camera above flat water: rays are traced from pixels down into the water.

Locating follows the ray; filming solves the same for the radius at which a ray meets the surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from .robots import Array

INDEX = 1.333


@dataclass(frozen=True)
class Camera:
    """position (m) and turn (rotation vector, pool to camera axes); distortion as in study.yaml."""

    model: str
    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    position: Array
    turn: Array

    def project(self, points: Array) -> Array:
        """Pixels of points (..., 3) in air."""
        rays = Rotation.from_rotvec(self.turn).apply((points - self.position).reshape(-1, 3))
        bent = self._bend(rays[:, :2] / rays[:, 2:])
        pixels = bent * np.array(self.focal) + np.array(self.centre)
        return pixels.reshape(*points.shape[:-1], 2)

    def film(self, places: Array, depth: Array | float, index: float = INDEX) -> Array:
        """Pixels of places (..., 2) that lie `depth` below the surface."""
        away = places - self.position[:2]
        distance = np.hypot(away[..., 0], away[..., 1]) + 1e-12
        radius = surface_radius(distance, self.position[2], depth, index)
        hit = self.position[:2] + away * (radius / distance)[..., None]
        return self.project(np.concatenate([hit, np.zeros_like(hit[..., :1])], axis=-1))

    def locate(self, pixels: Array, depth: Array | float, index: float = INDEX) -> Array:
        """Places (..., 2) at a depth below the surface that are seen at pixels."""
        bent = (pixels.reshape(-1, 2) - np.array(self.centre)) / np.array(self.focal)
        straight = self._straighten(bent)
        rays = np.concatenate([straight, np.ones_like(straight[:, :1])], axis=1)
        rays = Rotation.from_rotvec(self.turn).inv().apply(rays)
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        hit = self.position[:2] + rays[:, :2] * (self.position[2] / -rays[:, 2:])
        sideways = rays[:, :2] / index  # Snell: the horizontal part of a unit ray scales so
        down = np.sqrt(1 - (sideways**2).sum(axis=1, keepdims=True))
        below = np.broadcast_to(depth, pixels.shape[:-1]).reshape(-1, 1)
        return (hit + sideways / down * below).reshape(pixels.shape)

    def _bend(self, plane: Array) -> Array:
        square = (plane**2).sum(axis=1, keepdims=True)
        if self.model == "fisheye":
            radius = np.sqrt(square) + 1e-12
            angle = np.arctan(radius)
            k = self.distortion
            series = 1 + k[0] * angle**2 + k[1] * angle**4 + k[2] * angle**6 + k[3] * angle**8
            return plane * angle * series / radius
        k1, k2, p1, p2, k3 = self.distortion
        x, y = plane[:, :1], plane[:, 1:]
        radial = plane * (1 + k1 * square + k2 * square**2 + k3 * square**3)
        skew = np.concatenate([2 * p1 * x * y + p2 * (square + 2 * x**2),
                               p1 * (square + 2 * y**2) + 2 * p2 * x * y], axis=1)  # fmt: skip
        return radial + skew

    def _straighten(self, bent: Array) -> Array:
        """Inverse of `_bend` by Newton's method with differences."""
        plane, d = bent.copy(), 1e-6
        x_step, y_step = d * np.eye(2)
        for _ in range(6):
            error = self._bend(plane) - bent
            by_x = (self._bend(plane + x_step) - error - bent) / d
            by_y = (self._bend(plane + y_step) - error - bent) / d
            determinant = by_x[:, 0] * by_y[:, 1] - by_y[:, 0] * by_x[:, 1]
            x = (by_y[:, 1] * error[:, 0] - by_y[:, 0] * error[:, 1]) / determinant
            y = (by_x[:, 0] * error[:, 1] - by_x[:, 1] * error[:, 0]) / determinant
            plane = plane - np.stack([x, y], axis=1)
        return plane


def surface_radius(distance: Array, height: float, depth: Array | float, index: float) -> Array:
    """Radius at which the ray to a point at a horizontal distance crosses the surface."""
    depth = np.asarray(depth, dtype=float) + 1e-9
    radius = distance * height / (height + depth / index)
    for _ in range(5):
        rest = distance - radius
        above, below = np.hypot(radius, height), np.hypot(rest, depth)
        error = radius / above - index * rest / below
        radius = radius - error / (height**2 / above**3 + index * depth**2 / below**3)
    return radius


def corner_points(pool: tuple[float, float], height: float, inset: float = 0.0) -> Array:
    """The marks of the corners (0,0), (L,0), (L,W), (0,W), possibly moved inward (m)."""
    x0, x1, y0, y1 = inset, pool[0] - inset, inset, pool[1] - inset
    return np.array([[x0, y0, height], [x1, y0, height], [x1, y1, height], [x0, y1, height]])


def with_pose_of(camera: Camera, marks: Array, pixels: Array) -> Camera:
    """The camera with the pose that shows marks (4, 3) at pixels."""

    def posed(pose: Array) -> Camera:
        return replace(camera, position=pose[:3], turn=pose[3:])

    start = np.concatenate([camera.position, camera.turn])
    found = least_squares(
        lambda pose: (posed(pose).project(marks) - pixels).ravel(), start, x_scale="jac"
    )
    return posed(found.x)


def draw_camera(
    rng: np.random.Generator, pool: tuple[float, float], *, fisheye: bool, height: float
) -> Camera:
    """A camera roughly above the middle that sees the marks of all corners."""
    size = ((1280, 720), (1920, 1080), (1920, 1080), (2704, 1520))[rng.integers(4)]
    centre = tuple(round(float(half / 2 + rng.normal(0, 6)), 1) for half in size)
    above = rng.uniform(0.75, 1.15) * pool[0]
    place = rng.uniform(0.46, 0.54, 2) * np.array(pool)
    position = np.array([*place, above])
    down = Rotation.from_euler("x", 180, degrees=True)
    turn = Rotation.from_euler("xyz", rng.normal(0, [1.5, 1.5, 1.0]), degrees=True) * down
    distortion = (
        tuple(round(float(v), 5) for v in rng.normal(0, [0.02, 0.01, 0.003, 0.001]))
        if fisheye
        else (*(round(float(v), 5) for v in rng.normal(0, [0.05, 0.02, 0.0005, 0.0005])), 0.0)
    )
    camera = Camera("fisheye" if fisheye else "pinhole", size, (1.0, 1.0), (0.0, 0.0), distortion,
                    position, turn.as_rotvec())  # fmt: skip
    reach = np.abs(camera.project(corner_points(pool, height))) / (np.array(size) / 2)
    focal = round(float(0.93 / reach.max()), 1)
    return replace(camera, focal=(focal, focal), centre=(float(centre[0]), float(centre[1])))
