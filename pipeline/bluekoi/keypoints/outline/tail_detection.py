"""The tail, a thin chain behind the caudal base, traced from there to its tip."""

from __future__ import annotations

import math

import numpy as np

from ...data import Float
from ...numba_settings import njit
from .edges import MIN_CONTRAST_GREY_LEVELS, LumaAndBackground, interpolate_bilinear

RAY_HALF_RANGE_RAD = 1.1
RAY_COUNT = 31
ARC_HALF_ANGLE_RAD = 0.5
MAX_TAIL_LENGTH_RATIO, RADIUS_STEP_PX = 1.5, 0.5
COVERAGE_PLATEAU_RANGE_OVER_LENGTH = (0.45, 0.75)
MIN_PLATEAU_COVERAGE = 0.8
IMAGE_BORDER_PX = 18.0
"""Farther than this from the picture's border nothing about a place on the line lies outside: half
an arc, and as much again as the line may have bent.
"""


@njit(cache=True, error_model="numpy")
def trace_tail(
    pictures: LumaAndBackground, base: Float, back_rad: float, length_px: float, skin: float
) -> tuple[Float, float, float, tuple[float, float, float]]:
    """Tip (2,) [px], its direction from the picture's u axis [rad], support, and three signs.

    Signs of how well the tip is known: scatter of the traced line [px]; paleness of the tail
    towards its end (0 solid, 1 none), as it moved during the exposure; its width there [px].

    base: (2,) px of the caudal base; back_rad: direction backwards along the core, in the picture.
    Going out along circles about the base, the tail's bearing is the coverage's centre near the
    last bearing; the tip lies where the traced line has the tail's length. Support: share of the
    line that is covered, all of it and towards its end, less what is covered beyond the tip.
    """
    height, width = pictures[0].shape
    tip = np.full(2, math.nan)
    reach = length_px + 4.0
    if not (reach < base[0] < width - 2 - reach and reach < base[1] < height - 2 - reach):
        return tip, math.nan, 0.0, (math.nan, math.nan, math.nan)
    bearing = _most_covered_ray(pictures, base, back_rad, 0.45 * length_px, skin)
    u, v = base[0], base[1]
    bend, travelled = 0.0, 0.0
    covered, beyond, steps, past, ending, last = 0.0, 0.0, 0, 0, 0.0, 0
    scatter, pale, breadth = 0.0, 0.0, 0.0
    radius = 3.0
    heading = bearing
    border = min(base[0], base[1], width - 2 - base[0], height - 2 - base[1])
    while radius < min(1.25 * length_px, border):
        found, cover, breadth_px = _coverage_on_arc(pictures, base, (bearing + bend, radius), skin)
        if travelled < length_px:
            covered += 1.0 if cover > 0.5 else 0.0
            steps += 1
            if travelled > 0.6 * length_px:
                ending += 1.0 if cover > 0.35 else 0.0
                last += 1
                pale, breadth = pale + 1.0 - cover, breadth + breadth_px
            if cover > 0.3:
                scatter += ((found - bearing - bend) * radius) ** 2
                bend = 0.7 * (found - bearing)
                bearing = found
            nu = base[0] + radius * math.cos(bearing)
            nv = base[1] + radius * math.sin(bearing)
            stride = math.hypot(nu - u, nv - v)
            heading = math.atan2(nv - v, nu - u)
            if travelled + stride >= length_px:
                share = (length_px - travelled) / stride
                tip[0], tip[1] = u + share * (nu - u), v + share * (nv - v)
            travelled += stride
            u, v = nu, nv
        elif radius > length_px * 1.1:
            beyond += 1.0 if cover > 0.5 else 0.0
            past += 1
        radius += 1.0
    support = min(covered / max(steps, 1), ending / max(last, 1)) - beyond / max(past, 1)
    return (
        tip,
        heading,
        support,
        (math.sqrt(scatter / max(steps, 1)), pale / max(last, 1), breadth / max(last, 1)),
    )


