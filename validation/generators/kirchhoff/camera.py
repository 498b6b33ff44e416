"""Overhead camera with a rotation matrix, Brown or Kannala-Brandt lens, above a refracting surface.

P_pool (m, z up, origin on the surface) -> P_cam = R (P_pool - C) -> normalised -> lens -> pixels.
An underwater point is first moved to the place where its ray crosses the surface (Snell).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Camera:
    """Lens and pose. ``matrix`` = (fx, fy, cx, cy) px; ``centre`` (3,) m; ``R`` (3, 3) pool to
    camera.
    """

    model: str  # pinhole: distortion k1, k2, p1, p2, k3; fisheye: k1..k4
    size: tuple[int, int]
    matrix: np.ndarray
    distortion: np.ndarray
    R: np.ndarray
    centre: np.ndarray


def distort(camera: Camera, a: np.ndarray) -> np.ndarray:
    """Lens distortion of normalised image points (N, 2): Brown 1966 or Kannala & Brandt 2006."""
    r2 = (a * a).sum(-1, keepdims=True)
    k = camera.distortion
    if camera.model == "fisheye":
        r = np.sqrt(r2).clip(1e-12)
        angle = np.arctan(r)
        bent = angle * (1 + sum(k[i] * angle ** (2 * i + 2) for i in range(4)))
        return a * bent / r
    radial = 1 + k[0] * r2 + k[1] * r2**2 + k[4] * r2**3
    x, y, r2 = a[..., 0], a[..., 1], r2[..., 0]
    tangential = [
        2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
        k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y,
    ]
    return a * radial + np.stack(tangential, -1)


def undistort(camera: Camera, b: np.ndarray) -> np.ndarray:
    """Inverse of ``distort`` by Newton's method with a difference Jacobian."""
    a, h = b.copy(), 1e-6
    for _ in range(12):
        base = distort(camera, a)
        J = np.stack([(distort(camera, a + h * e) - base) / h for e in np.eye(2)], -1)
        a = a - np.linalg.solve(J, (base - b)[..., None])[..., 0]
    return a


def to_pixels(camera: Camera, P_pool: np.ndarray) -> np.ndarray:
    """Pixels (N, 2) of points (N, 3) in air or on the surface."""
    P_cam = (P_pool - camera.centre) @ camera.R.T
    return distort(camera, P_cam[:, :2] / P_cam[:, 2:]) * camera.matrix[:2] + camera.matrix[2:]


def surface_crossing(
    camera: Camera, place: np.ndarray, depth: np.ndarray, index: float
) -> np.ndarray:
    """Points (N, 2) where rays from underwater ``place`` (N, 2) at ``depth`` m leave the water."""
    height, offset = camera.centre[2], place - camera.centre[:2]
    rho = np.hypot(*offset.T).clip(1e-9)
    s = rho * height / (height + depth / index)
    for _ in range(8):  # Newton on sin(a) = n sin(w), s = distance of the crossing from the nadir
        air, water = np.hypot(s, height), np.hypot(rho - s, depth).clip(1e-9)
        error = s / air - index * (rho - s) / water
        s = s - error / (height**2 / air**3 + index * depth**2 / water**3)
    return camera.centre[:2] + offset * (s / rho)[:, None]


def project(
    camera: Camera, place: np.ndarray, depth: np.ndarray | float, index: float
) -> np.ndarray:
    """Pixels (N, 2) of underwater points ``place`` (N, 2) at ``depth`` (m)."""
    depth = np.broadcast_to(depth, len(place))
    crossing = surface_crossing(camera, place, depth, index)
    return to_pixels(camera, np.column_stack([crossing, np.zeros(len(place))]))


def pixels_to_pool(camera: Camera, pixels: np.ndarray, depth: float, index: float) -> np.ndarray:
    """Underwater points (N, 2) at ``depth`` seen at ``pixels``: the inverse of ``project``."""
    a = undistort(camera, (pixels - camera.matrix[2:]) / camera.matrix[:2])
    ray = np.column_stack([a, np.ones(len(a))]) @ camera.R
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    crossing = camera.centre[:2] - ray[:, :2] * (camera.centre[2] / ray[:, 2:])
    sine = np.hypot(ray[:, 0], ray[:, 1]).clip(1e-12)
    slope = sine / index / np.sqrt(1 - (sine / index) ** 2)
    return crossing + ray[:, :2] / sine[:, None] * (depth * slope)[:, None]


def pool_corners(pool: tuple[float, float], height: float) -> np.ndarray:
    """Pool corners (4, 3) in the order of study.yaml."""
    L, W = pool
    return np.array([[0, 0, height], [L, 0, height], [L, W, height], [0, W, height]])


def with_fitted_pose(camera: Camera, points: np.ndarray, pixels: np.ndarray) -> Camera:
    """Camera whose pose best projects ``points`` (N, 3) onto ``pixels`` (N, 2)."""

    def at(p: np.ndarray) -> Camera:
        turned = Rotation.from_rotvec(p[:3]).as_matrix() @ camera.R
        return replace(camera, R=turned, centre=camera.centre + p[3:])

    fit = least_squares(
        lambda p: (to_pixels(at(p), points) - pixels).ravel(), np.zeros(6), xtol=1e-12
    )
    return at(fit.x)


def draw_camera(rng: np.random.Generator, pool: tuple[float, float], plain: bool) -> Camera:
    """A camera above the pool that sees all of it; ``plain`` has no distortion."""
    size = [(1920, 1080), (1920, 1080), (2704, 1520), (1280, 960)][rng.integers(4)]
    model = "pinhole" if plain or rng.random() < 0.65 else "fisheye"
    height = rng.uniform(1.7, 2.6)
    fx = (
        min(size[0] / (pool[0] + 0.35), size[1] / (pool[1] + 0.3))
        * height
        * rng.uniform(0.86, 0.95)
    )
    if model == "fisheye":
        distortion = rng.normal(0, [0.03, 0.01, 0.003, 0.001])
    else:
        distortion = np.array([-0.12, 0.03, 0, 0, 0]) * rng.uniform(0.1, 1.5)
        distortion += rng.normal(0, [0.02, 0.005, 4e-4, 4e-4, 0.001])
    flip = Rotation.from_euler("x", 180, degrees=True)
    yaw = rng.choice([0, 180]) + rng.normal(0, 1.5)
    tilt = Rotation.from_euler("zxy", [yaw, *rng.normal(0, 1.5, 2)], degrees=True)
    R = (tilt * flip).as_matrix()
    aim = np.array([*(np.array(pool) / 2 + rng.normal(0, 0.02, 2)), 0.0])
    centre = aim - R[2] * height / -R[2, 2]
    matrix = np.array([fx, fx * rng.normal(1, 0.002), *(np.array(size) / 2 + rng.normal(0, 8, 2))])
    return Camera(model, size, matrix, distortion * (not plain), R, centre)
