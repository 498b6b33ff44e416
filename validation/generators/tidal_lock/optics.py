"""Cameras above the pool: lens models, tilt, Snell's law, and the mapping a study implies."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from .robot import Robot

LOOKING_DOWN = np.diag([1.0, -1.0, -1.0])  # world to camera, without tilt


@dataclass(frozen=True)
class Camera:
    """Lens, pose and water as they are, or as a study states them.

    `position` in the pool frame, `rotation` a vector applied after looking straight down,
    `size` of the pool in m, `corners` in px (4, 2).
    """

    model: str
    image: tuple[int, int]
    focal: tuple[float, float]
    principal: tuple[float, float]
    distortion: tuple[float, ...]
    position: np.ndarray
    rotation: np.ndarray
    index: float
    depth: float
    size: tuple[float, float]
    corner_height: float
    corners: np.ndarray | None = None

    def corner_points(self) -> np.ndarray:
        """Pool corners (4, 3) in the pool frame."""
        length, width = self.size
        z = self.corner_height
        return np.array([[0, 0, z], [length, 0, z], [length, width, z], [0, width, z]], float)


def _turn(rotation: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(rotation).as_matrix() @ LOOKING_DOWN


def surface_crossing(points: np.ndarray, position: np.ndarray, index: float) -> np.ndarray:
    """Where the rays from submerged `points` (..., 3) to the camera leave the water.

    Newton's method on sin(air) = index sin(water); points above the surface are returned.
    """
    across = points[..., :2] - position[:2]
    total = np.linalg.norm(across, axis=-1) + 1e-12
    height, depth = position[2], np.maximum(-points[..., 2], 0.0)
    s = total * height / (height + depth / index)
    for _ in range(5):
        air, water = np.hypot(s, height), np.hypot(total - s, depth) + 1e-12
        miss = s / air - index * (total - s) / water
        s = s - miss / (height**2 / air**3 + index * depth**2 / water**3 + 1e-9)
    s = np.where(depth > 1e-9, s, total)
    crossing = np.concatenate(
        [position[:2] + across * (s / total)[..., None], np.zeros((*s.shape, 1))], axis=-1
    )
    return np.where(points[..., 2:] < 0, crossing, points)


def _normalised(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Image coordinates at unit focal length without distortion (..., 2)."""
    seen = surface_crossing(points, camera.position, camera.index)
    local = (seen - camera.position) @ _turn(camera.rotation).T
    return local[..., :2] / local[..., 2:]


def _distorted(camera: Camera, flat: np.ndarray) -> np.ndarray:
    """Distorted coordinates at unit focal length (..., 2)."""
    x, y = flat[..., 0], flat[..., 1]
    r2 = x**2 + y**2
    if camera.model == "fisheye":
        r = np.sqrt(r2) + 1e-12
        angle = np.arctan(r)
        powers = sum(k * angle ** (2 * i + 2) for i, k in enumerate(camera.distortion))
        return flat * (angle * (1 + powers) / r)[..., None]
    k1, k2, p1, p2, k3 = camera.distortion
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2)
    yd = y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y
    return np.stack([xd, yd], -1)


def project(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Raw pixels (..., 2) of points (..., 3) in the pool frame."""
    return _distorted(camera, _normalised(camera, points)) * camera.focal + camera.principal


def undistort(camera: Camera, pixels: np.ndarray) -> np.ndarray:
    """Image coordinates at unit focal length from raw pixels (n, 2), by fixed-point iteration."""
    seen = (pixels - np.array(camera.principal)) / np.array(camera.focal)
    flat = seen.copy()
    for _ in range(80):
        flat = flat + (seen - _distorted(camera, flat))
    return flat


def calibrated(camera: Camera) -> Camera:
    """The camera with its pose refitted to its own corners, lens and pool size."""
    marks, points = undistort(camera, camera.corners), camera.corner_points()

    def misfit(pose):
        local = (points - pose[:3]) @ _turn(pose[3:]).T
        return (local[:, :2] / local[:, 2:] - marks).ravel()

    pose = least_squares(misfit, np.concatenate([camera.position, camera.rotation])).x
    return replace(camera, position=pose[:3], rotation=pose[3:])


def locate(camera: Camera, pixels: np.ndarray) -> np.ndarray:
    """Pool positions (n, 2) at the camera's keypoint depth from raw pixels (n, 2)."""
    flat = undistort(camera, pixels)
    rays = np.column_stack([flat, np.ones(len(flat))]) @ _turn(camera.rotation)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    surface = camera.position - rays * (camera.position[2] / rays[:, 2:])
    sine = rays[:, :2] / camera.index
    cosine = np.sqrt(1 - np.sum(sine**2, axis=1, keepdims=True))
    return surface[:, :2] + camera.depth * sine / cosine


def draw_camera(rng: np.random.Generator, robot: Robot) -> Camera:
    """A camera that sees the whole pool, pinhole or fisheye, tilted up to some degrees."""
    model = str(rng.choice(["pinhole", "fisheye"], p=[0.65, 0.35]))
    image = ((1920, 1080), (1280, 720), (1440, 1080), (2560, 1440))[rng.integers(4)]
    length, width, _ = robot.pool
    height = length * (rng.uniform(0.7, 1.2) if model == "pinhole" else rng.uniform(0.45, 0.75))
    position = np.array([length * rng.uniform(0.45, 0.55), width * rng.uniform(0.44, 0.56), height])
    tilt = np.radians([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)])
    if model == "pinhole":
        distortion = (rng.uniform(-0.22, 0.04), rng.uniform(0, 0.04), *rng.normal(0, 4e-4, 2), 0.0)
    else:
        distortion = (rng.uniform(-0.04, 0.03), rng.uniform(-0.01, 0.01), 0.0, 0.0)
    principal = (image[0] / 2 + rng.normal(0, 8), image[1] / 2 + rng.normal(0, 8))
    camera = Camera(
        model,
        image,
        (1000.0, 1000.0),
        principal,
        tuple(float(k) for k in distortion),
        position,
        tilt,
        1.333 + rng.normal(0, 5e-4),
        robot.depth,
        (length, width),
        float(rng.choice([0.0, 0.0, 0.03, 0.06])),
    )
    offsets = project(camera, camera.corner_points()) - principal
    room = np.array([min(c, n - c) for c, n in zip(principal, image, strict=True)])
    focal = 1000.0 * rng.uniform(0.9, 0.96) * np.min(room / np.abs(offsets).max(axis=0))
    camera = replace(camera, focal=(focal, focal * rng.uniform(0.998, 1.002)))
    return replace(camera, corners=project(camera, camera.corner_points()))


def pixels_per_metre(camera: Camera) -> float:
    """Image scale at the pool's centre at keypoint depth."""
    x, y = camera.size[0] / 2, camera.size[1] / 2
    pair = np.array([[x - 0.05, y, -camera.depth], [x + 0.05, y, -camera.depth]])
    return float(np.linalg.norm(np.diff(project(camera, pair), axis=0)) / 0.1)
