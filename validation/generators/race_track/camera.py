"""Camera above the pool: pinhole or fisheye lens, tilted mount, refraction at the still surface.

The refracted ray is found from Snell's law at the surface, n sin(in water) = sin(in air), by
Newton's method on the place where it leaves the water.
Lens models: D. C. Brown (1966); J. Kannala, S. S. Brandt, IEEE Trans. PAMI 28 (2006) 1335.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .robots import Array


@dataclass(frozen=True)
class Camera:
    """position: (3,) m. rotation: (3, 3), pool to camera axes. index: of the water."""

    model: str
    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    position: Array
    rotation: Array
    index: float

    def film(self, z: Array, depth: Array) -> Array:
        """Pixels of points under water. z: complex (m). depth: below the surface (m)."""
        away = z - complex(*self.position[:2])
        far = np.abs(away) + 1e-12
        leave = _surface_radius(far, depth, self.position[2], self.index)
        foot = away * leave / far + complex(*self.position[:2])
        return self.project(np.stack([foot.real, foot.imag, 0 * foot.real], axis=-1))

    def project(self, points: Array) -> Array:
        """Pixels of points (..., 3) in air."""
        x, y, depth = np.moveaxis((points - self.position) @ self.rotation.T, -1, 0)
        lens = _fisheye if self.model == "fisheye" else _brown
        a, b = lens(x / depth, y / depth, self.distortion)
        return np.stack(
            [self.focal[0] * a + self.centre[0], self.focal[1] * b + self.centre[1]], axis=-1
        )


def _surface_radius(far: Array, depth: Array, height: float, index: float) -> Array:
    """Distance from the camera's foot at which the ray leaves the water (m)."""
    s = far * height / (height + depth / index)
    for _ in range(6):
        above, below = np.hypot(s, height), np.hypot(far - s, depth) + 1e-12
        miss = s / above - index * (far - s) / below
        slope = height**2 / above**3 + index * depth**2 / below**3
        s = np.clip(s - miss / slope, 0, far)
    return np.asarray(s)


def _brown(x: Array, y: Array, k: tuple[float, ...]) -> tuple[Array, Array]:
    r2 = x * x + y * y
    radial = 1 + k[0] * r2 + k[1] * r2**2 + k[4] * r2**3
    return (
        x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
        y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y,
    )


def _fisheye(x: Array, y: Array, k: tuple[float, ...]) -> tuple[Array, Array]:
    r = np.hypot(x, y) + 1e-12
    t = np.arctan(r)
    bent = t * (1 + k[0] * t**2 + k[1] * t**4 + k[2] * t**6 + k[3] * t**8)
    return x * bent / r, y * bent / r


def corner_points(pool: tuple[float, float], height: float) -> Array:
    """Marks at the corners (0,0), (L,0), (L,W), (0,W), (4, 3)."""
    length, width = pool
    return np.array(
        [[0, 0, height], [length, 0, height], [length, width, height], [0, width, height]]
    )


def _mount(rng: np.random.Generator) -> Array:
    """Rotation of a camera that looks down, tilted by up to some degrees."""
    down = np.diag([1.0, -1.0, -1.0])
    a, b, c = np.radians(rng.normal(0, [1.5, 1.5, 1.0]))
    roll = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    pitch = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    yaw = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return np.asarray(yaw @ pitch @ roll @ down)


def draw_camera(rng: np.random.Generator, pool: tuple[float, float]) -> Camera:
    """A camera that sees the whole pool; its lens rounded as a calibration states it."""
    fisheye = rng.random() < 0.35
    size = (1920, 1080) if pool[0] < 4 else (3840, 2160)
    height = round(
        float(pool[0] * (rng.uniform(0.55, 0.8) if fisheye else rng.uniform(0.85, 1.2))), 3
    )
    position = np.array([
        pool[0] * rng.uniform(0.47, 0.53), pool[1] * rng.uniform(0.46, 0.54), height,
    ])  # fmt: skip
    lens = (-0.02, 0.004, -0.001, 0.0) if fisheye else (-0.18, 0.05, 0.0006, -0.0005, -0.01)
    distortion = tuple(round(float(k * rng.uniform(0.5, 1.3)), 5) for k in lens)
    centre = (size[0] / 2 + round(rng.normal(0, 12), 1), size[1] / 2 + round(rng.normal(0, 12), 1))
    unit = Camera("fisheye" if fisheye else "pinhole", size, (1.0, 1.0), (0.0, 0.0), distortion,
                  position, _mount(rng), 1.333)  # fmt: skip
    reach = np.abs(unit.project(corner_points(pool, 0.0))).max(axis=0)
    focal = round(
        float(0.92 * min((size[0] / 2 - 30) / reach[0], (size[1] / 2 - 30) / reach[1])), 1
    )
    return Camera(
        unit.model, size, (focal, focal), centre, distortion, position, unit.rotation, 1.333
    )
