"""A camera above still water: lens with distortion, pose, and refraction at the flat surface.

Pool frame: origin at a corner on the surface, x along the length, y along the width, z up (m).
The lens models are OpenCV's (pinhole: k1 k2 p1 p2 k3; fisheye: k1 to k4), written out here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .form import Array, Quantity

LOOK_DOWN = np.diag([1.0, -1.0, -1.0])
SIZES = [(1920, 1080), (1280, 720), (2704, 1520), (1920, 1440)]
MARGIN_PX = 15


@dataclass(frozen=True)
class Camera:
    """Lens and pose.

    size: px. rotation: vector (rad) added to looking straight down. eye: position, m.
    """

    model: str
    size: tuple[int, int]
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...]
    rotation: tuple[float, float, float]
    eye: tuple[float, float, float]

    def moved(self, change: Array) -> Camera:
        """The camera with its pose changed by three rotations (rad) and three shifts (m)."""
        rotation, eye = np.add(self.rotation, change[:3]), np.add(self.eye, change[3:])
        return replace(self, rotation=tuple(rotation), eye=tuple(eye))

    @property
    def world_to_camera(self) -> Array:
        """Rotation matrix from the pool frame to that of the camera."""
        return LOOK_DOWN @ rotation_matrix(self.rotation)


def rotation_matrix(vector: Sequence[float] | Array) -> Array:
    """Rotation matrix of a rotation vector (rad), by Rodrigues' formula."""
    turn = np.asarray(vector, float)
    angle = np.linalg.norm(turn)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = turn / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def distort(camera: Camera, a: Array, b: Array) -> tuple[Array, Array]:
    """Ideal image coordinates (X/Z, Y/Z) to distorted ones, before the matrix is applied."""
    r2 = a * a + b * b
    k = camera.distortion
    if camera.model == "fisheye":
        r = np.sqrt(r2)
        angle = np.arctan(r)
        bent = angle * (1 + k[0] * angle**2 + k[1] * angle**4 + k[2] * angle**6 + k[3] * angle**8)
        factor = np.where(r > 1e-9, bent / np.maximum(r, 1e-9), 1.0)
        return a * factor, b * factor
    factor = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
    return (
        a * factor + 2 * k[2] * a * b + k[3] * (r2 + 2 * a * a),
        b * factor + k[2] * (r2 + 2 * b * b) + 2 * k[3] * a * b,
    )


def monotonic(camera: Camera, r_max: float) -> bool:
    """Whether the radial distortion grows all the way out to the ideal radius r_max."""
    r = np.linspace(1e-3, r_max, 400)
    tangential = (2, 3) if camera.model == "pinhole" else ()
    radial = tuple(0.0 if i in tangential else v for i, v in enumerate(camera.distortion))
    distorted = distort(replace(camera, distortion=radial), r, 0 * r)[0]
    return bool(np.all(np.diff(distorted) > 0.15 * np.diff(r)))


def pixel(camera: Camera, x: Array, y: Array, z: Quantity) -> tuple[Array, Array]:
    """Pixels of points in air (x, y, z in m)."""
    eye = camera.eye
    ray = np.stack(np.broadcast_arrays(x - eye[0], y - eye[1], z - eye[2]))
    X, Y, Z = np.tensordot(camera.world_to_camera, ray, 1)
    a, b = distort(camera, X / Z, Y / Z)
    return camera.fx * a + camera.cx, camera.fy * b + camera.cy


def surface_point(
    camera: Camera, x: Array, y: Array, depth: Array, index: float
) -> tuple[Array, Array]:
    """Where the ray from a point at the given depth (m) crosses the surface towards the eye.

    Snell: sin(air) = index sin(water); solved for the horizontal distance by Newton's method.
    """
    dx, dy, height = x - camera.eye[0], y - camera.eye[1], camera.eye[2]
    distance = np.hypot(dx, dy)
    d = np.maximum(depth, 1e-9)
    r = distance * height / (height + d / index)
    for _ in range(5):
        in_air = np.sqrt(r * r + height * height)
        in_water = np.sqrt((distance - r) ** 2 + d * d)
        residual = r / in_air - index * (distance - r) / in_water
        r = r - residual / (height * height / in_air**3 + index * d * d / in_water**3)
    share = np.where(distance > 1e-9, r / np.maximum(distance, 1e-9), 1.0)
    return camera.eye[0] + share * dx, camera.eye[1] + share * dy


def project(camera: Camera, x: Array, y: Array, depth: Array, index: float) -> tuple[Array, Array]:
    """Pixels (u, v) of points under water (m)."""
    across, along = surface_point(camera, x, y, depth, index)
    return pixel(camera, across, along, 0.0 * across)


