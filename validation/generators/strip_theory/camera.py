"""Camera above the pool: lens, pose, refraction at the water surface, and the way back.

Camera axes: x right, y down, z along the optical axis (OpenCV). Points are `(n, 3)` in the pool
frame,
metres, z up from the still surface; images are `(n, 2)` raw pixels.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]
DOWNWARD_ROTATION = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Camera:
    """Lens, pose and water index; `turn` rotates the downward view (rotation vector, rad)."""

    model: str
    size: tuple[int, int]
    focal: tuple[float, float]
    center: tuple[float, float]
    distortion: tuple[float, ...]
    position: tuple[float, float, float]
    turn: tuple[float, float, float]
    index: float = 1.333

    @property
    def rotation(self) -> Floats:
        """World to camera, (3, 3)."""
        return Rotation.from_rotvec(self.turn).as_matrix() @ DOWNWARD_ROTATION


def distort(xy: Floats, model: str, k: tuple[float, ...]) -> Floats:
    """Image-plane coordinates `(n, 2)` after the lens (OpenCV's pinhole or fisheye polynomial)."""
    x, y = xy[:, 0], xy[:, 1]
    if model == "fisheye":
        r = np.hypot(x, y) + 1e-12
        a = np.arctan(r)
        a_d = a * (1 + k[0] * a**2 + k[1] * a**4 + k[2] * a**6 + k[3] * a**8)
        return xy * (a_d / r)[:, None]
    r2 = x * x + y * y
    radial = 1 + k[0] * r2 + k[1] * r2**2 + k[4] * r2**3
    u = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)
    v = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y
    return np.stack([u, v], axis=1)


def undistort(uv: Floats, model: str, k: tuple[float, ...]) -> Floats:
    """Invert `distort` by Newton steps with a numerical Jacobian."""
    xy = uv.copy()
    if model == "fisheye":
        a_d = np.hypot(uv[:, 0], uv[:, 1])
        xy = uv * (np.tan(np.minimum(a_d, 1.4)) / (a_d + 1e-12))[:, None]
    step = 1e-6
    for _ in range(12):
        base = distort(xy, model, k)
        J = np.stack([(distort(xy + d, model, k) - base) / step for d in step * np.eye(2)], axis=2)
        xy = xy - np.linalg.solve(J, (base - uv)[:, :, None])[:, :, 0]
    return xy


def surface_radius(R: Floats, H: float, depth: Floats, n: float) -> Floats:
    """Radius (m) at which the ray to a point at radius R and `depth` crosses the surface.

    Fermat: H-to-water path sqrt(H^2 + r^2) + n sqrt(d^2 + (R - r)^2) is stationary; Newton from the
    paraxial solution. Its second derivative is positive, so the root is unique.
    """
    r = R * H / (H + depth / n)
    for _ in range(8):
        a, b = np.hypot(H, r), np.hypot(depth, R - r) + 1e-12
        slope = r / a - n * (R - r) / b
        r = r - slope / (H * H / a**3 + n * depth**2 / b**3 + 1e-12)
    return np.clip(r, 0.0, R)


def project(camera: Camera, points: Floats) -> Floats:
    """Raw pixels `(n, 2)` of points `(n, 3)`; those below z = 0 are seen through the surface."""
    C = np.array(camera.position)
    offset = points[:, :2] - C[:2]
    R = np.hypot(offset[:, 0], offset[:, 1]) + 1e-12
    depth = np.maximum(-points[:, 2], 0.0)
    wet = depth > 1e-9
    r = np.where(wet, surface_radius(R, C[2], np.maximum(depth, 1e-9), camera.index), R)
    seen = np.column_stack([C[:2] + offset * (r / R)[:, None], np.where(wet, 0.0, points[:, 2])])
    p = (seen - C) @ camera.rotation.T
    uv = distort(p[:, :2] / p[:, 2:], camera.model, camera.distortion)
    return uv * camera.focal + camera.center


