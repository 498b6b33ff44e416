"""The rigid pose that fits the outline's edges: hinge, core heading, head angle."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...data import Float
from ...numba_settings import njit
from .edges import LumaAndBackground, edge_offset
from .plane import horner

OutlineArrays = tuple[Float, Float, npt.NDArray[np.int64], Float]
MAX_EXTRA_ITERATIONS = 5
LIGHT_GRADIENT_NEIGHBOURS = 2
POSE_CONVERGENCE_PX = 0.1
POSE_CONVERGENCE_RAD = 0.001


@njit(cache=True, error_model="numpy")
def plane_to_pixel_jacobian(coefficients: Float, scale: Float, px: float, py: float) -> Float:
    """d(u, v)/d(x, y), px per body length, at a point in the plane."""
    e = 0.03
    out = np.empty((2, 2))
    u1, v1 = horner(coefficients, scale, px + e, py)
    u0, v0 = horner(coefficients, scale, px - e, py)
    out[0, 0], out[1, 0] = (u1 - u0) / (2 * e), (v1 - v0) / (2 * e)
    u1, v1 = horner(coefficients, scale, px, py + e)
    u0, v0 = horner(coefficients, scale, px, py - e)
    out[0, 1], out[1, 1] = (u1 - u0) / (2 * e), (v1 - v0) / (2 * e)
    return out


@njit(cache=True, error_model="numpy")
def measure_edge_offsets(
    pictures: LumaAndBackground,
    maps: tuple[Float, Float],
    shape: OutlineArrays,
    pose: Float,
    reach: int,
) -> tuple[Float, Float]:
    """Edge offsets (n,) [px, NaN where not seen] and their derivatives (n, 5).

    By the pose, and by a width that is common to the whole outline: light and blur move both
    sides alike, and where the body tapers that would pass for a shift along it.

    pictures: luma, background. maps: coefficients, scale of the plane. shape: points (n, 2) and
    outward normals (n, 2) in the axes of their part [body lengths], part (0 head, 1 core),
    skin (n,).
    pose: hinge x, y [body lengths], core heading, head angle [rad].
    """
    points, normals, part, skin = shape
    n = len(points)
    offset, gradient, derivative = np.empty(n), np.empty(n), np.empty(n)
    slope = np.zeros((n, 5))
    local = plane_to_pixel_jacobian(maps[0], maps[1], pose[0], pose[1])
    det = local[0, 0] * local[1, 1] - local[0, 1] * local[1, 0]
    lines = np.empty((2, 2 * reach + 1))
    for i in range(n):
        angle = pose[2] - pose[3] if part[i] == 0 else pose[2]
        c, s = math.cos(angle), math.sin(angle)
        x = c * points[i, 0] - s * points[i, 1]
        y = s * points[i, 0] + c * points[i, 1]
        mx = c * normals[i, 0] - s * normals[i, 1]
        my = s * normals[i, 0] + c * normals[i, 1]
        u = (local[1, 1] * mx - local[1, 0] * my) / det
        v = (-local[0, 1] * mx + local[0, 0] * my) / det
        size = math.hypot(u, v)
        u, v = u / size, v / size
        at_u, at_v = horner(maps[0], maps[1], pose[0] + x, pose[1] + y)
        place = (at_u, at_v, u, v)
        offset[i], gradient[i], derivative[i] = edge_offset(pictures, place, skin[i], lines)
        gx = u * local[0, 0] + v * local[1, 0]
        gy = u * local[0, 1] + v * local[1, 1]
        slope[i, 0], slope[i, 1], slope[i, 4] = gx, gy, 1.0
        slope[i, 2] = -gx * y + gy * x
        if part[i] == 0:
            slope[i, 3] = -slope[i, 2]
    _correct_for_light_gradient(offset, (gradient, derivative), points, part)
    return offset, slope


@njit(cache=True, error_model="numpy")
def _correct_for_light_gradient(
    offset: Float, light: tuple[Float, Float], points: Float, part: npt.NDArray[np.int64]
) -> None:
    """Correct offsets (n,) in place for the light's gradient outwards.

    light: gradients (n,) [1/px] and derivatives (n,) of the offsets by them. Light changes slowly
    along the outline, so that a point gets the mean gradient of its neighbours on the same side of
    the same part, weighted by a triangle.
    """
    gradient, derivative = light
    reach = LIGHT_GRADIENT_NEIGHBOURS
    for i in range(len(offset)):
        total, weight = 0.0, 0.0
        for j in range(max(0, i - reach), min(len(offset), i + reach + 1)):
            beside = part[j] == part[i] and points[j, 1] * points[i, 1] >= 0.0
            if beside and math.isfinite(offset[j]):
                share = 1.0 + reach - abs(i - j)
                total += share * gradient[j]
                weight += share
        if weight > 0.0:
            offset[i] += derivative[i] * total / weight


@njit(cache=True, error_model="numpy")
def robust_std_px(offset: Float) -> float:
    """Robust width of the offsets about 0, px, at least 0.1."""
    seen = np.abs(offset[np.isfinite(offset)])
    if len(seen) == 0:
        return 1.0
    return max(0.1, 1.4826 * np.median(seen))


@njit(cache=True, error_model="numpy")
def fit_outline_pose(
    pictures: LumaAndBackground,
    maps: tuple[Float, Float],
    shape: OutlineArrays,
    pose: Float,
    how: tuple[npt.NDArray[np.int64], Float, float],
) -> tuple[Float, Float, Float, Float]:
    """Pose (4,) that fits the outline; offsets left (n,); weights (n,); slopes (n, 5).

    how: reaches [px]; prior; width [px]. Gauss-Newton with Tukey's weights, a step for each of
    `reaches` and a few more if it has not settled. The prior is the information (5,) that ties
    each step, so that a hidden part does not run away; offsets are outliers from 4.7 widths on,
    at least the given width.
    """
    reaches, prior, width = how
    here = pose.copy()
    offset, slope = measure_edge_offsets(pictures, maps, shape, here, reaches[0])
    weight = np.zeros(len(offset))
    wider = 0.0
    last = len(reaches) - 1
    for turn in range(len(reaches) + MAX_EXTRA_ITERATIONS):
        limit = 4.7 * max(width, robust_std_px(offset - wider))
        normal = np.diag(prior)
        side = np.zeros(5)
        for i in range(len(offset)):
            weight[i] = 0.0
            if math.isfinite(offset[i]) and abs(offset[i] - wider) < limit:
                share = (offset[i] - wider) / limit
                weight[i] = (1 - share * share) ** 2
                for a in range(5):
                    side[a] += weight[i] * slope[i, a] * offset[i]
                    for b in range(5):
                        normal[a, b] += weight[i] * slope[i, a] * slope[i, b]
        change = np.linalg.solve(normal, side)
        here = here + change[:4]
        wider = change[4]
        offset, slope = measure_edge_offsets(pictures, maps, shape, here, reaches[min(turn, last)])
        scale = math.hypot(slope[0, 0], slope[0, 1])
        moved = scale * math.hypot(change[0], change[1])
        if turn >= last and moved < POSE_CONVERGENCE_PX and abs(change[2]) < POSE_CONVERGENCE_RAD:
            break
    return here, offset - wider, weight, slope


@njit(cache=True, error_model="numpy")
def information_and_edge_support(
    found: tuple[Float, Float, Float],
    part: npt.NDArray[np.int64],
    heading: float,
    limits: tuple[float, float],
) -> tuple[Float, Float]:
    """Information (5, 5) in body axes; support of head, core, all; nearness.

    found: offsets, weights, slopes as `fit_outline_pose` returns them. limits: offsets below the
    first [px] support the template; nearness falls to 0 at the second [px].
    """
    offset, weight, slope = found
    c, s = math.cos(heading), math.sin(heading)
    information = np.zeros((5, 5))
    row = np.empty(5)
    for i in range(len(offset)):
        if weight[i] > 0 and math.isfinite(offset[i]):
            row[0] = c * slope[i, 0] + s * slope[i, 1]
            row[1] = c * slope[i, 1] - s * slope[i, 0]
            for a in range(2, 5):
                row[a] = slope[i, a]
            for a in range(5):
                for b in range(5):
                    information[a, b] += weight[i] * row[a] * row[b]
    return information, _edge_support_and_nearness(offset, part, limits)


@njit(cache=True, error_model="numpy")
def _edge_support_and_nearness(
    offset: Float, part: npt.NDArray[np.int64], limits: tuple[float, float]
) -> Float:
    """Share of head, core and all points that support the template, and nearness (4,)."""
    share = np.zeros(4)
    count = np.zeros(3)
    for i in range(len(offset)):
        k = part[i]
        count[k] += 1
        count[2] += 1
        if math.isfinite(offset[i]):
            size = abs(offset[i])
            share[3] += max(0.0, 1.0 - size / limits[1])
            if size < limits[0]:
                share[k] += 1
                share[2] += 1
    for k in range(3):
        share[k] /= max(count[k], 1.0)
    share[3] /= max(count[2], 1.0)
    return share