def unproject(
    camera: Camera, u: Array, v: Array, depth: Array, index: float
) -> tuple[Array, Array]:
    """Inverse of `project` at a known depth (m), by Newton's method in x and y."""
    x, y = np.full_like(u, camera.eye[0]), np.full_like(v, camera.eye[1])
    step = 1e-5
    for _ in range(25):
        u0, v0 = project(camera, x, y, depth, index)
        ux, vx = project(camera, x + step, y, depth, index)
        uy, vy = project(camera, x, y + step, depth, index)
        a, b, c, d = (ux - u0) / step, (uy - u0) / step, (vx - v0) / step, (vy - v0) / step
        det = a * d - b * c
        x = x + (d * (u - u0) - b * (v - v0)) / det
        y = y + (a * (v - v0) - c * (u - u0)) / det
    return x, y


def corner_pixels(camera: Camera, size: Sequence[float] | Array, height: float) -> Array:
    """Pixels (4, 2) of the marks at (0, 0), (L, 0), (L, W), (0, W), `height` m above the water."""
    length, width = size
    x, y = np.array([0, length, length, 0.0]), np.array([0, 0, width, width])
    return np.stack(pixel(camera, x, y, np.full(4, height)), axis=1)


def _draw_lens(rng: np.random.Generator, size: tuple[int, int], *, fisheye: bool) -> Camera:
    """Lens and tilt of a camera that is not placed yet."""
    field_of_view = np.radians(rng.uniform(55, 95))
    fx = size[0] / 2 / (field_of_view / 2 if fisheye else np.tan(field_of_view / 2))
    if fisheye:
        low, high = [-0.05, -0.02, -0.01, -0.005], [0.04, 0.02, 0.01, 0.005]
    else:
        low = [-0.24, -0.02, -0.0012, -0.0012, -0.01]
        high = [0.03, 0.06, 0.0012, 0.0012, 0.01]
    distortion = tuple(rng.uniform(low, high).round(4 if fisheye else 5))
    tilt = np.radians(rng.uniform(1, 12)) * np.exp(1j * rng.uniform(-np.pi, np.pi))
    turn = np.radians(rng.normal(0, 2.5))
    return Camera(
        "fisheye" if fisheye else "pinhole",
        size,
        round(fx, 2),
        round(fx * rng.uniform(0.995, 1.005), 2),
        round(size[0] / 2 + rng.normal(0, 12), 2),
        round(size[1] / 2 + rng.normal(0, 10), 2),
        distortion,
        (tilt.real, tilt.imag, turn),
        (0, 0, 0),
    )


def _placed(camera: Camera, pool: tuple[float, float], above: float) -> Camera:
    """The camera `above` m over the water, looking at the middle of the pool."""
    look = rotation_matrix(camera.rotation).T @ [0, 0, -1.0]
    x = pool[0] / 2 - look[0] / -look[2] * above
    y = pool[1] / 2 - look[1] / -look[2] * above
    return replace(camera, eye=(float(x), float(y), float(above)))


def _sees_all(camera: Camera, pool: tuple[float, float], height: float) -> bool:
    """Whether all marks are in the picture, where the distortion is still monotonic."""
    length, width = pool
    corners = [[0, 0, height], [length, 0, height], [length, width, height], [0, width, height]]
    rays = (np.array(corners) - camera.eye) @ camera.world_to_camera.T
    if np.any(rays[:, 2] < 0.1 * camera.eye[2]):
        return False
    r_max = np.hypot(rays[:, 0], rays[:, 1]).max() / rays[:, 2].min()
    pixels = corner_pixels(camera, pool, height)
    inside = np.all(pixels > MARGIN_PX) and np.all(pixels < np.array(camera.size) - MARGIN_PX)
    return bool(inside) and monotonic(camera, 1.1 * r_max)


def draw_camera(
    rng: np.random.Generator,
    pool: tuple[float, float],
    height: float,
    *,
    fisheye: bool | None = None,
) -> Camera:
    """A camera that sees the whole pool: lens, pose (tilt of a few degrees) and picture size.

    height: of the marks above the water, m. fisheye: drawn where None.
    """
    size = SIZES[rng.integers(4)]
    fisheye = rng.random() < 0.25 if fisheye is None else fisheye
    for _ in range(200):
        lens = _draw_lens(rng, size, fisheye=fisheye)
        for above in np.geomspace(0.4, 3.0, 60) * pool[0]:
            camera = _placed(lens, pool, above)
            if _sees_all(camera, pool, height):
                return camera
    raise RuntimeError("no camera sees the whole pool")
