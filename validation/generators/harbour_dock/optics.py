"""Camera above flat water: exact refraction, two lens models, pose from the basin's corners."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

DOWNWARDS = np.diag([1.0, -1.0, -1.0])
"""Pool axes to the axes of a camera that looks straight down, image x along the basin."""
WATER_INDEX = 1.333
SIZES = [(1920, 1080), (2704, 1520), (3840, 2160), (2560, 1440)]


@dataclass
class Lens:
    """model: `pinhole` or `fisheye`; k: fx, fy, cx, cy (px); dist: distortion as in OpenCV."""

    model: str
    k: list[float]
    dist: list[float]


@dataclass(frozen=True)
class Pose:
    """position: (3,) or (points, 3), pool axes, m; rotation: pool axes to camera axes."""

    position: np.ndarray
    rotation: np.ndarray


@dataclass
class Camera:
    """The true camera. size: px; rotation_vector: rad; position: m; marks_height: m above water."""

    size: tuple[int, int]
    lens: Lens
    rotation_vector: np.ndarray
    position: np.ndarray
    marks_height: float
    index: float
    metres_per_px: float

    def pose(self, shift: np.ndarray | float = 0.0) -> Pose:
        """The pose, with the position moved by `shift` (m)."""
        return Pose(self.position + shift, pose_matrix(self.rotation_vector))


def pose_matrix(rotation_vector: np.ndarray) -> np.ndarray:
    """Pool axes to camera axes; zero rotation looks straight down."""
    return Rotation.from_rotvec(rotation_vector).as_matrix() @ DOWNWARDS


def _fisheye_angle(dist: list[float], angle: np.ndarray) -> np.ndarray:
    """Distorted angle to the axis, rad."""
    t2 = angle * angle
    return angle * (1 + t2 * (dist[0] + t2 * (dist[1] + t2 * (dist[2] + t2 * dist[3]))))


def distort(lens: Lens, points: np.ndarray) -> np.ndarray:
    """OpenCV's pinhole (k1 k2 p1 p2 k3) or fisheye (k1..k4) distortion of normalised points."""
    x, y = points[:, 0], points[:, 1]
    r2 = x * x + y * y
    if lens.model == "fisheye":
        r = np.sqrt(r2) + 1e-12
        return points * (_fisheye_angle(lens.dist, np.arctan(r)) / r)[:, None]
    k1, k2, p1, p2, k3 = lens.dist
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return np.stack([
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
    ], 1)  # fmt: skip


def undistort(lens: Lens, points: np.ndarray) -> np.ndarray:
    """Inverse of `distort`."""
    if lens.model == "fisheye":
        seen = np.hypot(points[:, 0], points[:, 1]) + 1e-12
        angle, dist = seen.copy(), lens.dist
        for _ in range(12):
            t2 = angle * angle
            slope = 1 + t2 * (
                3 * dist[0] + t2 * (5 * dist[1] + t2 * (7 * dist[2] + t2 * 9 * dist[3]))
            )
            angle = angle - (_fisheye_angle(dist, angle) - seen) / slope
        return points * (np.tan(angle) / seen)[:, None]
    found = points.copy()
    for _ in range(60):
        found = found - (distort(lens, found) - points)
    return found


def surface_point(
    camera: np.ndarray, points: np.ndarray, depth: np.ndarray, index: float
) -> np.ndarray:
    """Where rays from points under water to the camera cross the surface (Snell's law), m."""
    across = points - camera[:, :2]
    far = np.hypot(across[:, 0], across[:, 1]) + 1e-12
    height = camera[:, 2]
    at = far * height / (height + depth / index)
    for _ in range(8):
        dry, wet = np.hypot(at, height), np.hypot(far - at, depth) + 1e-15
        miss = at / dry - index * (far - at) / wet
        at = at - miss / (height**2 / dry**3 + index * depth**2 / wet**3 + 1e-15)
    return camera[:, :2] + across * (at / far)[:, None]


def project(
    points: np.ndarray, depth: np.ndarray, pose: Pose, lens: Lens, *,
    index: float, roll: np.ndarray | float = 0.0,
) -> np.ndarray:  # fmt: skip
    """Pixels of points (N, 2) at depths (N; m; negative: above water, no refraction).

    roll: of the camera about the vertical beside its pose, rad.
    """
    camera = np.broadcast_to(pose.position, (len(points), 3))
    surface = surface_point(camera, points, np.maximum(depth, 0), index)
    ray = np.column_stack([surface - camera[:, :2], -camera[:, 2]])
    dry = depth < 0
    ray[dry] = np.column_stack([points - camera[:, :2], -depth - camera[:, 2]])[dry]
    c, s = np.cos(roll), np.sin(roll)
    ray = np.column_stack(
        [c * ray[:, 0] + s * ray[:, 1], -s * ray[:, 0] + c * ray[:, 1], ray[:, 2]]
    )
    seen = ray @ pose.rotation.T
    x, y = distort(lens, seen[:, :2] / seen[:, 2:]).T
    return np.column_stack([lens.k[0] * x + lens.k[2], lens.k[1] * y + lens.k[3]])


