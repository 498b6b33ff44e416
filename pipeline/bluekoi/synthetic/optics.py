"""Projection from the pool to pixels: refraction, camera pose, lens.

Frames: `pool` (x along the length, y along the width, z up from the still surface, m),
`cam` (x right, y down, z along the optical axis, m), `px` (u right, v down, pixels).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

Matrix3 = tuple[tuple[float, float, float], ...]

SURFACE_CROSSING_TOLERANCE = 1e-12
"""Newton steps end with one of this relative size: the next one would be a rounding error."""


@dataclass(frozen=True)
class Camera:
    """A camera above the water.

    `rotation` takes pool to cam axes; `centre_m` is the camera's place in the pool frame.
    `lens` is `pinhole` with `(k1, k2, p1, p2, k3)` or `fisheye` with `(k1, k2, k3, k4)`.
    """

    size_px: tuple[int, int]
    focal_px: tuple[float, float]
    middle_px: tuple[float, float]
    lens: str
    distortion: tuple[float, ...]
    rotation: Matrix3
    centre_m: tuple[float, float, float]
    index_air: float = 1.0
    index_water: float = 1.333


def _matrix_to_nested_tuples(matrix: np.ndarray) -> Matrix3:
    one, two, three = ((float(row[0]), float(row[1]), float(row[2])) for row in matrix)
    return one, two, three


def downward_rotation(roll_deg: float, pitch_deg: float, turn_deg: float) -> Matrix3:
    """Rotation pool to cam of a camera that looks straight down but for three small angles.

    With all zero the image's u runs along the pool's x and v against its y.
    """
    a, b, c = (math.radians(angle) for angle in (roll_deg, pitch_deg, turn_deg))
    about_x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_y = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    about_z = np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
    rows = about_x @ about_y @ about_z @ np.diag([1.0, -1.0, -1.0])
    return _matrix_to_nested_tuples(rows)


def gopro_like_camera(lens: str = "pinhole") -> Camera:
    """A 1080p camera over the pool, about a HERO11's Linear (pinhole) or Wide (fisheye) lens."""
    linear = lens == "pinhole"
    return Camera(
        size_px=(1920, 1080),
        focal_px=(915.6, 917.1) if linear else (898.2, 898.6),
        middle_px=(958.3, 543.9) if linear else (959.7, 531.6),
        lens=lens,
        distortion=(-0.031, 0.012, 0.0004, -0.0003, -0.002)
        if linear
        else (0.0342, 0.0677, -0.0741, 0.0299),
        rotation=downward_rotation(0.8, -0.7, 0.6),
        centre_m=(1.31, 0.79, 1.72 if linear else 1.55),
    )


def resized_camera(camera: Camera, size_px: tuple[int, int]) -> Camera:
    """The same camera recording with another number of pixels over the same field."""
    sx, sy = size_px[0] / camera.size_px[0], size_px[1] / camera.size_px[1]
    fx, fy = camera.focal_px
    cx, cy = camera.middle_px
    middle = ((cx + 0.5) * sx - 0.5, (cy + 0.5) * sy - 0.5)
    return replace(camera, size_px=size_px, focal_px=(fx * sx, fy * sy), middle_px=middle)


def displaced_camera(
    camera: Camera, shift_m: tuple[float, float, float], angles_deg: tuple[float, float, float]
) -> Camera:
    """The camera after a displacement: moved by `shift_m` in the pool, turned about its axes."""
    displaced = np.array(downward_rotation(*angles_deg)) @ np.diag([1.0, -1.0, -1.0])
    rows = displaced @ np.array(camera.rotation)
    rotation = _matrix_to_nested_tuples(rows)
    x, y, z = (a + b for a, b in zip(camera.centre_m, shift_m, strict=True))
    return replace(camera, rotation=rotation, centre_m=(x, y, z))


def _horizontal_distance_to_surface_crossing(
    height: np.ndarray, depth: np.ndarray, across: np.ndarray, n: float
) -> np.ndarray:
    """Distance (m) from the foot of the camera to where the ray meets the surface.

    Root of `x/sqrt(x^2 + h^2) = n (r - x)/sqrt((r - x)^2 + d^2)` on [0, r].  The left side less
    the right one grows with x: Newton steps, halving the bracket where one would leave it.
    """
    deep = np.maximum(depth, 1e-12)
    low, high = np.zeros_like(across), across.copy()
    x = across * height / (height + deep / n)
    for _ in range(12):
        rest = across - x
        air, wet = np.hypot(x, height), np.hypot(rest, deep)
        excess = x / air - n * rest / wet
        low, high = np.where(excess < 0, x, low), np.where(excess < 0, high, x)
        step = x - excess / (height**2 / air**3 + n * deep**2 / wet**3)
        before, x = x, np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
        if (np.abs(x - before) <= SURFACE_CROSSING_TOLERANCE * across).all():
            break
    return np.where(depth <= 0, across, x)


