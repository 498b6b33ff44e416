"""Camera above the pool: Snell's law at a flat surface, pinhole or fisheye lens, pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .form import POOL_LENGTH, POOL_WIDTH, Array, Quantity

WATER_INDEX = 1.333
FISHEYE_SHARE = 0.25


def rotation_about(axis: int, angle: float) -> Array:
    """Matrix (3, 3) of the rotation about a coordinate axis by an angle (rad)."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


@dataclass(frozen=True)
class Camera:
    """Lens and pose of a camera.

    model: pinhole or fisheye. size, focal, center: px. distortion: OpenCV's coefficients of the
    model. position: m. rotation: (3, 3), from pool axes to camera axes (x right, y down, z into the
    scene). index: refractive index of the water.
    """

    model: str
    size: tuple[int, int]
    focal: tuple[float, float]
    center: tuple[float, float]
    distortion: tuple[float, ...]
    position: Array
    rotation: Array
    index: float = WATER_INDEX

    def project(self, points: Array) -> Array:
        """Pixels (..., 2) of points (..., 3) in the pool frame, refracted if below the surface."""
        offset = points[..., :2] - self.position[:2]
        share = self._surface_share(np.linalg.norm(offset, axis=-1) + 1e-12, points[..., 2])
        above = np.maximum(points[..., 2:], 0)
        on_top = np.concatenate([self.position[:2] + share[..., None] * offset, above], -1)
        ray = (on_top - self.position) @ self.rotation.T
        return self._through_lens(ray[..., 0] / ray[..., 2], ray[..., 1] / ray[..., 2])

    def _surface_share(self, far: Array, z: Array) -> Array:
        """Share of the horizontal distance `far` (m) at which the ray crosses the surface.

        Snell's law sin a = n sin b, solved by bisection; 1 for points above the surface.
        """
        depth, height = np.maximum(-z, 0), self.position[2]
        low, high = np.zeros_like(far), far.copy()
        for _ in range(45):
            middle = (low + high) / 2
            rest = far - middle
            sine_below = rest / np.maximum(np.hypot(rest, depth), 1e-12)
            excess = middle / np.hypot(middle, height) - self.index * sine_below
            low, high = np.where(excess < 0, middle, low), np.where(excess < 0, high, middle)
        return np.where(depth > 0, low / far, 1.0)

    def _through_lens(self, a: Quantity, b: Quantity) -> Array:
        """Pixels (..., 2) of the normalised coordinates a, b."""
        distort = self._fisheye if self.model == "fisheye" else self._pinhole
        a, b = distort(a, b)
        (fx, fy), (cx, cy) = self.focal, self.center
        return np.stack([fx * a + cx, fy * b + cy], -1)

    def _fisheye(self, a: Quantity, b: Quantity) -> tuple[Quantity, Quantity]:
        """Distorted coordinates: t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8), t the angle."""
        r = np.hypot(a, b) + 1e-15
        t = np.arctan(r)
        k = self.distortion
        bent = t * (1 + k[0] * t**2 + k[1] * t**4 + k[2] * t**6 + k[3] * t**8) / r
        return a * bent, b * bent

    def _pinhole(self, a: Quantity, b: Quantity) -> tuple[Quantity, Quantity]:
        """Distorted coordinates of Brown and Conrady's model (k1, k2, p1, p2, k3)."""
        k1, k2, p1, p2, k3 = self.distortion
        q = a * a + b * b
        radial = 1 + k1 * q + k2 * q**2 + k3 * q**3
        return (
            a * radial + 2 * p1 * a * b + p2 * (q + 2 * a * a),
            b * radial + p1 * (q + 2 * b * b) + 2 * p2 * a * b,
        )

    def bumped(self, about_x: float, about_y: float, slide: Quantity) -> Camera:
        """The camera after a bump: tilted by two angles (rad) and moved by `slide` (2,) m."""
        return replace(
            self,
            rotation=rotation_about(0, about_x) @ rotation_about(1, about_y) @ self.rotation,
            position=self.position + np.array([*slide, 0.0]),
        )


def corner_points(height: float) -> Array:
    """Marks (4, 3) at the corners of the pool, `height` m above the water."""
    corners = [(0, 0), (POOL_LENGTH, 0), (POOL_LENGTH, POOL_WIDTH), (0, POOL_WIDTH)]
    return np.array([[x, y, height] for x, y in corners], float)


def draw_camera(rng: np.random.Generator) -> Camera:
    """A camera that sees the whole pool, tilted and off the middle."""
    size = [(1920, 1080), (2704, 1520), (1280, 720)][rng.choice(3, p=[0.5, 0.3, 0.2])]
    fisheye = rng.random() < FISHEYE_SHARE
    x = POOL_LENGTH / 2 + rng.normal(0, 0.12)
    y = POOL_WIDTH / 2 + rng.normal(0, 0.08)
    position = np.array([x, y, rng.uniform(2.3, 3.1)])
    aim = np.array([POOL_LENGTH / 2 - position[0], POOL_WIDTH / 2 - position[1]]) / position[2]
    roll = rotation_about(2, rng.normal(0, 0.02))
    tilt = rotation_about(0, -aim[1] * 0.9), rotation_about(1, -aim[0] * 0.9)
    rotation = roll @ tilt[0] @ tilt[1] @ np.diag([1.0, -1.0, -1.0])
    focal = size[0] * rng.uniform(0.78, 0.86) * position[2] / POOL_LENGTH
    focal = min(focal, size[1] * 0.86 * position[2] / POOL_WIDTH)
    focal *= 1.05 if fisheye else 1.0
    distortion = tuple(map(float, _draw_distortion(rng, fisheye=fisheye)))
    center = (size[0] / 2 + rng.normal(0, 8), size[1] / 2 + rng.normal(0, 8))
    pair = (focal, focal * (1 + rng.normal(0, 0.001)))
    model = "fisheye" if fisheye else "pinhole"
    return Camera(model, size, pair, center, distortion, position, rotation)


def _draw_distortion(rng: np.random.Generator, *, fisheye: bool) -> tuple[float, ...]:
    if fisheye:
        spans = ((-0.03, 0.03), (-0.01, 0.01), (-0.003, 0.003))
        return (*(rng.uniform(*span) for span in spans), 0.0)
    return (rng.uniform(-0.12, 0.02), rng.uniform(0, 0.03), *rng.normal(0, 0.0006, 2), 0.0)
