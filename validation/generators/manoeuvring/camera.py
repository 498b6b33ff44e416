"""Overhead camera above still water: projection, refraction, and what the lab believes of it.

Lens models: Brown's pinhole (k1, k2, p1, p2, k3) and Kannala and Brandt's fisheye (k1..k4), in
OpenCV's order. Pixels u right, v down. Refraction by Snell's law at the plane z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from validation.generators.manoeuvring.dynamics import POOL, Array

DOWNWARD_ROTATION = np.diag([1.0, -1.0, -1.0])  # world to camera of a camera looking straight down


@dataclass(frozen=True)
class Camera:
    """Lens, pose (rotation vector after DOWN; centre in m) and refractive index."""

    model: str
    size: tuple[int, int]
    K: Array
    distortion: Array
    tilt: Array
    centre: Array
    index: float = 1.333

    @property
    def R(self) -> Array:
        """Rotation world to camera, (3, 3)."""
        return Rotation.from_rotvec(self.tilt).as_matrix() @ DOWNWARD_ROTATION


def distort(camera: Camera, m: Array) -> Array:
    """Distorted normalised image points of ideal ones, (n, 2)."""
    r = np.hypot(m[:, 0], m[:, 1])
    d = camera.distortion
    if camera.model == "fisheye":
        a = np.arctan(r)
        ad = a * (1 + d[0] * a**2 + d[1] * a**4 + d[2] * a**6 + d[3] * a**8)
        return m * np.where(r > 1e-9, ad / np.maximum(r, 1e-9), 1.0)[:, None]
    x, y, r2 = m[:, 0], m[:, 1], r**2
    radial = 1 + d[0] * r2 + d[1] * r2**2 + d[4] * r2**3
    return np.column_stack(
        [
            x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x**2),
            y * radial + d[2] * (r2 + 2 * y**2) + 2 * d[3] * x * y,
        ]
    )


def undistort(camera: Camera, md: Array) -> Array:
    """Ideal normalised image points of distorted ones, (n, 2), by fixed point iteration."""
    m = md.copy()
    for _ in range(40):
        m = m + 0.9 * (md - distort(camera, m))
    return m


def project_in_air(camera: Camera, X: Array) -> Array:
    """Pixels (n, 2) of points in air (n, 3), m."""
    c = (X - camera.centre) @ camera.R.T
    d = distort(camera, c[:, :2] / c[:, 2:])
    return d @ camera.K[:2, :2].T + camera.K[:2, 2]


def surface_crossing(camera: Camera, xy: Array, depth: Array) -> Array:
    """Where the ray from a point at `depth` (m) leaves the water, (n, 2), by Newton's method."""
    H, n = camera.centre[2], camera.index
    d = xy - camera.centre[:2]
    R, depth = np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-9), np.maximum(depth, 1e-9)
    s = R * H / (H + depth / n)
    for _ in range(8):
        a, b = np.hypot(s, H), np.hypot(R - s, depth)
        g = s / a - n * (R - s) / b
        s = np.clip(s - g / (H**2 / a**3 + n * depth**2 / b**3), 0, R)
    return camera.centre[:2] + d * (s / R)[:, None]


def project(camera: Camera, xy: Array, depth: Array | float) -> Array:
    """Pixels (n, 2) of keypoints xy (n, 2) m at `depth` below the surface."""
    s = surface_crossing(camera, xy, np.broadcast_to(depth, len(xy)).astype(float))
    return project_in_air(camera, np.column_stack([s, np.zeros(len(s))]))


def pixels_to_pool(camera: Camera, px: Array, depth: Array | float) -> Array:
    """Pool position (n, 2) m of raw pixels, for keypoints at `depth`."""
    m = undistort(camera, (px - camera.K[:2, 2]) @ np.linalg.inv(camera.K[:2, :2]).T)
    ray = np.column_stack([m, np.ones(len(m))]) @ camera.R
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    s = camera.centre[:2] + ray[:, :2] * (-camera.centre[2] / ray[:, 2])[:, None]
    sine = ray[:, :2] / camera.index
    return s + sine * (depth / np.sqrt(1 - (sine**2).sum(1)))[:, None]


def pool_corners(length: float, width: float, height: float) -> Array:
    """Pool corners (4, 3), m, in the order of study.yaml."""
    flat = np.array([[0, 0], [length, 0], [length, width], [0, width]], float)
    return np.column_stack([flat, np.full(4, height)])


def with_fitted_pose(
    camera: Camera, px: Array, length: float, width: float, height: float
) -> Camera:
    """The camera with the pose that a lab finds from the corner pixels (4, 2)."""
    X = pool_corners(length, width, height)

    def at(p: Array) -> Camera:
        return replace(camera, tilt=p[:3], centre=p[3:])

    fit = least_squares(
        lambda p: (project_in_air(at(p), X) - px).ravel(),
        np.r_[camera.tilt, camera.centre],
        x_scale=0.1,
    )
    return at(fit.x)


def draw_camera(rng: np.random.Generator, model: str, height: tuple[float, float]) -> Camera:
    """A camera tilted by some degrees, `height` (m) above the pool, that sees the whole pool."""
    for _ in range(200):
        camera = _any_camera(rng, model, height)
        edge = project_in_air(camera, pool_corners(*POOL, 0.08))
        if (edge > 10).all() and (edge < np.array(camera.size) - 10).all():
            return camera
    raise RuntimeError("no camera sees the pool")


def _any_camera(rng: np.random.Generator, model: str, height: tuple[float, float]) -> Camera:
    """A camera drawn without regard to the edges of its image."""
    H, size = rng.uniform(*height), (1920, 1080)
    centre = np.array([POOL[0] / 2, POOL[1] / 2, H]) + np.r_[rng.normal(0, 0.05, 2), 0.0]
    tilt = np.r_[rng.normal(0, 0.015, 2), rng.normal(0, 0.02)]
    half = POOL[0] / 2 / H
    reach = np.arctan(half) if model == "fisheye" else half
    f = rng.uniform(0.72, 0.82) * size[0] / 2 / reach
    if model == "fisheye":
        d = np.r_[rng.uniform(-0.05, 0.03), rng.normal(0, 0.008), 0.0, 0.0]
    else:
        d = np.r_[rng.uniform(-0.22, -0.03), rng.uniform(0.0, 0.04), rng.normal(0, 4e-4, 2), 0.0]
    if model == "homography":
        d = np.zeros(5)
    K = np.array(
        [[f, 0, size[0] / 2 + rng.normal(0, 8)], [0, f, size[1] / 2 + rng.normal(0, 8)], [0, 0, 1]]
    )
    return Camera("fisheye" if model == "fisheye" else "pinhole", size, K, d, tilt, centre)
