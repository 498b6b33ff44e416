"""A camera above the pool: rays through a lens and a flat water surface.

World: pool frame, z up from the still surface, m. Camera: x right, y down, z ahead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Camera:
    """Lens (matrix, distortion), pose (rotation vector; place, m) and the index of the water."""

    fisheye: bool
    size: tuple[int, int]
    matrix: Array
    distortion: Array
    turn: Array
    place: Array
    index: float = 1.333

    def project(self, points: Array) -> Array:
        """Pixels (..., 2) of points (..., 3) seen through air."""
        seen = (points - self.place) @ Rotation.from_rotvec(self.turn).as_matrix().T
        bend = kannala_brandt_distortion if self.fisheye else brown_distortion
        plane = bend(seen[..., :2] / seen[..., 2:], self.distortion)
        return plane * np.diag(self.matrix)[:2] + self.matrix[:2, 2]

    def see(self, at: Complex, depth: Array | float) -> Array:
        """Pixels (..., 2) of points below the surface; at: m, complex; depth: m."""
        return self.project(self.surface(at, depth))

    def surface(self, at: Complex, depth: Array | float, rounds: int = 9) -> Array:
        """Points (..., 3) where the rays to the camera cross the surface.

        A ray is cast to a trial point and on to the depth; the trial point moves by the miss.
        """
        crossing = np.asarray(at, complex)
        for _ in range(rounds):
            crossing = crossing + (at - self.cast(crossing, depth))
        return np.stack([crossing.real, crossing.imag, 0 * crossing.real], -1)

    def cast(self, crossing: Complex, depth: Array | float) -> Complex:
        """Places at the depth that the ray from the camera through a surface point meets.

        Snell's law as vectors: t = i/n + (cos a/n - cos b) z (Glassner, Ray Tracing, ch. 4).
        """
        away = crossing - (self.place[0] + 1j * self.place[1])
        far = np.sqrt(np.abs(away) ** 2 + self.place[2] ** 2)
        side = away / far / self.index
        return np.asarray(crossing + side * depth / np.sqrt(1 - np.abs(side) ** 2))

    def back(self, px: Array, depth: Array | float, guess: Complex, rounds: int = 3) -> Complex:
        """Places, m, complex, at the depth whose images are px, by Newton's method."""
        at, step = guess, 1e-4
        for _ in range(rounds):
            here = self.see(at, depth)
            right = (self.see(at + step, depth) - here) / step
            up = (self.see(at + 1j * step, depth) - here) / step
            miss = px - here
            det = right[..., 0] * up[..., 1] - right[..., 1] * up[..., 0]
            dx = (miss[..., 0] * up[..., 1] - miss[..., 1] * up[..., 0]) / det
            dy = (right[..., 0] * miss[..., 1] - right[..., 1] * miss[..., 0]) / det
            at = at + dx + 1j * dy
        return at


def brown_distortion(plane: Array, k: Array) -> Array:
    """Radial and tangential distortion k1, k2, p1, p2, k3 (Brown 1971, as OpenCV writes it)."""
    x, y = plane[..., 0], plane[..., 1]
    r2 = x**2 + y**2
    radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
    return np.stack([x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x**2),
                     y * radial + k[2] * (r2 + 2 * y**2) + 2 * k[3] * x * y], -1)  # fmt: skip


def kannala_brandt_distortion(plane: Array, k: Array) -> Array:
    """Theta (1 + k1 theta^2 + ... + k4 theta^8) (Kannala and Brandt 2006, as OpenCV writes it)."""
    r = np.maximum(np.hypot(plane[..., 0], plane[..., 1]), 1e-12)
    theta = np.arctan(r)
    t2 = theta**2
    bent = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))))
    return plane * (bent / r)[..., None]


def pool_corners(pool: tuple[float, float, float], height: float) -> Array:
    """The four marks (4, 3), m: (0,0), (L,0), (L,W), (0,W)."""
    L, W, _ = pool
    return np.array([[0, 0, height], [L, 0, height], [L, W, height], [0, W, height]])


def draw_camera(rng: np.random.Generator, pool: tuple[float, float, float]) -> Camera:
    """A camera over the middle of the pool, tilted by some degrees, that sees all of it."""
    L, W, _ = pool
    round_lens = bool(rng.random() < 0.5)
    size = [(1920, 1080), (2704, 1520), (2560, 1440)][rng.integers(3)]
    place = rng.uniform([L / 2 - 0.25, W / 2 - 0.25, 2.0], [L / 2 + 0.25, W / 2 + 0.25, 3.0])
    # Down and mirrored: image x along the pool, image y against its width.
    down = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))
    tilt = Rotation.from_rotvec(rng.normal(0, np.deg2rad([2.5, 2.5, 2.0])))
    k = (
        rng.uniform([-0.06, -0.01, -0.004, -0.002], [0.04, 0.01, 0.004, 0.002])
        if round_lens
        else rng.uniform([-0.12, -0.01, -6e-4, -6e-4, -3e-3], [-0.02, 0.03, 6e-4, 6e-4, 3e-3])
    )
    matrix = np.array([[1, 0, size[0] / 2 + rng.normal(0, 8)],
                       [0, 1, size[1] / 2 + rng.normal(0, 8)], [0, 0, 1.0]])  # fmt: skip
    one = Camera(round_lens, size, matrix, k, (tilt * down).as_rotvec(), place)
    spread = one.project(pool_corners(pool, 0.0)) - matrix[:2, 2]
    room = np.array([size - matrix[:2, 2], matrix[:2, 2]]) - 15
    share = np.minimum(room[0] / np.max(spread, 0), room[1] / -np.min(spread, 0))
    focal = 0.97 * share.min()
    return replace(one, matrix=_with_focal_length(matrix, focal, rng.uniform(0.998, 1.002)))


def _with_focal_length(matrix: Array, focal: float, ratio: float) -> Array:
    out = matrix.copy()
    out[0, 0], out[1, 1] = focal, focal * ratio
    return out


def with_fitted_pose(
    camera: Camera, pool: tuple[float, float, float], height: float, px: Array
) -> Camera:
    """The camera with the pose that fits the images px (4, 2) of the pool's marks best."""
    marks = pool_corners(pool, height)

    def miss(pose: Array) -> Array:
        return (replace(camera, turn=pose[:3], place=pose[3:]).project(marks) - px).ravel()

    pose = least_squares(miss, np.concatenate([camera.turn, camera.place]), x_scale=0.1).x
    return replace(camera, turn=pose[:3], place=pose[3:])
