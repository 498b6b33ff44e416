"""Where the outline really is: coverage across the edge, and the rigid pose that fits it.

Across an edge the picture is I = a skin + (1 - a) floor; the floor is known from the background
and follows the moving light by a gain measured just outside. The edge lies where the covered
length, the sum of a, ends; that is exact for any symmetric blur.
"""

from __future__ import annotations

import math

import numba
import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]
Pictures = tuple[Image, Image]
Shape = tuple[Float, Float, npt.NDArray[np.int64], Float]

LEAST_CONTRAST = 12.0
HALF_PX = 3


@numba.njit(cache=True, error_model="numpy", inline="always")
def pick(image: Image, u: float, v: float) -> float:
    """Bilinear value of a picture; the caller makes sure that it lies inside."""
    x, y = int(u), int(v)
    fx, fy = u - x, v - y
    top = image[y, x] * (1 - fx) + image[y, x + 1] * fx
    low = image[y + 1, x] * (1 - fx) + image[y + 1, x + 1] * fx
    return top * (1 - fy) + low * fy


@numba.njit(cache=True, error_model="numpy")
def edge_offset(
    pictures: Pictures, place: tuple[float, float, float, float], skin: float, lines: Float
) -> float:
    """Offset of the edge along the outward normal [px]; NaN where there is none.

    place: u, v and the normal's u, v [px]. skin: grey level inside. lines: (2, 2 reach + 1) to
    work in; their length tells how far the edge is looked for.
    """
    luma, floor = pictures
    seen, clear = lines[0], lines[1]
    count = len(seen)
    reach = count // 2
    height, width = luma.shape
    far = reach + 1.0
    if not (far < place[0] < width - 2 - far and far < place[1] < height - 2 - far):
        return math.nan
    for k in range(count):
        u = place[0] + (k - reach) * place[2]
        v = place[1] + (k - reach) * place[3]
        seen[k] = pick(luma, u, v)
        clear[k] = pick(floor, u, v)
    at = _step(seen, clear, skin)
    gain = _gain(seen, clear, at)
    total = 0.0
    inner, outer, ends = 0.0, 0.0, 0
    for k in range(at - HALF_PX, at + HALF_PX + 1):
        if k < 0 or k >= count:
            continue
        depth = gain * clear[k] - skin
        if abs(depth) < LEAST_CONTRAST:
            return math.nan
        cover = min(max((gain * clear[k] - seen[k]) / depth, -0.3), 1.3)
        total += cover - (1.0 if k < at else 0.0)
        ends += 1
        if k < at - 1:
            inner += 1.0 - cover
        if k > at:
            outer += cover
    if ends < 2 * HALF_PX or inner > 1.0 or outer > 1.0:
        return math.nan
    return at + total - 0.5 - reach


@numba.njit(cache=True, error_model="numpy")
def _step(seen: Float, clear: Float, skin: float) -> int:
    """First sample outside, of the step from covered to clear that fits best."""
    count = len(seen)
    cost = 0.0
    for k in range(count):
        depth = clear[k] - skin
        if abs(depth) < LEAST_CONTRAST:
            depth = LEAST_CONTRAST if depth >= 0 else -LEAST_CONTRAST
        cover = min(max((clear[k] - seen[k]) / depth, -0.5), 1.5)
        clear_cost = cover * cover
        seen_cost = (1 - cover) * (1 - cover)
        cost += clear_cost
        if k == 0:
            best, at, run = 0.0, 0, 0.0
        run += seen_cost - clear_cost
        if run < best:
            best, at = run, k + 1
    return at


@numba.njit(cache=True, error_model="numpy")
def _gain(seen: Float, clear: Float, at: int) -> float:
    """Brightness of the floor just outside against the background's."""
    a, b = 0.0, 0.0
    for k in range(at + 2, min(at + 6, len(seen))):
        a += seen[k]
        b += clear[k]
    if b <= 0.0:
        return 1.0
    return min(max(a / b, 0.75), 1.33)


