"""Where an edge really is: the coverage across it, to a small part of a pixel.

Across an edge the picture is I = a skin + (1 - a) floor; the floor is known from the background,
the skin from the template, and both follow the moving light: by a gain measured just outside, and
another just inside. The edge lies where the covered length, the sum of a, ends; that is exact for
any symmetric blur. Where the gain changes outwards, as beside a shadow, its gradient shifts the
edge: both are returned, for one edge alone shows the gradient too poorly to be corrected by it.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...data import Float
from ...numba_settings import njit

LumaPicture = npt.NDArray[np.uint8]
LumaAndBackground = tuple[LumaPicture, LumaPicture]

MIN_CONTRAST_GREY_LEVELS = 12.0
EDGE_WINDOW_HALF_WIDTH_PX = 3
FLOOR_BRIGHTNESS_RATIO_RANGE = (0.6, 1.33)
"""The light on the floor may fall below three quarters, in a shadow under moving light."""


@njit(cache=True, error_model="numpy", inline="always")
def interpolate_bilinear(image: LumaPicture, u: float, v: float) -> float:
    """Bilinear value of a picture; the caller makes sure that it lies inside."""
    x, y = int(u), int(v)
    fx, fy = u - x, v - y
    top = image[y, x] * (1 - fx) + image[y, x + 1] * fx
    low = image[y + 1, x] * (1 - fx) + image[y + 1, x + 1] * fx
    return top * (1 - fy) + low * fy


@njit(cache=True, error_model="numpy")
def interpolate_where(image: LumaPicture, places: Float, wanted: npt.NDArray[np.bool_]) -> Float:
    """Values (n,) of a picture at places (n, 2) px; NaN where not wanted."""
    values = np.full(len(places), math.nan)
    for i in range(len(places)):
        if wanted[i]:
            values[i] = interpolate_bilinear(image, places[i, 0], places[i, 1])
    return values


@njit(cache=True, error_model="numpy")
def edge_offset(
    pictures: LumaAndBackground, place: tuple[float, float, float, float], skin: float, lines: Float
) -> tuple[float, float, float]:
    """Offset of the edge along the outward normal [px], NaN where there is none, if the floor's
    brightness ratio is constant; its gradient outwards [1/px]; derivative of the offset by it.

    place: u, v and the normal's u, v [px]. skin: grey level inside. lines: (2, 2 reach + 1) to
    work in; their length is the range of the search for the edge.
    """
    luma, floor = pictures
    seen, clear = lines[0], lines[1]
    count = len(seen)
    reach = count // 2
    height, width = luma.shape
    far = reach + 1.0
    if not (far < place[0] < width - 2 - far and far < place[1] < height - 2 - far):
        return math.nan, 0.0, 0.0
    for k in range(count):
        u = place[0] + (k - reach) * place[2]
        v = place[1] + (k - reach) * place[3]
        seen[k] = interpolate_bilinear(luma, u, v)
        clear[k] = interpolate_bilinear(floor, u, v)
    at = _best_step_index(seen, clear, skin)
    covered, gradient, derivative = _covered_length_beyond_step_px(lines, at, skin)
    if abs(covered) > 0.5:
        at += 1 if covered > 0.0 else -1
        covered, gradient, derivative = _covered_length_beyond_step_px(lines, at, skin)
    return at + covered - 0.5 - reach, gradient, derivative


@njit(cache=True, error_model="numpy")
def _covered_length_beyond_step_px(
    lines: Float, at: int, skin: float
) -> tuple[float, float, float]:
    """Covered length [px] beyond a step, NaN where there is no edge; the gradient of the floor's
    brightness ratio outwards [1/px]; derivative of the covered length by it.

    lines: (2, n) samples of picture and background outwards. at: first sample outside the step.
    """
    seen, clear = lines[0], lines[1]
    count = len(seen)
    gain, gradient, centre = _floor_brightness_ratio(seen, clear, at)
    skin *= _body_brightness_ratio(seen, at, skin)
    total, derivative = 0.0, 0.0
    inner, outer, ends = 0.0, 0.0, 0
    for k in range(at - EDGE_WINDOW_HALF_WIDTH_PX, at + EDGE_WINDOW_HALF_WIDTH_PX + 1):
        if k < 0 or k >= count:
            continue
        depth = gain * clear[k] - skin
        if abs(depth) < MIN_CONTRAST_GREY_LEVELS:
            return math.nan, 0.0, 0.0
        cover = min(max((gain * clear[k] - seen[k]) / depth, -0.3), 1.3)
        total += cover - (1.0 if k < at else 0.0)
        derivative += (k - centre) * clear[k] / depth * (1.0 - cover)
        ends += 1
        if k < at - 1:
            inner += 1.0 - cover
        if k > at:
            outer += cover
    if ends < 2 * EDGE_WINDOW_HALF_WIDTH_PX or inner > 1.0 or outer > 1.0:
        return math.nan, 0.0, 0.0
    return total, gradient, derivative


@njit(cache=True, error_model="numpy")
def _best_step_index(seen: Float, clear: Float, skin: float) -> int:
    """First sample outside, of the step from covered to clear that fits best."""
    count = len(seen)
    cost = 0.0
    for k in range(count):
        depth = clear[k] - skin
        if abs(depth) < MIN_CONTRAST_GREY_LEVELS:
            depth = MIN_CONTRAST_GREY_LEVELS if depth >= 0 else -MIN_CONTRAST_GREY_LEVELS
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


@njit(cache=True, error_model="numpy")
def _body_brightness_ratio(seen: Float, at: int, skin: float) -> float:
    """Brightness of the body just inside against what was learned: the light is on it too."""
    total, count = 0.0, 0
    for k in range(max(0, at - EDGE_WINDOW_HALF_WIDTH_PX - 2), at - EDGE_WINDOW_HALF_WIDTH_PX + 1):
        total += seen[k]
        count += 1
    if count < 2 or skin <= 0.0:
        return 1.0
    return min(max(total / (count * skin), 0.75), 1.33)


@njit(cache=True, error_model="numpy")
def _floor_brightness_ratio(seen: Float, clear: Float, at: int) -> tuple[float, float, float]:
    """Brightness ratio of the floor just outside to the background, its gradient outwards [1/px],
    and the place (index of a sample) at which it has this value.
    """
    first, last = at + 2, min(at + 6, len(seen))
    a, b, moment = 0.0, 0.0, 0.0
    for k in range(first, last):
        a += seen[k]
        b += clear[k]
        moment += k * clear[k]
    if b <= 0.0:
        return 1.0, 0.0, 0.0
    ratio, centre = a / b, moment / b
    above, spread = 0.0, 0.0
    for k in range(first, last):
        lever = (k - centre) * clear[k]
        above += lever * (seen[k] - ratio * clear[k])
        spread += lever * lever
    gradient = above / spread if last - first > 2 and spread > 0.0 else 0.0
    least, most = FLOOR_BRIGHTNESS_RATIO_RANGE
    return min(max(ratio, least), most), gradient, centre
