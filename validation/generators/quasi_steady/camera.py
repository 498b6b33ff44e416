"""Pinhole camera with Brown's distortion, or fisheye, above refracting water."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Camera:
    """Intrinsics and pose: P_cam = R(rotation) (P_pool - position)."""

    model: str  # pinhole (Brown 1966: k1 k2 p1 p2 k3) or fisheye (Kannala and Brandt 2006)
    size: tuple[int, int]
    focal: tuple[float, float]  # px
    centre: tuple[float, float]  # px
    distortion: tuple[float, ...]
    rotation: tuple[float, float, float]  # rotation vector, rad
    position: tuple[float, float, float]  # m, pool frame
    index: float = 1.333


def distort(camera: Camera, p: np.ndarray) -> np.ndarray:
    """Distorted from ideal normalised image coordinates, shape (n, 2)."""
    r2 = np.sum(p**2, axis=1)
    d = camera.distortion
    if camera.model == "fisheye":
        r = np.sqrt(r2) + 1e-12
        q = np.arctan(r)
        bent = q * (1 + d[0] * q**2 + d[1] * q**4 + d[2] * q**6 + d[3] * q**8)
        return p * (bent / r)[:, None]
    k1, k2, p1, p2, k3 = d
    x, y = p.T
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return p * radial[:, None] + np.column_stack([dx, dy])


def undistort(camera: Camera, q: np.ndarray) -> np.ndarray:
    """Ideal from distorted normalised coordinates by damped fixed-point iteration."""
    p = q.copy()
    if camera.model == "fisheye":
        r = np.linalg.norm(q, axis=1)
        p = q * (np.tan(np.minimum(r, 1.4)) / (r + 1e-12))[:, None]
    for _ in range(25):
        p = p - 0.8 * (distort(camera, p) - q)
    return p


def to_pixels(camera: Camera, points: np.ndarray, wobble: np.ndarray | None = None) -> np.ndarray:
    """Pixels (n, 2) of points (n, 3) seen through air; `wobble` (n, 3) rotates the camera, rad."""
    P_cam = Rotation.from_rotvec(camera.rotation).apply(points - camera.position)
    if wobble is not None:
        P_cam = Rotation.from_rotvec(wobble).apply(P_cam)
    return distort(camera, P_cam[:, :2] / P_cam[:, 2:]) * camera.focal + camera.centre


def surface_points(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Where the rays from points (n, 3) below the water (z <= 0) leave it (Snell), Newton."""
    height = camera.position[2]
    offset = points[:, :2] - camera.position[:2]
    reach, depth, n = np.linalg.norm(offset, axis=1) + 1e-12, -points[:, 2], camera.index
    rho = reach * height / (height + depth / n)
    for _ in range(8):
        a, b = np.hypot(rho, height), np.hypot(reach - rho, depth) + 1e-12
        value = rho / a - n * (reach - rho) / b
        slope = height**2 / a**3 + n * depth**2 / b**3
        rho = rho - np.where(depth > 1e-9, value / (slope + 1e-9), 0.0)
    out = np.zeros_like(points)
    out[:, :2] = camera.position[:2] + offset * (rho / reach)[:, None]
    return out


def project(camera: Camera, points: np.ndarray, wobble: np.ndarray | None = None) -> np.ndarray:
    """Pixels (n, 2) of submerged points (n, 3), metres in the pool frame."""
    return to_pixels(camera, surface_points(camera, points), wobble)


def pixels_to_pool(camera: Camera, pixels: np.ndarray, depth: float) -> np.ndarray:
    """Pool positions (n, 2) of pixels (n, 2) of points at `depth` m below the surface."""
    p = undistort(camera, (pixels - camera.centre) / np.array(camera.focal))
    ray = Rotation.from_rotvec(camera.rotation).inv().apply(np.column_stack([p, np.ones(len(p))]))
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    surface = camera.position[:2] - ray[:, :2] * (camera.position[2] / ray[:, 2:])
    sideways = ray[:, :2] / camera.index
    down = np.sqrt(1 - np.sum(sideways**2, axis=1))
    return surface + sideways * (depth / down)[:, None]


def pool_corners(length: float, width: float, height: float) -> np.ndarray:
    """The four marks (0,0), (L,0), (L,W), (0,W) at `height` above the water, shape (4, 3)."""
    return np.array([[x * length, y * width, height] for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])


def with_fitted_pose(camera: Camera, marks: np.ndarray, pixels: np.ndarray) -> Camera:
    """The camera at the pose that images the marks (4, 3) best at `pixels` (4, 2)."""

    def posed(p: np.ndarray) -> Camera:
        return replace(camera, rotation=tuple(p[:3]), position=tuple(p[3:]))

    start = np.r_[camera.rotation, camera.position]
    fit = least_squares(lambda p: (to_pixels(posed(p), marks) - pixels).ravel(), start, x_scale=0.1)
    return posed(fit.x)


def draw_camera(rng: np.random.Generator, length: float, width: float, model: str) -> Camera:
    """A camera above the pool, tilted by some degrees, that sees all of it.

    model: pinhole, fisheye, or plain (pinhole without distortion).
    """
    size = [(1920, 1080), (1280, 960), (2704, 1520), (1920, 1440)][rng.integers(4)]
    height = rng.uniform(1.7, 2.6)
    tilt = np.radians(rng.normal(0, 2.0, 3)) * [1, 1, 1.5]
    down = Rotation.from_rotvec([np.pi, 0, 0])  # image x along pool x, image y against pool y
    rotation = (Rotation.from_rotvec(tilt) * down).as_rotvec()
    place = np.array([length / 2, width / 2]) + rng.normal(0, 0.08, 2)
    reach = max((0.5 * length + 0.2) / (0.5 * size[0]), (0.5 * width + 0.2) / (0.5 * size[1]))
    focal = height / reach * rng.uniform(0.85, 0.95)
    if model == "fisheye":
        bent = tuple(rng.normal(0, 1, 4) * [0.03, 0.01, 0.003, 0.001])
        focal *= 1.12
    else:
        bent = (rng.uniform(-0.16, -0.03), rng.uniform(0, 0.02), *rng.normal(0, 4e-4, 2), 0.0)
    if model == "plain":
        bent = (0.0,) * 5
    centre = np.array(size) / 2 + rng.normal(0, 8, 2)
    name = "fisheye" if model == "fisheye" else "pinhole"
    focals = (focal, focal * rng.uniform(0.998, 1.002))
    return Camera(name, size, focals, tuple(centre), bent, tuple(rotation), (*place, height))
