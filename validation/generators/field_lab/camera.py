"""The laboratory's camera: pinhole or fisheye lens, tilted pose, flat water surface (Snell).

Formulas: Brown-Conrady and Kannala-Brandt as in OpenCV's documentation; refraction at a flat
interface by Newton's method on the crossing point (Glaeser & Schroecker 2000).
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


class Camera(NamedTuple):
    """Lens and pose: ``dist`` is OpenCV's order, ``rotvec`` pool to camera, ``C`` centre (m)."""

    model: str
    fx: float
    fy: float
    cx: float
    cy: float
    dist: tuple[float, ...]
    rotvec: np.ndarray
    C: np.ndarray


DOWNWARD_ROTATION = np.diag([1.0, -1.0, -1.0])


def distort(cam: Camera, a: np.ndarray) -> np.ndarray:
    """Distorted normalised coordinates (n, 2) of undistorted ``a`` (n, 2)."""
    r2 = (a**2).sum(1)
    if cam.model == "fisheye":
        r = np.sqrt(r2) + 1e-15
        th = np.arctan(r)
        k = cam.dist
        th_d = th * (1 + k[0] * th**2 + k[1] * th**4 + k[2] * th**6 + k[3] * th**8)
        return a * (th_d / r)[:, None]
    k1, k2, p1, p2, k3 = cam.dist
    x, y = a.T
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return a * radial[:, None] + np.stack([dx, dy], 1)


def undistort(cam: Camera, d: np.ndarray) -> np.ndarray:
    """Undistorted normalised coordinates (n, 2): Newton with a numerical Jacobian."""
    a, eps = d.copy(), 1e-6
    for _ in range(12):
        f0 = distort(cam, a)
        jx = (distort(cam, a + np.array([eps, 0])) - f0) / eps
        jy = (distort(cam, a + np.array([0, eps])) - f0) / eps
        res = d - f0
        det = jx[:, 0] * jy[:, 1] - jy[:, 0] * jx[:, 1]
        step_x = (res[:, 0] * jy[:, 1] - jy[:, 0] * res[:, 1]) / det
        step_y = (jx[:, 0] * res[:, 1] - res[:, 0] * jx[:, 1]) / det
        a = a + np.stack([step_x, step_y], 1)
    return a


def project_air(cam: Camera, xyz: np.ndarray) -> np.ndarray:
    """Pixels (n, 2) of points in air ``xyz`` (n, 3), pool frame."""
    local = (xyz - cam.C) @ Rotation.from_rotvec(cam.rotvec).as_matrix().T
    d = distort(cam, local[:, :2] / local[:, 2:])
    return d * [cam.fx, cam.fy] + [cam.cx, cam.cy]


def surface_crossing(cam: Camera, xy: np.ndarray, depth: np.ndarray, index: float) -> np.ndarray:
    """Points (n, 2) where the ray from ``xy`` (n, 2) at ``depth`` (n,) leaves the water."""
    H = cam.C[2]
    offset = xy - cam.C[:2]
    R = np.sqrt((offset**2).sum(1)) + 1e-12
    rho = R * H / (H + depth / index)
    for _ in range(8):
        a, b = np.hypot(rho, H), np.hypot(R - rho, depth) + 1e-15
        g = rho / a - index * (R - rho) / b
        slope = H**2 / a**3 + index * depth**2 / b**3
        rho = rho - g / np.maximum(slope, 1e-9)
        rho = np.clip(rho, 0, R)
    return cam.C[:2] + offset * (rho / R)[:, None]


def project_water(cam: Camera, xy: np.ndarray, depth: np.ndarray, index: float) -> np.ndarray:
    """Pixels (n, 2) of submerged points."""
    s = surface_crossing(cam, xy, depth, index)
    return project_air(cam, np.column_stack([s, np.zeros(len(s))]))


def pixels_to_pool(cam: Camera, px: np.ndarray, depth: float, index: float) -> np.ndarray:
    """Positions (n, 2) at ``depth`` below the surface seen at pixels ``px`` (n, 2)."""
    a = undistort(cam, (px - [cam.cx, cam.cy]) / [cam.fx, cam.fy])
    ray = np.column_stack([a, np.ones(len(a))]) @ Rotation.from_rotvec(cam.rotvec).as_matrix()
    surface = cam.C[:2] - ray[:, :2] * (cam.C[2] / ray[:, 2])[:, None]
    flat = np.hypot(ray[:, 0], ray[:, 1]) + 1e-15
    sin_a = flat / np.linalg.norm(ray, axis=1)
    sin_w = sin_a / index
    run = depth * sin_w / np.sqrt(1 - sin_w**2)
    return surface + ray[:, :2] / flat[:, None] * run[:, None]


def with_fitted_pose(cam: Camera, corners: np.ndarray, corners_px: np.ndarray) -> Camera:
    """``cam`` with the pose that images ``corners`` (4, 3) at ``corners_px`` (4, 2), least
    squares.
    """

    def residual(q: np.ndarray) -> np.ndarray:
        return (project_air(cam._replace(rotvec=q[:3], C=q[3:]), corners) - corners_px).ravel()

    q = least_squares(residual, np.concatenate([cam.rotvec, cam.C]), x_scale="jac").x
    return cam._replace(rotvec=q[:3], C=q[3:])


def pool_corners(length: float, width: float, height: float) -> np.ndarray:
    """Corner marks (4, 3) at ``height`` (m) above the water."""
    xy = [(0, 0), (length, 0), (length, width), (0, width)]
    return np.array([(x, y, height) for x, y in xy], float)


def draw_camera(rng: np.random.Generator, distorted: bool) -> Camera:
    """Camera above the pool: tilt of some degrees, turned by 0 or 180 degrees and a little."""
    H = rng.uniform(2.1, 2.6)
    f = 1000.0 * H / 1.78 * rng.uniform(0.94, 1.0)
    turn = rng.choice([0.0, np.pi]) + rng.normal(0, 0.03)
    R = (
        Rotation.from_euler("xy", rng.normal(0, 0.03, 2)).as_matrix()
        @ Rotation.from_euler("z", turn).as_matrix()
        @ DOWNWARD_ROTATION
    )
    C = np.array([*rng.normal((1.3, 0.8), 0.05), H])
    model = "fisheye" if distorted and rng.random() < 0.4 else "pinhole"
    dist: tuple[float, ...] = (0.0,) * 5
    if model == "fisheye":
        f *= 1.04
        dist = (rng.normal(0.02, 0.02), rng.normal(-0.01, 0.01), rng.normal(0, 0.003), 0.0)
    elif distorted:
        k1 = rng.uniform(-0.22, 0.05)
        dist = (k1, -0.25 * k1, *rng.normal(0, 5e-4, 2), 0.0)
    center = rng.normal(0, 8, 2)
    return Camera(
        model, f, f * rng.normal(1, 0.001), 960 + center[0], 540 + center[1],
        tuple(float(v) for v in dist), Rotation.from_matrix(R).as_rotvec(), C,
    )  # fmt: skip
