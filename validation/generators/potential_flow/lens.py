"""The camera above the water: lens, pose, and the ray bent at the surface.

Pool frame: z up from the still surface, m. Pixels: u to the right, v down.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Camera:
    """Lens, size of the picture (px), pose, refractive index and depth of the keypoints (m)."""

    fisheye: bool
    size: tuple[int, int]
    focal: float
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    pose: np.ndarray
    """(6,) rotation vector pool to camera, and place in the pool frame, m."""
    index: float
    depth: float

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) from the pool's axes to the camera's."""
        return Rotation.from_rotvec(self.pose[:3]).as_matrix()

    def bend(self, angle):
        """Fisheye: angle as drawn, t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8)."""
        k1, k2, k3, k4 = self.distortion
        a = angle**2
        return angle * (1 + a * (k1 + a * (k2 + a * (k3 + a * k4))))

    def distort(self, xy):
        """Normalised pinhole coordinates, (..., 2), after radial and tangential distortion."""
        if self.fisheye:
            r = np.linalg.norm(xy, axis=-1, keepdims=True) + 1e-15
            return xy * self.bend(np.arctan(r)) / r
        k1, k2, p1, p2, k3 = self.distortion
        x, y = xy[..., 0], xy[..., 1]
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.stack([x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                         y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y], -1)  # fmt: skip

    def undistort(self, xy):
        """Inverse of `distort`, by Newton's rule with a numerical Jacobian."""
        out, h = np.array(xy, dtype=float), 1e-6
        across, down = h * np.eye(2)
        if self.fisheye:
            r = np.linalg.norm(out, axis=-1, keepdims=True) + 1e-15
            out = out * np.tan(np.minimum(r, 1.4)) / r
        for _ in range(8):
            miss = self.distort(out) - xy
            dx = (self.distort(out + across) - self.distort(out - across)) / (2 * h)
            dy = (self.distort(out + down) - self.distort(out - down)) / (2 * h)
            det = dx[..., 0] * dy[..., 1] - dx[..., 1] * dy[..., 0]
            out = out - np.stack([miss[..., 0] * dy[..., 1] - miss[..., 1] * dy[..., 0],
                                  dx[..., 0] * miss[..., 1] - dx[..., 1] * miss[..., 0]],
                                 -1) / det[..., None]  # fmt: skip
        return out

    def project(self, points):
        """Pixels (..., 2) of points in air (..., 3)."""
        at = (np.asarray(points) - self.pose[3:]) @ self.rotation.T
        return self.focal * self.distort(at[..., :2] / at[..., 2:]) + np.array(self.centre)

    def see(self, place, depth=None):
        """Pixels of points (complex, m) at `depth` below the surface."""
        d = np.broadcast_to(self.depth if depth is None else depth, np.shape(place))
        foot, height = self.pose[3] + 1j * self.pose[4], self.pose[5]
        out = np.asarray(place) - foot
        far = np.abs(out) + 1e-12
        crossing = foot + out / far * surface_crossing_distance(far, d, height, self.index)
        return self.project(np.stack([crossing.real, crossing.imag, 0 * far], -1))

    def back(self, pixels):
        """Points (complex, m) at the camera's depth that are seen at `pixels`."""
        xy = self.undistort((pixels - np.array(self.centre)) / self.focal)
        ray = np.concatenate([xy, np.ones((*xy.shape[:-1], 1))], -1) @ self.rotation
        run = -self.pose[5] / ray[..., 2]
        flat = ray[..., 0] + 1j * ray[..., 1]
        sine = np.abs(flat) / np.linalg.norm(ray, axis=-1) / self.index
        below = self.depth * sine / np.sqrt(1 - sine**2)
        return self.pose[3] + 1j * self.pose[4] + flat * run + below * flat / (np.abs(flat) + 1e-12)


def surface_crossing_distance(far, depth, height, index):
    """Distance from the camera's foot at which the ray to a point crosses the surface, m.

    Snell: s / sqrt(s^2 + H^2) = n (D - s) / sqrt((D - s)^2 + d^2); Newton's rule from the straight
    line, five steps.
    """
    s = far * height / (height + depth / index)
    for _ in range(5):
        a, b = np.hypot(s, height), np.hypot(far - s, depth) + 1e-15
        miss = s / a - index * (far - s) / b
        s = s - miss / (height**2 / a**3 + index * depth**2 / b**3 + 1e-15)
        s = np.clip(s, 0, far)
    return s


def draw_camera(rng: np.random.Generator, pool, depth: float) -> Camera:
    """A camera over the middle of the pool that sees all of it, tilted by a few degrees."""
    L, W, _ = pool
    fisheye = bool(rng.random() < 0.5)
    size = (1920, 1080) if rng.random() < 0.4 else (2704, 1520)
    height = rng.uniform(0.62, 0.9) * L
    place = (L / 2 + rng.uniform(-0.1, 0.1), W / 2 + rng.uniform(-0.1, 0.1), height)
    tilt = np.deg2rad(rng.uniform(-3, 3, 2))
    turn = Rotation.from_euler("xyz", [np.pi + tilt[0], tilt[1], np.deg2rad(rng.uniform(-4, 4))])
    if fisheye:
        distortion = tuple(rng.uniform(-s, s) for s in (0.04, 0.012, 0.003, 0.001))
    else:
        distortion = (rng.uniform(-0.06, 0.01), rng.uniform(-0.01, 0.012),
                      *rng.uniform(-6e-4, 6e-4, 2), 0.0)  # fmt: skip
    centre = tuple(np.round(np.array(size) / 2 + rng.uniform(-15, 15, 2), 2))
    camera = Camera(fisheye, size, 1000.0, centre, tuple(np.round(distortion, 5)),
                    np.array([*turn.as_rotvec(), *place]), 1.333, depth)  # fmt: skip
    spread = np.abs(camera.project(pool_corners(pool)) - centre) / (np.array(size) / 2)
    return replace(camera, focal=round(1000.0 * 0.95 / float(spread.max()), 2))


def pool_corners(pool, height: float = 0.0) -> np.ndarray:
    """(4, 3) corners of the pool at `height` above the surface, as in study.yaml."""
    L, W, _ = pool
    return np.array([[0, 0, height], [L, 0, height], [L, W, height], [0, W, height]], dtype=float)


def with_fitted_pose(camera: Camera, pool, pixels) -> Camera:
    """The camera with the pose that fits the corners of `pool` to `pixels` best."""

    def miss(pose):
        return (replace(camera, pose=pose).project(pool_corners(pool)) - pixels).ravel()

    return replace(camera, pose=least_squares(miss, camera.pose, x_scale=[0.1] * 3 + [1.0] * 3).x)