def unproject(
    pixels: np.ndarray, depth: float, pose: Pose, lens: Lens, *, index: float
) -> np.ndarray:
    """Pool coordinates (m) of pixels at a depth (m): what an analyst computes."""
    k, camera = lens.k, pose.position
    distorted = np.column_stack([(pixels[:, 0] - k[2]) / k[0], (pixels[:, 1] - k[3]) / k[1]])
    seen = undistort(lens, distorted)
    ray = np.column_stack([seen, np.ones(len(seen))]) @ pose.rotation
    across = ray[:, :2]
    surface = camera[:2] + (-camera[2] / ray[:, 2])[:, None] * across
    length = np.hypot(across[:, 0], across[:, 1]) + 1e-15
    sine = length / np.sqrt(length**2 + ray[:, 2] ** 2) / index
    return surface + across / length[:, None] * (depth * sine / np.sqrt(1 - sine**2))[:, None]


def corners(length: float, width: float) -> np.ndarray:
    """(0, 0), (length, 0), (length, width), (0, width)."""
    return np.array([[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]])


def mark_depth(height: float) -> np.ndarray:
    """Depth of the four corner marks, which are `height` (m) above the water."""
    return np.full(4, -max(height, 1e-9))


def fit_pose(
    pixels: np.ndarray, marks: np.ndarray, height: float, lens: Lens, guess: np.ndarray
) -> Pose:
    """From the four corner marks; `guess` is rotation vector and position in one array."""

    def miss(numbers: np.ndarray) -> np.ndarray:
        pose = Pose(numbers[3:], pose_matrix(numbers[:3]))
        found = project(marks, mark_depth(height), pose, lens, index=WATER_INDEX)
        return (found - pixels).ravel()

    scale = np.array([0.01, 0.01, 0.01, 0.1, 0.1, 0.1])
    found = least_squares(miss, guess, x_scale=scale, xtol=1e-13, ftol=1e-13, gtol=1e-13).x
    return Pose(found[3:], pose_matrix(found[:3]))


def _draw_distortion(rng: Generator, model: str) -> list[float]:
    if model == "fisheye":
        drawn = [rng.uniform(-0.04, 0.04), rng.uniform(-0.01, 0.01), 0.0, 0.0]
    else:
        drawn = [rng.uniform(-0.11, -0.02), rng.uniform(0.0, 0.015), rng.normal(0, 3e-4),
                 rng.normal(0, 3e-4), 0.0]  # fmt: skip
    return [round(float(value), 6) for value in drawn]


def draw_camera(rng: Generator, pool: tuple[float, float, float]) -> Camera:
    """A camera that sees the whole basin; pool: length, width, depth (m)."""
    length, width, _ = pool
    size = SIZES[int(rng.integers(len(SIZES)))]
    model = "fisheye" if rng.random() < 0.35 else "pinhole"
    height = float(length * rng.uniform(0.62, 1.0))
    if model == "fisheye":
        height = float(length * rng.uniform(0.5, 0.8))
    lens = Lens(model, [], _draw_distortion(rng, model))
    edge = np.array([[0.5 * length / height, 0.0], [0.0, 0.5 * width / height]])
    edge_seen = np.abs(distort(lens, edge))
    focal = 0.45 * min(size[0] / edge_seen[0, 0], size[1] / edge_seen[1, 1])
    focal *= rng.uniform(0.93, 1.0)
    k = [focal, focal * (1 + rng.normal(0, 5e-4)), size[0] / 2 + rng.normal(0, 8),
         size[1] / 2 + rng.normal(0, 8)]  # fmt: skip
    lens.k = [round(float(value), 3) for value in k]
    tilt = np.array([rng.normal(0, 0.010), rng.normal(0, 0.010), rng.normal(0, 0.015)])
    aim = pose_matrix(tilt).T @ np.array([0.0, 0.0, 1.0])
    centre = np.array([length / 2, width / 2]) + rng.normal(0, 0.01 * length, 2)
    position = np.array([*(centre + height * aim[:2] / aim[2] * 1.0), height])
    above = float(rng.choice([0.0, 0.0, round(float(rng.uniform(0.03, 0.2)), 3)]))
    return Camera(size, lens, tilt, position, above, WATER_INDEX, height / focal)