@njit(cache=True, error_model="numpy")
def tail_length(
    pictures: LumaAndBackground, base: Float, back_rad: float, length_px: float, skin: float
) -> float:
    """Length [px] of the tail from its base to where it is seen to end; NaN where it is not.

    It ends where the coverage, averaged over three samples, falls to half of its mean over the part
    `COVERAGE_PLATEAU_RANGE_OVER_LENGTH` of the stated length. Its length is that of a cubic through
    the traced points, because their scatter would lengthen a polyline. Arguments as of
    `trace_tail`.
    """
    count = int((MAX_TAIL_LENGTH_RATIO * length_px - 3.0) / RADIUS_STEP_PX)
    height, width = pictures[0].shape
    reach = 0.45 * length_px + 2.0
    within = reach < base[0] < width - 2 - reach and reach < base[1] < height - 2 - reach
    if count < 10 or not within:
        return math.nan
    cover, bearings = np.zeros(count), np.zeros(count)
    bearing = _most_covered_ray(pictures, base, back_rad, 0.45 * length_px, skin)
    bend, known = 0.0, 0
    for k in range(count):
        radius = 3.0 + k * RADIUS_STEP_PX
        u, v = base[0] + radius * math.cos(bearing), base[1] + radius * math.sin(bearing)
        if not _is_clear_of_border(pictures, u, v):
            break
        found, cover[k], _ = _coverage_on_arc(pictures, base, (bearing + bend, radius), skin)
        if cover[k] > 0.3:
            bend = 0.7 * (found - bearing)
            bearing = found
        bearings[k] = bearing
        known = k + 1
    first = int((COVERAGE_PLATEAU_RANGE_OVER_LENGTH[0] * length_px - 3.0) / RADIUS_STEP_PX)
    last = int((COVERAGE_PLATEAU_RANGE_OVER_LENGTH[1] * length_px - 3.0) / RADIUS_STEP_PX)
    if known <= last or last - first < 3:
        return math.nan
    usual = np.median(cover[first:last])
    if usual < MIN_PLATEAU_COVERAGE:
        return math.nan
    before = usual
    for k in range(last, known - 1):
        now = (cover[k - 1] + cover[k] + cover[k + 1]) / 3.0
        if now < 0.5 * usual:
            share = (before - 0.5 * usual) / max(before - now, 1e-9)
            radius = 3.0 + (k - 1 + min(max(share, 0.0), 1.0)) * RADIUS_STEP_PX
            return _curve_length_px(bearings[:k], radius)
        before = now
    return math.nan


@njit(cache=True, error_model="numpy")
def _is_clear_of_border(pictures: LumaAndBackground, u: float, v: float) -> bool:
    height, width = pictures[0].shape
    return (
        IMAGE_BORDER_PX < u < width - IMAGE_BORDER_PX
        and IMAGE_BORDER_PX < v < height - IMAGE_BORDER_PX
    )


@njit(cache=True, error_model="numpy")
def _curve_length_px(bearings: Float, radius: float) -> float:
    """Length [px] of a line of which the bearings are known along its distance from the base, out
    to a radius: a cubic about its own direction.
    """
    middle = np.median(bearings)
    normal, side = 1e-9 * np.eye(3), np.zeros(3)
    for k in range(len(bearings)):
        r = 3.0 + k * RADIUS_STEP_PX
        x, y = r * math.cos(bearings[k] - middle), r * math.sin(bearings[k] - middle)
        powers = (x, x * x, x * x * x)
        for i in range(3):
            side[i] += y * powers[i]
            for j in range(3):
                normal[i, j] += powers[i] * powers[j]
    a, b, c = np.linalg.solve(normal, side)
    end = radius * math.cos(bearings[-1] - middle)
    total, steps = 0.0, 40
    for k in range(steps):
        x = end * (k + 0.5) / steps
        slope = a + 2 * b * x + 3 * c * x * x
        total += math.sqrt(1.0 + slope * slope)
    return total * end / steps


@njit(cache=True, error_model="numpy")
def _most_covered_ray(
    pictures: LumaAndBackground, base: Float, back_rad: float, radius: float, skin: float
) -> float:
    """Bearing of the tail's first half: of all rays from the base the one covered most."""
    best, most = back_rad, -1.0
    for k in range(RAY_COUNT):
        angle = back_rad + RAY_HALF_RANGE_RAD * (2.0 * k / (RAY_COUNT - 1) - 1.0)
        total = 0.0
        r = 3.0
        while r < radius:
            u, v = base[0] + r * math.cos(angle), base[1] + r * math.sin(angle)
            total += _pixel_coverage(pictures, u, v, skin)
            r += 1.0
        total -= 0.02 * abs(angle - back_rad) * radius
        if total > most:
            best, most = angle, total
    return best


@njit(cache=True, error_model="numpy")
def _coverage_on_arc(
    pictures: LumaAndBackground, base: Float, polar: tuple[float, float], skin: float
) -> tuple[float, float, float]:
    """Centre of the coverage on an arc about the base, its largest value, its width [px]."""
    angle, radius = polar
    half = min(ARC_HALF_ANGLE_RAD, 5.0 / radius)
    weight, moment, most = 0.0, 0.0, 0.0
    count = 2 * math.ceil(2 * half * radius) + 1
    for k in range(count):
        a = angle + half * (2.0 * k / (count - 1) - 1.0)
        cover = _pixel_coverage(
            pictures, base[0] + radius * math.cos(a), base[1] + radius * math.sin(a), skin
        )
        most = max(most, cover)
        if cover > 0.25:
            weight += cover
            moment += cover * a
    width = weight * 2.0 * half * radius / (count - 1)
    return (moment / weight if weight > 0 else angle), most, width


@njit(cache=True, error_model="numpy")
def _pixel_coverage(pictures: LumaAndBackground, u: float, v: float, skin: float) -> float:
    """Coverage at a pixel: 0 floor, 1 skin."""
    depth = interpolate_bilinear(pictures[1], u, v) - skin
    if abs(depth) < MIN_CONTRAST_GREY_LEVELS:
        return 0.0
    return min(max((depth + skin - interpolate_bilinear(pictures[0], u, v)) / depth, 0.0), 1.0)
