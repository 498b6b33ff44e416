"""A camera above a flat water surface: two lens models, refraction, and the way back to the pool.

Pixels have shape (..., 2). Pool points are complex, m; heights z in m above the surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from .form import Array


@dataclass(frozen=True)
class Camera:
    """Lens and pose. focal, centre: px. distortion: OpenCV's order. turn: rotation vector of the
    pool's axes into the camera's. eye: position in the pool frame, m.
    """

    model: str
    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    turn: tuple[float, float, float]
    eye: tuple[float, float, float]

    def image(self, plan: Array, height: Array | float) -> Array:
        """Pixels of points in air at a height above the water."""
        plan = np.asarray(plan)
        x, y, z = self.eye
        rays = np.stack([plan.real - x, plan.imag - y, height - z + 0 * plan.real], axis=-1)
        X, Y, Z = np.moveaxis(rays @ Rotation.from_rotvec(self.turn).as_matrix().T, -1, 0)
        a, b = _apply_distortion(self.model, X / Z, Y / Z, self.distortion)
        (fx, fy), (cx, cy) = self.focal, self.centre
        return np.stack([fx * a + cx, fy * b + cy], axis=-1)

    def image_through_surface(self, plan: Array, depth: float, index: float) -> Array:
        """Pixels of points at a depth below the surface, m."""
        foot = complex(self.eye[0], self.eye[1])
        offset = np.asarray(plan) - foot
        share = surface_crossing_share(np.abs(offset), self.eye[2], depth, index)
        return self.image(foot + share * offset, 0.0)

    def locate(self, pixels: Array, depth: float, index: float) -> Array:
        """Pool points at a depth whose images are `pixels`, by Newton's method."""
        x, y, height = self.eye
        first = np.stack([pixels[..., 0] - self.centre[0], self.centre[1] - pixels[..., 1]], -1)
        plan = x + 1j * y + height / self.focal[0] * (first[..., 0] + 1j * first[..., 1])
        delta = 1e-4
        for _ in range(7):
            at = self.image_through_surface(plan, depth, index)
            gx = (self.image_through_surface(plan + delta, depth, index) - at) / delta
            gy = (self.image_through_surface(plan + 1j * delta, depth, index) - at) / delta
            u, v = np.moveaxis(pixels - at, -1, 0)
            det = gx[..., 0] * gy[..., 1] - gx[..., 1] * gy[..., 0]
            plan = plan + (gy[..., 1] * u - gy[..., 0] * v) / det
            plan = plan + 1j * (gx[..., 0] * v - gx[..., 1] * u) / det
        return plan

    def posed(self, pixels: Array, corners: Array, height: float) -> Camera:
        """The same lens with the pose that fits the marks at pool points `corners`."""

        def misfit(pose: Array) -> Array:
            moved = replace(self, turn=tuple(pose[:3]), eye=tuple(pose[3:]))
            return (moved.image(corners, height) - pixels).ravel()

        found = least_squares(misfit, [*self.turn, *self.eye], x_scale=[0.1] * 3 + [1.0] * 3).x
        return replace(self, turn=tuple(found[:3]), eye=tuple(found[3:]))


def surface_crossing_share(radius: Array, height: float, depth: float, index: float) -> Array:
    """Share of the way from the camera's foot at which the ray crosses the surface.

    Snell: s / sqrt(s^2 + H^2) = n (r - s) / sqrt((r - s)^2 + d^2), by Newton's method.
    """
    if depth <= 0:
        return np.ones_like(radius)
    s = radius * height / (height + depth / index)
    for _ in range(6):
        rest = radius - s
        a, b = np.hypot(s, height), np.hypot(rest, depth)
        slope = height**2 / a**3 + index * depth**2 / b**3
        s = s - (s / a - index * rest / b) / slope
    return np.where(radius > 1e-9, s / np.maximum(radius, 1e-9), 1.0)


def _apply_distortion(model: str, x: Array, y: Array, k: tuple[float, ...]) -> tuple[Array, Array]:
    """OpenCV's lens models, calib3d documentation."""
    if model == "fisheye":
        radius = np.maximum(np.hypot(x, y), 1e-12)
        angle = np.arctan(radius)
        square = angle**2
        bent = angle * (1 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))))
        return x * bent / radius, y * bent / radius
    k1, k2, p1, p2, k3 = k
    square = x * x + y * y
    radial = 1 + square * (k1 + square * (k2 + square * k3))
    return (
        x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x),
        y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y,
    )


def draw_camera(rng: np.random.Generator, pool: tuple[float, float]) -> Camera:
    """A camera near the middle of the basin that sees all of it."""
    length, width = pool
    height = float(length * rng.uniform(0.75, 1.0))
    size = (3840, 2160)
    eye = (length / 2 + rng.uniform(-0.1, 0.1), width / 2 + rng.uniform(-0.1, 0.1), height)
    down = Rotation.from_euler("x", np.pi) * Rotation.from_euler("z", rng.uniform(-0.02, 0.02))
    turn = Rotation.from_rotvec([*rng.uniform(-0.025, 0.025, 2), 0.0]) * down
    edge = 0.5 * length / height
    if rng.random() < 0.4:
        model, focal = "fisheye", 0.43 * size[0] / np.arctan(edge)
        distortion = tuple(rng.normal(0, (0.02, 0.008, 0.002, 0.0005)).round(5).tolist())
    else:
        model, focal = "pinhole", 0.43 * size[0] / edge
        spread = rng.uniform((-0.12, -0.01, -5e-4, -5e-4, 0.0), (-0.02, 0.04, 5e-4, 5e-4, 0.0))
        distortion = tuple(spread.round(5).tolist())
    focal = float(np.round(focal, 2))
    centre = (size[0] / 2 + round(float(rng.normal(0, 8)), 2),
              size[1] / 2 + round(float(rng.normal(0, 8)), 2))  # fmt: skip
    return Camera(model, size, (focal, focal), centre, distortion,
                  tuple(turn.as_rotvec()), tuple(map(float, eye)))  # fmt: skip


def pool_corners(pool: tuple[float, float]) -> Array:
    """The four corners in the order of study.yaml."""
    length, width = pool
    return np.array([0, length, length + 1j * width, 1j * width])
