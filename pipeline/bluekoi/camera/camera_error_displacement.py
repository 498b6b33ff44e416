"""Displacement of places by a lens error and by uncorrected refraction, in a few parameters.

They depend on where the camera stands, and on how much of a lens error the pose compensates, since
it was fitted to the corners under the same wrong lens.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import least_squares

from ..data import Float
from ..errors import InputError
from ..study import Camera, Pool, StudySettings
from .pool_projection import PoolCamera, map_to_pool, pool_to_pixels
from .rigid_distances import GEOMETRY_ERROR_FUNCTIONS, CameraGeometry, pixels_of_places
from .study_camera import camera_from_corners, pool_camera_from_parts

WATER_REFRACTIVE_INDEX = 1.333
"""Refractive index of water."""
REFRACTIVE_INDEX_TOLERANCE = 0.02
"""A stated index nearer to that of water is right, and the depth may be wrong."""
MAX_KEYPOINT_HEIGHT_IN_BODY_LENGTHS = 0.05
"""Height above the surface at which a keypoint of a floating body may be."""
POOL_GRID_POINTS, RADIUS_TABLE_POINTS = (12, 8), 50
"""Points of the pool (along, across) at which a displacement is taken, and radii of its table."""
GRID_MARGIN_TO_WALL_M = 0.08
"""Distance of the outermost points from the walls."""
MIN_LENS_ERROR_DISPLACEMENT_M = 1e-9
"""Displacements below this, m, count as zero."""
POOL_SIDE_DIFFERENCE_STEP = 0.01
"""Relative error of a side of the pool by which its displacements are differenced."""

PoolSideErrorCoefficients = tuple[float, float, float, float]
"""Numbers (g_x, g_y, b_x, b_y) of `CameraErrorFieldCoefficients`."""


@dataclass(frozen=True)
class CameraErrorFieldCoefficients:
    """Numbers that the forms of a camera's errors over a pool depend on.

    below_m: (x, y) under the camera. bend_1_m2: what is drawn in by refraction goes as
    rho (1 + bend rho^2), rho from there. A wrong lens moves p by k ((r^2 - q Q)(p - c) + a), with
    r = |p - c|, q near 1: lens_m is c, lens_rest_m2 is Q (where the pose makes up for it),
    lens_pull_m3 is a. inward_shift_range: the smallest and the largest share by which refraction
    can draw in what is seen; (0, 0) where the height of the camera is not known. A pool stated too
    long by a share s moves p by s ((g_x X, g_y Y) + (X, Y)(b . (X, Y))), X and Y from the middle of
    the pool: length_error_field is (g_x, g_y, b_x, b_y), and width_error_field that of a pool
    stated too wide.
    """

    below_m: tuple[float, float]
    bend_1_m2: float
    lens_m: tuple[float, float]
    lens_rest_m2: float
    lens_pull_m3: tuple[float, float]
    inward_shift_range: tuple[float, float] = (0.0, 0.0)
    length_error_field: PoolSideErrorCoefficients = (1.0, 0.0, 0.0, 0.0)
    width_error_field: PoolSideErrorCoefficients = (0.0, 1.0, 0.0, 0.0)


def camera_error_field_coefficients(setup: StudySettings) -> CameraErrorFieldCoefficients:
    """The numbers of a study's camera; those of one over the middle where no lens is stated or the
    corners fit no pose (an error of the stages that need one).
    """
    index, depth_m = setup.water.refractive_index, setup.robot.keypoint_depth_m
    highest_m = MAX_KEYPOINT_HEIGHT_IN_BODY_LENGTHS * setup.robot.body_length_m
    return _error_field_coefficients_of_camera(setup.camera, setup.pool, index, depth_m, highest_m)


@lru_cache(maxsize=8)
def _error_field_coefficients_of_camera(
    given: Camera, pool: Pool, index: float, depth_m: float, highest_m: float
) -> CameraErrorFieldCoefficients:
    middle = (0.5 * pool.length_m, 0.5 * pool.width_m)
    above = CameraErrorFieldCoefficients(
        middle, 0.0, middle, float(np.dot(middle, middle)), (0.0, 0.0)
    )
    try:
        camera = pool_camera_from_parts(given, pool, index, depth_m)
    except InputError:
        return above
    if camera.lens is None:
        return above
    x, y, height = map(float, camera.center_m)
    return CameraErrorFieldCoefficients(
        (x, y),
        _refraction_cubic_coefficient_1_m2(index, height, float(np.hypot(*middle))),
        *_fit_lens_error_coefficients(camera, depth_m, middle),
        inward_shift_range=(
            _radial_shift_by_depth_error(index, height, depth_m, -highest_m),
            _radial_shift_by_depth_error(index, height, depth_m, pool.depth_m),
        ),
        length_error_field=_fit_pool_side_error_coefficients(camera, depth_m, side=0),
        width_error_field=_fit_pool_side_error_coefficients(camera, depth_m, side=1),
    )


def _radial_shift_by_depth_error(
    index: float, height_m: float, assumed_m: float, depth_m: float
) -> float:
    """Share by which a keypoint at a depth is seen too near the point below the camera, if it is
    assumed at another one; depths above the surface are negative.

    Paraxial: a ray at the tangent t in air reaches rho = t (H + d / n) at the depth d.
    """
    apparent = depth_m / WATER_REFRACTIVE_INDEX if depth_m > 0 else depth_m
    return 1.0 - (height_m + assumed_m / index) / (height_m + apparent)


def _refraction_cubic_coefficient_1_m2(index: float, height_m: float, reach_m: float) -> float:
    """The b of rho (1 + b rho^2), 1/m2, that comes nearest to refraction out to rho = `reach_m`.

    Snell's law, t = rho / H the tangent of the angle in air: in water it is
    t / sqrt(n^2 + (n^2 - 1) t^2). Corrected with another index (1: not at all), that of the index
    less that of water is seen too far out; corrected for a wrong depth, that of water alone. Places
    are weighed by their area.
    """
    rho = np.linspace(0.0, reach_m, RADIUS_TABLE_POINTS)[1:]
    t = rho / height_m

    def in_water(n: float) -> Float:
        return np.asarray(t / np.sqrt(n**2 + (n**2 - 1) * t**2))

    other = abs(index - WATER_REFRACTIVE_INDEX) > REFRACTIVE_INDEX_TOLERANCE
    drawn_in = (
        in_water(index) - in_water(WATER_REFRACTIVE_INDEX)
        if other
        else in_water(WATER_REFRACTIVE_INDEX)
    )
    design = np.column_stack([rho, rho**3]) * np.sqrt(rho)[:, None]
    first, third = np.linalg.lstsq(design, drawn_in * np.sqrt(rho), rcond=None)[0]
    return float(third / first)


def _fit_lens_error_coefficients(
    camera: PoolCamera, depth_m: float, middle: tuple[float, float]
) -> tuple[tuple[float, float], float, tuple[float, float]]:
    """c, Q and a of `CameraErrorFieldCoefficients` from the displacements that a small error of the
    lens makes; those of a lens over the middle where they come out outside the pool.
    """
    places = _pool_grid(camera)
    moved = _lens_error_displacements(camera, places, depth_m)
    seen = np.isfinite(moved).all(axis=1)
    rest = float(np.dot(middle, middle))
    size = float(np.abs(moved[seen]).max(initial=0.0))
    if size < MIN_LENS_ERROR_DISPLACEMENT_M:
        return middle, rest, (0.0, 0.0)
    target = np.ravel(moved[seen] / size)

    def shape(numbers: Float) -> Float:
        cx, cy, made_up, ax, ay = numbers
        return np.ravel(_lens_error_field(places[seen], (cx, cy), made_up, (ax, ay)))

    start = np.array([*middle, rest, 0.0, 0.0])
    first = shape(start)
    k = float(first @ target) / float(first @ first)
    found = least_squares(lambda n: n[0] * shape(n[1:]) - target, np.array([k, *start])).x
    cx, cy, made_up, ax, ay = map(float, found[1:])
    if not np.hypot(cx - middle[0], cy - middle[1]) < np.hypot(*middle):
        return middle, rest, (0.0, 0.0)
    return (cx, cy), made_up, (ax, ay)


def _lens_error_field(
    places: Float, center: tuple[float, float], rest: float, pull: tuple[float, float]
) -> Float:
    """(r^2 - Q)(p - c) + a of `CameraErrorFieldCoefficients` at places p (n, 2)."""
    off = places - np.array(center)
    shape: Float = (np.sum(off**2, axis=1) - rest)[:, None] * off + np.array(pull)
    return shape


def _fit_pool_side_error_coefficients(
    camera: PoolCamera, depth_m: float, side: int
) -> PoolSideErrorCoefficients:
    """Displacements by an error of one side of the pool: 0 its length, 1 its width.

    The lens is known, and the pose is fitted to the corners of the wrong rectangle: what is seen
    keeps its proportions, the camera seems to stand higher or lower, and is tilted where it does
    not stand over the middle.
    """
    assert camera.lens is not None
    places = _pool_grid(camera)
    pixels = pixels_of_places(CameraGeometry(camera, depth_m), places)
    factors = np.ones(3)
    factors[side] += POOL_SIDE_DIFFERENCE_STEP
    wrong = camera_from_corners(camera.lens, pool_to_pixels(camera, camera.corners_m),
                                camera.corners_m * factors, camera.refractive_index)  # fmt: skip
    moved = (map_to_pool(wrong, pixels, depth_m) - places) / POOL_SIDE_DIFFERENCE_STEP
    X, Y = (places - 0.5 * np.array(camera.pool_size_m)).T
    one, none = np.ones(len(X)), np.zeros(len(X))
    design = np.vstack([np.column_stack([one, none, X, none, X * X, X * Y]),
                        np.column_stack([none, one, none, Y, X * Y, Y * Y])])  # fmt: skip
    found = np.linalg.lstsq(design, moved.T.ravel(), rcond=None)[0]
    g_x, g_y, b_x, b_y = map(float, found[2:])
    return g_x, g_y, b_x, b_y


def _pool_grid(camera: PoolCamera) -> Float:
    """Places (n, 2) all over a pool."""
    counts = zip(camera.pool_size_m, POOL_GRID_POINTS, strict=True)
    x, y = np.meshgrid(
        *(np.linspace(GRID_MARGIN_TO_WALL_M, side - GRID_MARGIN_TO_WALL_M, n) for side, n in counts)
    )
    return np.column_stack([x.ravel(), y.ravel()])


def _lens_error_displacements(camera: PoolCamera, places: Float, depth_m: float) -> Float:
    """Displacement (n, 2) of places (n, 2) by a unit error of the lens's first coefficient."""
    geometry, (change, step) = CameraGeometry(camera, depth_m), GEOMETRY_ERROR_FUNCTIONS["k1"]
    pixels = pixels_of_places(geometry, places)
    high, low = (map_to_pool(change(geometry, s).camera, pixels, depth_m) for s in (step, -step))
    return (high - low) / (2 * step)