@numba.njit(cache=True, error_model="numpy")
def horner(coefficients: Float, scale: Float, px: float, py: float) -> tuple[float, float]:
    """Pixels of one point in the plane."""
    degree = coefficients.shape[1] - 1
    x = (px - scale[0, 0]) / scale[1, 0]
    y = (py - scale[0, 1]) / scale[1, 1]
    u, v = 0.0, 0.0
    for i in range(degree, -1, -1):
        inner_u, inner_v = 0.0, 0.0
        for j in range(degree - i, -1, -1):
            inner_u = inner_u * y + coefficients[0, i, j]
            inner_v = inner_v * y + coefficients[1, i, j]
        u = u * x + inner_u
        v = v * x + inner_v
    return u, v


@numba.njit(cache=True, error_model="numpy")
def jacobian(coefficients: Float, scale: Float, px: float, py: float) -> Float:
    """d(u, v)/d(x, y), px per m, at a point in the plane."""
    e = 0.01
    out = np.empty((2, 2))
    u1, v1 = horner(coefficients, scale, px + e, py)
    u0, v0 = horner(coefficients, scale, px - e, py)
    out[0, 0], out[1, 0] = (u1 - u0) / (2 * e), (v1 - v0) / (2 * e)
    u1, v1 = horner(coefficients, scale, px, py + e)
    u0, v0 = horner(coefficients, scale, px, py - e)
    out[0, 1], out[1, 1] = (u1 - u0) / (2 * e), (v1 - v0) / (2 * e)
    return out


@numba.njit(cache=True, error_model="numpy")
def measure(
    pictures: Pictures,
    maps: tuple[Float, Float],
    shape: Shape,
    pose: Float,
    reach: int,
) -> tuple[Float, Float]:
    """Edge offsets (n,) [px, NaN where not seen] and their derivatives by the pose (n, 4).

    pictures: luma, background. maps: coefficients, scale of the plane. shape: points (n, 2) and
    outward normals (n, 2) in the axes of their part [m], part (0 head, 1 core), skin (n,).
    pose: hinge x, y [m], core heading, head angle [rad].
    """
    points, normals, part, skin = shape
    n = len(points)
    offset = np.empty(n)
    slope = np.zeros((n, 4))
    local = jacobian(maps[0], maps[1], pose[0], pose[1])
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
        offset[i] = edge_offset(pictures, (at_u, at_v, u, v), skin[i], lines)
        gx = u * local[0, 0] + v * local[1, 0]
        gy = u * local[0, 1] + v * local[1, 1]
        slope[i, 0], slope[i, 1] = gx, gy
        slope[i, 2] = -gx * y + gy * x
        if part[i] == 0:
            slope[i, 3] = -slope[i, 2]
    return offset, slope


@numba.njit(cache=True, error_model="numpy")
def spread_of(offset: Float) -> float:
    """Robust width of the offsets about 0, px, at least 0.1."""
    seen = np.abs(offset[np.isfinite(offset)])
    if len(seen) == 0:
        return 1.0
    return max(0.1, 1.4826 * np.median(seen))


@numba.njit(cache=True, error_model="numpy")
def fit(
    pictures: Pictures,
    maps: tuple[Float, Float],
    shape: Shape,
    pose: Float,
    how: tuple[npt.NDArray[np.int64], Float, float],
) -> tuple[Float, Float, Float, Float]:
    """Pose (4,) that fits the outline; offsets left (n,); weights (n,); slopes (n, 4).

    how: reaches [px]; prior; width [px]. Gauss-Newton with Tukey's weights, a step for each of
    `reaches`. The prior is the information (4,) that ties each step, so that a hidden part does
    not run away; offsets are outliers from 4.7 widths on, at least the given width.
    """
    reaches, prior, width = how
    here = pose.copy()
    offset, slope = measure(pictures, maps, shape, here, reaches[0])
    weight = np.zeros(len(offset))
    for turn in range(len(reaches)):
        limit = 4.7 * max(width, spread_of(offset))
        normal = np.diag(prior)
        side = np.zeros(4)
        for i in range(len(offset)):
            weight[i] = 0.0
            if math.isfinite(offset[i]) and abs(offset[i]) < limit:
                share = offset[i] / limit
                weight[i] = (1 - share * share) ** 2
                for a in range(4):
                    side[a] += weight[i] * slope[i, a] * offset[i]
                    for b in range(4):
                        normal[a, b] += weight[i] * slope[i, a] * slope[i, b]
        here = here + np.linalg.solve(normal, side)
        offset, slope = measure(pictures, maps, shape, here, reaches[turn])
    return here, offset, weight, slope