def pixels_to_pool(camera: Camera, pixels: Floats, depth: float) -> Floats:
    """Positions `(n, 2)` (m) at `depth` below the surface whose images are `pixels`."""
    C = np.array(camera.position)
    xy = undistort((pixels - camera.center) / camera.focal, camera.model, camera.distortion)
    ray = np.column_stack([xy, np.ones(len(xy))]) @ camera.rotation
    t = -C[2] / ray[:, 2]
    hit = C[:2] + ray[:, :2] * t[:, None]
    across = np.hypot(ray[:, 0], ray[:, 1])
    sine = across / np.linalg.norm(ray, axis=1) / camera.index
    tangent = sine / np.sqrt(1.0 - sine**2)
    return hit + ray[:, :2] / (across + 1e-12)[:, None] * (depth * tangent)[:, None]


def with_fitted_pose(camera: Camera, corners: Floats, pixels: Floats) -> Camera:
    """Return `camera` posed so that corners `(4, 3)` are imaged at `pixels` (least squares)."""

    def residual(q: Floats) -> Floats:
        moved = replace(camera, position=tuple(q[:3]), turn=tuple(q[3:]))
        return (project(moved, corners) - pixels).ravel()

    fit = least_squares(
        residual, [*camera.position, *camera.turn], x_scale=[1, 1, 1, 0.1, 0.1, 0.1]
    )
    return replace(camera, position=tuple(fit.x[:3]), turn=tuple(fit.x[3:]))


def homography(source: Floats, target: Floats) -> Floats:
    """Homography (3, 3) that takes four points `(4, 2)` to four others."""
    rows = []
    for (x, y), (u, v) in zip(source, target, strict=True):
        rows.append([x, y, 1, 0, 0, 0, -u * x, -u * y])
        rows.append([0, 0, 0, x, y, 1, -v * x, -v * y])
    h = np.linalg.solve(np.array(rows), target.ravel())
    return np.append(h, 1.0).reshape(3, 3)


def draw_camera(
    rng: np.random.Generator,
    pool: tuple[float, float],
    plain: bool,
    index: float,
    *,
    low: bool = False,
) -> Camera:
    """Draw a camera that sees the whole pool; `plain`: no distortion, `low`: wide fisheye."""
    length, width = pool
    model = "fisheye" if low or (not plain and rng.random() < 0.5) else "pinhole"
    size = (1920, 1080) if rng.random() < 0.7 else (2704, 1520)
    height = rng.uniform(1.7, 2.2) if model == "fisheye" else rng.uniform(2.2, 3.0)
    height -= 0.5 if low else 0.0
    position = (length / 2 + rng.normal(0, 0.05), width / 2 + rng.normal(0, 0.04), height)
    turn = (*rng.normal(0, 0.025, 2), rng.normal(0, 0.02) + np.pi * (rng.random() < 0.2))
    k: tuple[float, ...] = (0.0,) * 5
    if model == "fisheye":
        k = tuple(rng.normal(0, s) + m for s, m in ((0.03, -0.03), (0.01, 0), (3e-3, 0), (1e-3, 0)))
    elif not plain:
        tangential = rng.normal(0, 5e-4, 2)
        k = (rng.uniform(-0.22, -0.05), rng.uniform(0.0, 0.05), *tangential, rng.normal(0, 0.005))
    half = 0.5 * size[0] - 40
    edge = (0.5 * length + 0.12) / height
    reach = np.arctan(edge) if model == "fisheye" else edge
    f = min(half / reach, (0.5 * size[1] - 20) / ((0.5 * width + 0.1) / height)) * 0.97
    center = (size[0] / 2 + rng.normal(0, 8), size[1] / 2 + rng.normal(0, 8))
    focal = (f, f * (1 + rng.normal(0, 1e-3)))
    return Camera(model, size, focal, center, k, position, tuple(map(float, turn)), index)
