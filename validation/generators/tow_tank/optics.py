"""A camera above the tank: rays bent at the surface, a distorting lens, and the way back.

Pool frame: metres, z up, surface at 0. The way back uses what the study states, so that wrong
statements move the robot as they would in an analysis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from .robots import Array

WATER_INDEX = 1.333
DOWNWARD_ROTATION = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Camera:
    """True camera: lens, place and attitude over a pool, and what the study says of them."""

    size: tuple[int, int]
    matrix: Array
    distortion: Array
    rotation: Array
    place: Array
    pool: tuple[float, float, float]
    corner_height: float
    fisheye: bool = False
    index: float = WATER_INDEX

    def corners(self) -> Array:
        """Images of the pool's corners, (4, 2), px."""
        length, width, _ = self.pool
        marks = [[0, 0], [length, 0], [length, width], [0, width]]
        return self.lens(np.column_stack([np.array(marks), np.full(4, self.corner_height)]))

    def lens(self, points: Array) -> Array:
        """Images of points in air, (n, 3) m -> (n, 2) px."""
        p = (points - self.place) @ self.rotation.T
        a, b = p[:, 0] / p[:, 2], p[:, 1] / p[:, 2]
        distort = _fisheye_distortion if self.fisheye else _brown_distortion
        a, b = distort(a, b, self.distortion)
        fx, fy = self.matrix[0, 0], self.matrix[1, 1]
        return np.column_stack([fx * a + self.matrix[0, 2], fy * b + self.matrix[1, 2]])

    def see(self, points: Array, depth: Array | float) -> Array:
        """Images of points under water: complex (n,) m, depth m -> (n, 2) px."""
        offset = points - complex(self.place[0], self.place[1])
        rho, height = np.abs(offset), self.place[2]
        s = rho * height / (height + depth / self.index)
        for _ in range(6):  # Newton: sin(i) = n sin(r) at distance s from the foot
            a, b = np.hypot(s, height), np.hypot(rho - s, depth)
            gap = s / a - self.index * (rho - s) / b
            s = s - gap / (height**2 / a**3 + self.index * depth**2 / b**3)
        surface = complex(self.place[0], self.place[1]) + offset * s / np.maximum(rho, 1e-12)
        return self.lens(np.column_stack([surface.real, surface.imag, np.zeros(len(points))]))


def _brown_distortion(a: Array, b: Array, k: Array) -> tuple[Array, Array]:
    r2 = a * a + b * b
    radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
    return (a * radial + 2 * k[2] * a * b + k[3] * (r2 + 2 * a * a),
            b * radial + k[2] * (r2 + 2 * b * b) + 2 * k[3] * a * b)  # fmt: skip


def _fisheye_distortion(a: Array, b: Array, k: Array) -> tuple[Array, Array]:
    r = np.hypot(a, b)
    t = np.arctan(r)
    bent = t * (1 + k[0] * t**2 + k[1] * t**4 + k[2] * t**6 + k[3] * t**8)
    ratio = np.where(r > 1e-12, bent / np.maximum(r, 1e-12), 1.0)
    return a * ratio, b * ratio


def draw_camera(rng: np.random.Generator, pool: tuple[float, float, float]) -> Camera:
    """A camera above the middle of the pool that sees all of its corners."""
    size = [(1920, 1080), (2704, 1520), (2560, 1440)][rng.integers(3)]
    fisheye = bool(rng.random() < 0.25)
    focal = size[0] * rng.uniform(0.58, 0.75)
    matrix = np.array([[focal, 0, size[0] / 2 + rng.normal(0, 6)],
                       [0, focal * rng.uniform(0.998, 1.002), size[1] / 2 + rng.normal(0, 6)],
                       [0, 0, 1.0]])  # fmt: skip
    if fisheye:
        lens = np.array([rng.uniform(-0.05, 0.06), rng.uniform(-0.02, 0.02), 2e-3, -1e-3])
    else:
        lens = np.array([rng.uniform(-0.16, 0.04), rng.uniform(-0.01, 0.03),
                         *rng.normal(0, 3e-4, 2), 0.0])  # fmt: skip
    tilt = np.deg2rad(rng.normal(0, [1.5, 1.5, 1.0]))
    rotation = cv2.Rodrigues(tilt)[0] @ DOWNWARD_ROTATION
    middle = np.array([pool[0] / 2, pool[1] / 2]) + rng.normal(0, 0.05, 2)
    camera = Camera(size, matrix, lens, rotation, np.array([*middle, 1.0]), pool,
                    float(rng.choice([0.0, rng.uniform(0.03, 0.12)])), fisheye)  # fmt: skip
    for height in np.arange(1.2, 9.0, 0.05):
        camera = replace(camera, place=np.array([*middle, height]))
        px = camera.corners()
        if np.all(px > 25) and np.all(px < np.array(size) - 25):
            break
    return camera


@dataclass(frozen=True)
class StatedSetup:
    """What study.yaml says: pool, water, depth of the keypoints, lens and corners."""

    pool: tuple[float, float, float]
    index: float
    depth: float
    matrix: Array
    distortion: Array
    corners: Array
    corner_height: float
    fisheye: bool

    def back(self, px: Array) -> Array:
        """Places under water by the stated numbers, (n, 2) px -> complex (n,) m."""
        length, width, _ = self.pool
        marks = np.array([[0, 0], [length, 0], [length, width], [0, width]])
        world = np.column_stack([marks, np.full(4, self.corner_height)])
        flat = self._undistorted(self.corners)
        # the flat target has mirrored solutions; iteration starts at a camera above the middle
        above = np.array([length / 2, width / 2, 2.0])
        done = cv2.solvePnP(
            world,
            flat,
            np.eye(3),
            None,
            cv2.Rodrigues(DOWNWARD_ROTATION)[0],
            -DOWNWARD_ROTATION @ above,
            True,
            cv2.SOLVEPNP_ITERATIVE,
        )
        R, t = cv2.Rodrigues(done[1])[0], done[2].ravel()
        eye = -R.T @ t
        ray = np.column_stack([self._undistorted(px), np.ones(len(px))]) @ R
        ray /= np.linalg.norm(ray, axis=1)[:, None]
        surface = eye + ray * (-eye[2] / ray[:, 2])[:, None]
        inside = ray[:, :2] / self.index
        down = self.depth / np.sqrt(1 - (inside**2).sum(1))
        at = surface[:, :2] + inside * down[:, None]
        return at[:, 0] + 1j * at[:, 1]

    def _undistorted(self, px: Array) -> Array:
        """Ideal image at unit focal length, (n, 2): fixed point of the stated lens."""
        focal, middle = self.matrix[[0, 1], [0, 1]], self.matrix[[0, 1], [2, 2]]
        a0, b0 = a, b = ((px - middle) / focal).T
        distort = _fisheye_distortion if self.fisheye else _brown_distortion
        for _ in range(45):
            x, y = distort(a, b, self.distortion)
            a, b = np.clip(a + a0 - x, -2, 2), np.clip(b + b0 - y, -2, 2)
        return np.column_stack([a, b])


def true_statement(camera: Camera, depth: float) -> StatedSetup:
    """A true statement of everything."""
    return StatedSetup(camera.pool, camera.index, depth, camera.matrix, camera.distortion,
                  camera.corners(), camera.corner_height, camera.fisheye)  # fmt: skip