def surface_point(camera: Camera, points_pool: np.ndarray) -> np.ndarray:
    """Where the light of each point `(n, 3)` leaves the water, `(n, 3)`; points above stay."""
    centre = np.array(camera.centre_m)
    offset = points_pool[:, :2] - centre[:2]
    across = np.hypot(offset[:, 0], offset[:, 1])
    depth = np.maximum(-points_pool[:, 2], 0.0)
    height = np.full_like(across, centre[2])
    reach = _horizontal_distance_to_surface_crossing(
        height, depth, across, camera.index_water / camera.index_air
    )
    share = np.divide(reach, across, out=np.ones_like(across), where=across > 0)
    surface = np.column_stack([centre[:2] + offset * share[:, None], np.zeros_like(across)])
    return np.where((points_pool[:, 2] < 0)[:, None], surface, points_pool)


def _pinhole_pixels(camera: Camera, xy: np.ndarray) -> np.ndarray:
    k1, k2, p1, p2, k3 = camera.distortion
    x, y = xy[:, 0], xy[:, 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    along = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    down = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.column_stack([along, down])


def _fisheye_pixels(camera: Camera, xy: np.ndarray) -> np.ndarray:
    k1, k2, k3, k4 = camera.distortion
    r = np.hypot(xy[:, 0], xy[:, 1])
    angle = np.arctan(r)
    a2 = angle * angle
    bent = angle * (1 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))
    return xy * np.divide(bent, r, out=np.ones_like(r), where=r > 1e-12)[:, None]


def _apply_lens(camera: Camera, xy: np.ndarray) -> np.ndarray:
    return _fisheye_pixels(camera, xy) if camera.lens == "fisheye" else _pinhole_pixels(camera, xy)


def pool_points_to_pixels(camera: Camera, points_pool: np.ndarray) -> np.ndarray:
    """Pixels `(n, 2)` of pool points `(n, 3)`; those under water are seen through the surface."""
    points = np.asarray(points_pool, dtype=float).reshape(-1, 3)
    seen = surface_point(camera, points) - np.array(camera.centre_m)
    cam = seen @ np.array(camera.rotation).T
    bent = _apply_lens(camera, cam[:, :2] / cam[:, 2:])
    return bent * np.array(camera.focal_px) + np.array(camera.middle_px)


def pixels_to_pool_points(camera: Camera, pixels: np.ndarray, depth_m: float) -> np.ndarray:
    """Pool points `(n, 2)` at a depth (m, downwards) that appear at pixels `(n, 2)`.

    The lens is inverted by Newton steps with a numeric slope, the refraction is closed form.
    """
    bent = (np.asarray(pixels, float) - np.array(camera.middle_px)) / np.array(camera.focal_px)
    xy, step = bent.copy(), 1e-6
    right, down = np.array([step, 0.0]), np.array([0.0, step])
    for _ in range(12):
        off = _apply_lens(camera, xy) - bent
        dx = (_apply_lens(camera, xy + right) - _apply_lens(camera, xy - right)) / (2 * step)
        dy = (_apply_lens(camera, xy + down) - _apply_lens(camera, xy - down)) / (2 * step)
        slope = dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]
        xy[:, 0] -= (off[:, 0] * dy[:, 1] - off[:, 1] * dy[:, 0]) / slope
        xy[:, 1] -= (off[:, 1] * dx[:, 0] - off[:, 0] * dx[:, 1]) / slope
    ray = np.column_stack([xy, np.ones(len(xy))]) @ np.array(camera.rotation)
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    hit = np.array(camera.centre_m[:2]) - ray[:, :2] * (camera.centre_m[2] / ray[:, 2:])
    wet = ray[:, :2] * camera.index_air / camera.index_water
    sink = np.sqrt(1 - np.sum(wet**2, axis=1, keepdims=True))
    return hit + wet / sink * depth_m


def pool_corners(camera: Camera, pool_m: tuple[float, float], height_m: float = 0.0) -> np.ndarray:
    """Pixels `(4, 2)` of the pool's corners (0,0), (L,0), (L,W), (0,W) at a height (m)."""
    length, width = pool_m
    ground = [(0, 0), (length, 0), (length, width), (0, width)]
    return pool_points_to_pixels(
        camera, np.array([(x, y, height_m) for x, y in ground], dtype=float)
    )
