"""Camera: two lens models, refraction at the still surface, its inverse, pose from the corners.

Pool axes: x along the length, y along the width, z up, surface at z = 0. P_cam = R (P - C).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """`pose`: rotation vector (3) and centre (3, m); `distortion` as in OpenCV's order."""

    model: str
    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    pose: tuple[float, ...]
    index: float = 1.333


def distort(camera: Camera, p: Array) -> Array:
    """Distorted normalised coordinates (..., 2): Brown-Conrady, or Kannala-Brandt for fisheye."""
    r2 = np.sum(p * p, axis=-1, keepdims=True)
    if camera.model == "fisheye":
        r = np.sqrt(r2) + 1e-12
        a = np.arctan(r)
        k1, k2, k3, k4 = camera.distortion
        bent = a * (1 + a**2 * (k1 + a**2 * (k2 + a**2 * (k3 + a**2 * k4))))
        return p * bent / r
    k1, k2, p1, p2, k3 = camera.distortion
    x, y = p[..., :1], p[..., 1:]
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return p * radial + np.concatenate([dx, dy], axis=-1)


def undistort(camera: Camera, d: Array) -> Array:
    """Normalised coordinates from distorted ones, by damped fixed point and Newton's slope."""
    p = d.copy()
    for _ in range(60):
        step = d - distort(camera, p)
        p = p + step
        if np.max(np.abs(step)) < 1e-12:
            break
    return p


def surface_crossing(camera: Camera, points: Array) -> Array:
    """Points (..., 3) where the light from submerged points leaves the water.

    Snell: the horizontal distance a of the crossing from the camera obeys
    n sin(water) = sin(air); bisection-safe Newton is replaced by 40 secant-free halvings.
    """
    C = np.asarray(camera.pose[3:])
    level = points[..., :2] - C[:2]
    reach, depth = np.linalg.norm(level, axis=-1), np.maximum(-points[..., 2], 0.0)
    low, high = np.zeros_like(reach), reach.copy()
    for _ in range(45):
        a = 0.5 * (low + high)
        air = a / np.hypot(a, C[2])
        water = (reach - a) / np.maximum(np.hypot(reach - a, depth), 1e-15)
        far = air > camera.index * water
        high, low = np.where(far, a, high), np.where(far, low, a)
    a = np.where(depth > 0, 0.5 * (low + high), reach)
    ratio = np.where(reach > 0, a / np.maximum(reach, 1e-15), 1.0)
    on_top = np.where(points[..., 2] > 0, points[..., 2], 0.0)
    return np.concatenate([C[:2] + level * ratio[..., None], on_top[..., None]], axis=-1)


def project(camera: Camera, points: Array) -> Array:
    """Raw pixels (..., 2) of points (..., 3) in pool axes, submerged where z < 0."""
    R = Rotation.from_rotvec(camera.pose[:3]).as_matrix()
    P = (surface_crossing(camera, points) - np.asarray(camera.pose[3:])) @ R.T
    bent = distort(camera, P[..., :2] / P[..., 2:])
    return bent * np.asarray(camera.focal) + np.asarray(camera.centre)


def pixels_to_pool(camera: Camera, pixels: Array, depth: float) -> Array:
    """Pool coordinates (..., 2) at a depth (m) below the surface, from raw pixels (..., 2)."""
    R, C = Rotation.from_rotvec(camera.pose[:3]).as_matrix(), np.asarray(camera.pose[3:])
    p = undistort(camera, (pixels - np.asarray(camera.centre)) / np.asarray(camera.focal))
    ray = np.concatenate([p, np.ones_like(p[..., :1])], axis=-1) @ R
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    crossing = C + ray * (-C[2] / ray[..., 2:])
    bent = ray[..., :2] / camera.index
    down = np.sqrt(1 - np.sum(bent * bent, axis=-1, keepdims=True))
    return crossing[..., :2] + depth * bent / down


def corner_points(length: float, width: float, height: float) -> Array:
    """Pool corners (4, 3) at a height above the surface."""
    xy = np.array([[0, 0], [length, 0], [length, width], [0, width]], dtype=float)
    return np.column_stack([xy, np.full(4, height)])


def with_fitted_pose(camera: Camera, pixels: Array, corners: Array) -> Camera:
    """The camera with the pose that best explains the corners' pixels (4, 2)."""

    def residual(pose: Array) -> Array:
        return (project(replace(camera, pose=tuple(pose)), corners) - pixels).ravel()

    fit = least_squares(residual, camera.pose, x_scale=[0.01] * 3 + [0.01] * 3)
    return replace(camera, pose=tuple(fit.x))


def draw_pose(rng: np.random.Generator, height: float, tilt: float) -> tuple[float, ...]:
    """Pose of a camera at a height (m), tilted (rad), aimed near the pool's middle."""
    azimuth = rng.uniform(-np.pi, np.pi)
    away = height * np.tan(tilt)
    C = np.array([1.3 + away * np.cos(azimuth), 0.8 + away * np.sin(azimuth), height])
    forward = np.array([1.3, 0.8, 0.0]) + np.append(rng.normal(0, 0.04, 2), 0) - C
    forward /= np.linalg.norm(forward)
    turned = rng.normal(0, 0.04) + (np.pi if rng.random() < 0.4 else 0.0)
    right = np.array([np.cos(turned), np.sin(turned), 0.0])
    right -= forward * (right @ forward)
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(forward, right), forward])
    return (*Rotation.from_matrix(R).as_rotvec(), *C)


def draw_camera(rng: np.random.Generator, *, low: bool = False, tilted: bool = False) -> Camera:
    """A camera that sees the whole pool; `low` keeps it under 1.8 m, `tilted` beyond 25 deg."""
    height = rng.uniform(1.5, 1.8) if low else rng.uniform(1.6, 3.0)
    tilt = np.radians(rng.uniform(26, 34) if tilted else rng.uniform(1, 9))
    model = str(rng.choice(["pinhole", "fisheye"]))
    size = ((1920, 1080), (1280, 720), (2704, 1520), (3840, 2160))[
        rng.choice(4, p=[0.5, 0.1, 0.25, 0.15])
    ]
    pose = draw_pose(rng, height, tilt)
    bare = Camera(
        model, size, (1.0, 1.0), (0.0, 0.0), (0.0,) * (4 if model == "fisheye" else 5), pose
    )
    rim = float(np.max(np.linalg.norm(project(replace(bare, model="pinhole", distortion=(0.0,) * 5),
                                              corner_points(2.6, 1.6, 0.0)), axis=1)))  # fmt: skip
    k1 = -rng.uniform(0.02, 0.14) / rim**2
    if model == "fisheye":
        k = (rng.uniform(-0.03, 0.05), *rng.normal(0, 0.004, 3))
    else:
        k = (k1, 0.15 * abs(k1) / rim**2, *rng.normal(0, 4e-4, 2), 0.0)
    bent = np.abs(project(replace(bare, distortion=k), corner_points(2.6, 1.6, 0.05)))
    room = np.array(size) / 2 * 0.95
    focal = float(np.min(room / bent.max(axis=0)))
    centre = np.array(size) / 2 + rng.normal(0, 4, 2)
    return replace(bare, focal=(focal, focal * rng.uniform(0.998, 1.002)), distortion=k,
                   centre=(float(centre[0]), float(centre[1])))  # fmt: skip
