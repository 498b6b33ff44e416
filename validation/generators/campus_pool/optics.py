"""Camera above a pool: two lens models, refraction at the still surface, pose from corners.

The camera looks down.  Camera axes: x to the right, y down in the image, z away from the camera.
World points are (x, y, z) with z up and zero at the surface; depths are positive downwards.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


@dataclass
class Camera:
    """Lens and pose.  `turn` matrix maps world to camera axes."""

    model: str
    size: tuple[int, int]
    focal: np.ndarray
    centre: np.ndarray
    distortion: list[float]
    position: np.ndarray
    turn: np.ndarray
    corner_radius: float = 1.0

    def copy(self) -> Camera:
        """A copy whose arrays may be changed."""
        return Camera(
            self.model,
            self.size,
            self.focal.copy(),
            self.centre.copy(),
            list(self.distortion),
            self.position.copy(),
            self.turn.copy(),
            self.corner_radius,
        )


@dataclass
class Stated:
    """What the study states: lens, pool lengths, index, depth, and the clicked corners."""

    camera: Camera
    length: float
    width: float
    index: float
    depth: float
    mark_height: float
    inset: float = 0.0
    corners: np.ndarray = field(default_factory=lambda: np.zeros((4, 2)))


def _radial(cam: Camera, r: Any) -> Any:
    """Distorted radius for an undistorted radius (pinhole) or angle (fisheye)."""
    d, s = cam.distortion, r * r
    if cam.model == "fisheye":
        return r * (1 + s * (d[0] + s * (d[1] + s * (d[2] + s * d[3]))))
    return r * (1 + s * (d[0] + s * (d[1] + s * d[4])))


def _radial_slope(cam: Camera, r: Any) -> Any:
    """Derivative of the distorted radius."""
    d, s = cam.distortion, r * r
    if cam.model == "fisheye":
        return 1 + s * (3 * d[0] + s * (5 * d[1] + s * (7 * d[2] + s * 9 * d[3])))
    return 1 + s * (3 * d[0] + s * (5 * d[1] + s * 7 * d[4]))


def _tangential(cam: Camera, x: Any, y: Any) -> tuple[Any, Any]:
    """Decentring terms of the pinhole model."""
    if cam.model == "fisheye":
        return 0.0, 0.0
    p1, p2, s = cam.distortion[2], cam.distortion[3], x * x + y * y
    return 2 * p1 * x * y + p2 * (s + 2 * x * x), p1 * (s + 2 * y * y) + 2 * p2 * x * y


def to_pixels(cam: Camera, ray: np.ndarray) -> np.ndarray:
    """Pixels of points or rays in camera axes, shape (..., 3) to (..., 2)."""
    x, y = ray[..., 0] / ray[..., 2], ray[..., 1] / ray[..., 2]
    r = np.hypot(x, y) + 1e-15
    base = np.arctan(r) if cam.model == "fisheye" else r
    gain = _radial(cam, base) / r
    tx, ty = _tangential(cam, x, y)
    return np.stack([x * gain + tx, y * gain + ty], -1) * cam.focal + cam.centre


def to_rays(cam: Camera, pixels: np.ndarray) -> np.ndarray:
    """Rays in camera axes (third component one) of pixels."""
    xd = (pixels - cam.centre) / cam.focal
    x, y = xd[..., 0], xd[..., 1]
    for _ in range(1 if cam.model == "fisheye" else 5):
        tx, ty = _tangential(cam, x, y)
        gx, gy = xd[..., 0] - tx, xd[..., 1] - ty
        rd = np.hypot(gx, gy) + 1e-15
        r = rd.copy()
        for _step in range(8):
            r = r - (_radial(cam, r) - rd) / np.maximum(_radial_slope(cam, r), 0.1)
            r = np.clip(r, 0, 4.0)
        out = np.tan(np.clip(r, 0, 1.5)) if cam.model == "fisheye" else r
        x, y = gx * out / rd, gy * out / rd
    return np.stack([x, y, np.ones_like(x)], -1)


def see(
    cam: Camera, xy: np.ndarray, depth: Any, index: float, *, turn: Any = None, move: Any = None
) -> np.ndarray:
    """Pixels of points below the surface; the ray bends at the surface.

    `turn` is a small rotation vector in camera axes, `move` a displacement of the camera.
    """
    position = cam.position if move is None else cam.position + move
    cx, cy, height = position[..., 0], position[..., 1], position[..., 2]
    offset = xy - (cx + 1j * cy)
    far = np.abs(offset) + 1e-12
    s = far * height / (height + depth / index)
    for _ in range(6):
        a, b = np.sqrt(s**2 + height**2), np.sqrt((far - s) ** 2 + depth**2 + 1e-18)
        value = s / a - index * (far - s) / b
        slope = height**2 / a**3 + index * (depth**2 + 1e-18) / b**3
        s = np.clip(s - value / slope, 0, far)
    surface = offset * s / far
    ray = np.stack([surface.real, surface.imag, 0 * s - height], -1) @ cam.turn.T
    if turn is not None:
        turn = np.broadcast_to(turn, ray.shape)
        size = np.linalg.norm(turn, axis=-1, keepdims=True) + 1e-15
        axis = turn / size
        along = np.sum(axis * ray, -1, keepdims=True)
        ray = (
            ray * np.cos(size)
            + np.cross(axis, ray) * np.sin(size)
            + axis * along * (1 - np.cos(size))
        )
    return to_pixels(cam, ray)


def see_mark(cam: Camera, points: np.ndarray) -> np.ndarray:
    """Pixels of points above the water."""
    return to_pixels(cam, (points - cam.position) @ cam.turn.T)


def place(cam: Camera, pixels: np.ndarray, depth: float, index: float) -> np.ndarray:
    """Pool positions (complex) of pixels of points at a depth."""
    ray = to_rays(cam, pixels) @ cam.turn
    down = -ray[..., 2]
    flat = (ray[..., 0] + 1j * ray[..., 1]) / down
    slope = np.abs(flat)
    sine = slope / np.sqrt(1 + slope**2) / index
    below = sine / np.sqrt(1 - sine**2) * depth
    unit = flat / (slope + 1e-15)
    return (cam.position[0] + 1j * cam.position[1]) + flat * cam.position[2] + unit * below


def corner_points(length: float, width: float, height: float, inset: float = 0.0) -> np.ndarray:
    """Corner marks (0,0), (L,0), (L,W), (0,W), moved inwards by an inset."""
    a, b = inset, inset
    return np.array(
        [
            [a, b, height],
            [length - a, b, height],
            [length - a, width - b, height],
            [a, width - b, height],
        ]
    )


def with_pose(stated: Stated) -> Camera:
    """Camera of the statement with the pose that fits the clicked corners best."""
    cam = stated.camera.copy()
    marks = corner_points(stated.length, stated.width, stated.mark_height)
    base = Rotation.from_matrix(cam.turn)
    scale = float(np.hypot(stated.length, stated.width))
    start = cam.position.copy()

    def misfit(v: np.ndarray) -> np.ndarray:
        """Corner residuals in pixels."""
        cam.turn = (Rotation.from_rotvec(v[:3]) * base).as_matrix()
        cam.position = start + v[3:] * scale
        return (see_mark(cam, marks) - stated.corners).ravel()

    found = least_squares(misfit, np.zeros(6), xtol=1e-13, ftol=1e-13, gtol=1e-13)
    misfit(found.x)
    return cam


def hang(rng: np.random.Generator, length: float, width: float) -> Camera:
    """A camera that sees the whole pool from above."""
    sizes = [(1920, 1080), (1280, 720), (2704, 1520), (1440, 1080), (3840, 2160), (2048, 1536)]
    model = "fisheye" if rng.uniform() < 0.4 else "pinhole"
    size = sizes[int(rng.integers(len(sizes)))]
    height = length * (rng.uniform(0.4, 0.75) if model == "fisheye" else rng.uniform(0.75, 1.5))
    position = np.array([length * rng.uniform(0.44, 0.56), width * rng.uniform(0.42, 0.58), height])
    tilt = rng.normal(0, np.radians(2.0), 2)
    roll = np.radians(rng.normal(0, 2.0)) + (np.pi if rng.uniform() < 0.3 else 0.0)
    look = Rotation.from_euler("x", np.pi)
    turn = (Rotation.from_euler("zxy", [roll, tilt[0], tilt[1]]) * look).as_matrix()
    if model == "pinhole":
        d = [
            rng.uniform(-0.16, 0.05),
            rng.uniform(-0.02, 0.04),
            *rng.normal(0, 6e-4, 2),
            rng.uniform(-0.004, 0.004),
        ]
    else:
        d = [rng.uniform(-0.04, 0.06), *rng.uniform(-0.012, 0.012, 2), rng.uniform(-0.002, 0.002)]
    cam = Camera(model, size, np.ones(2), np.zeros(2), [float(v) for v in d], position, turn)
    corners = see_mark(cam, corner_points(length, width, 0.0))
    reach = np.max(np.abs(corners), axis=0) * 1.03
    focal = float(min(size[0] / 2 / reach[0], size[1] / 2 / reach[1]) * rng.uniform(0.93, 0.99))
    cam.corner_radius = float(np.max(np.hypot(*corners.T)))
    cam.focal = focal * np.array([1.0, rng.uniform(0.997, 1.003)])
    cam.centre = np.array(size) / 2 + rng.normal(0, 0.004, 2) * size[0]
    return cam
