"""Pose of a bending body fitted to a frame: position, heading and smooth bending.

Arc s runs from the nose (0) to the tail tip (1). The heading at s is theta(s) = theta_0 +
sum of b_j B_j(s), with B_j(s) = P_j(2 s - 1) - P_j(2 c - 1), P_j Legendre polynomials and c the
reference station; the midline is p(s) = p_c - length * integral of (cos theta, sin theta) from c
to s. The picture is modelled as background - luma = T(s, n) (background - skin), T the learned
coverage at arc s and distance n from the midline. Fit: Gauss-Newton with Geman and McClure's
weights, the gradient of the picture taken from T.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...data import Float
from ...numba_settings import njit
from ..outline.edges import interpolate_bilinear as inner_bilinear
from ..outline.plane import horner
from ..outline.pose_fit import plane_to_pixel_jacobian

Float32Image = npt.NDArray[np.float32]
PlaneToPixelMap = tuple[Float, Float, Float]
"""Coefficients and scale of the plane's map to pixels; and the cut: factor, left, top."""
BEND_TERMS = 5
REFERENCE_ARC = 0.3
STATIONS_ALONG, STATIONS_ACROSS = 56, 17
ARC_MARGIN = 0.14
MAX_ITERATIONS = 9
CONVERGED_STEP, MAX_MOVE_BL, MAX_TURN_RAD = 0.002, 0.12, 0.4
CONTRAST_GAIN_RANGE = (0.6, 1.5)
MIN_SEEN_SHARE = 0.3
NOSE_STATION = round(ARC_MARGIN / (1 + 2 * ARC_MARGIN) * (STATIONS_ALONG - 1))
BEND_PRIOR_INFORMATION_SHARE = 0.0002
"""Prior information of each bending coefficient, as a share of that of a body's heading."""


@dataclass(frozen=True)
class BendingTemplate:
    """Learned coverage T of a bending body along and across its midline.

    length_bl: nose to tail tip, body lengths. cover: T (STATIONS_ALONG, STATIONS_ACROSS), arcs
    -ARC_MARGIN to 1 + ARC_MARGIN, up to `half_bl` from the midline. skin: body's grey level.
    """

    length_bl: float
    half_bl: float
    cover: Float
    skin: float

    @property
    def basis_coverage_and_slopes(self) -> tuple[Float, Float, Float, Float]:
        """B (STATIONS_ALONG, BEND_TERMS); T; dT/ds and dT/dn, per body length."""
        step = (1 + 2 * ARC_MARGIN) / (STATIONS_ALONG - 1) * self.length_bl
        across = 2 * self.half_bl / (STATIONS_ACROSS - 1)
        along_slope, across_slope = (
            np.asarray(slope) for slope in np.gradient(self.cover, -step, across)
        )
        return bending_basis(station_arcs()), self.cover, along_slope, across_slope

    @property
    def length_and_half_width(self) -> Float:
        """Length and half width, body lengths (2,)."""
        return np.array([self.length_bl, self.half_bl])


def station_arcs() -> Float:
    """Arcs (STATIONS_ALONG,) of the stations."""
    return np.linspace(-ARC_MARGIN, 1 + ARC_MARGIN, STATIONS_ALONG)


def bending_basis(arc: Float) -> Float:
    """Bending basis (n, BEND_TERMS) at arcs; constant beyond the ends, 0 at the reference."""
    x = 2 * np.append(np.clip(arc, 0, 1), REFERENCE_ARC) - 1
    values = np.polynomial.legendre.legvander(x, BEND_TERMS)[:, 1:]
    return values[:-1] - values[-1]


def midline(pose: Float, length_bl: float, arc: Float) -> tuple[Float, Float]:
    """Places (n, 2) [body lengths] and headings (n,) of arcs along a pose's midline."""
    fine = np.linspace(-ARC_MARGIN, 1 + ARC_MARGIN, 8 * STATIONS_ALONG)
    heading = pose[2] + bending_basis(fine) @ pose[3:]
    step = np.column_stack([np.cos(heading), np.sin(heading)]) * (fine[1] - fine[0]) * length_bl
    line = np.concatenate([np.zeros((1, 2)), -np.cumsum(0.5 * (step[1:] + step[:-1]), axis=0)])
    at = np.column_stack([np.interp(np.append(arc, REFERENCE_ARC), fine, axis) for axis in line.T])
    return pose[:2] + at[:-1] - at[-1], pose[2] + bending_basis(arc) @ pose[3:]


@njit(cache=True, error_model="numpy")
def station_positions(pose: Float, size: Float, bend: Float) -> tuple[Float, Float, Float]:
    """Midline p (n, 2), headings theta (n,) and dp/db (n, BEND_TERMS, 2) of all stations."""
    n, joints = bend.shape
    step = (1.0 + 2 * ARC_MARGIN) / (n - 1)
    middle = (REFERENCE_ARC + ARC_MARGIN) / step
    first = int(middle)
    heading = np.empty(n)
    for k in range(n):
        heading[k] = pose[2]
        for j in range(joints):
            heading[k] += pose[3 + j] * bend[k, j]
    place, slope = np.empty((n, 2)), np.zeros((n, joints, 2))
    for way in (1, -1):
        x, y = pose[0], pose[1]
        sums = np.zeros((joints, 2))
        before, part = pose[2], (first + 1 - middle if way > 0 else middle - first)
        last_bend = np.zeros(joints)
        k = first + 1 if way > 0 else first
        while 0 <= k < n:
            ds = -way * part * step * size[0]
            angle = 0.5 * (heading[k] + before)
            x += ds * math.cos(angle)
            y += ds * math.sin(angle)
            for j in range(joints):
                mean = 0.5 * (bend[k, j] + last_bend[j])
                sums[j, 0] -= ds * mean * math.sin(angle)
                sums[j, 1] += ds * mean * math.cos(angle)
                last_bend[j] = bend[k, j]
                slope[k, j, 0], slope[k, j, 1] = sums[j, 0], sums[j, 1]
            place[k, 0], place[k, 1] = x, y
            before, part = heading[k], 1.0
            k += way
    return place, heading, slope


@njit(cache=True, error_model="numpy")
def interpolate_or_nan(image: Float32Image, u: float, v: float) -> float:
    """Bilinear value; NaN outside."""
    height, width = image.shape
    if not (0 <= u < width - 1 and 0 <= v < height - 1):
        return math.nan
    return inner_bilinear(image, u, v)


@njit(cache=True, error_model="numpy")
def straightened_image(
    picture: tuple[Float32Image, Float32Image, PlaneToPixelMap],
    pose: Float,
    line: tuple[Float, Float, Float],
    size: Float,
) -> tuple[Float, Float]:
    """Change and depth (STATIONS_ALONG, STATIONS_ACROSS) by the midline; NaN outside the frame.

    picture: change, depth and maps. line: `station_positions` of the pose.
    """
    changes, depths, maps = picture
    place, heading, _ = line
    n = len(heading)
    change, depth = np.empty((n, STATIONS_ACROSS)), np.empty((n, STATIONS_ACROSS))
    factor, left, top = maps[2]
    local = plane_to_pixel_jacobian(maps[0], maps[1], pose[0], pose[1])
    for k in range(n):
        u, v = horner(maps[0], maps[1], place[k, 0], place[k, 1])
        nx, ny = -math.sin(heading[k]), math.cos(heading[k])
        for a in range(STATIONS_ACROSS):
            far = size[1] * (2.0 * a / (STATIONS_ACROSS - 1) - 1.0)
            x = (u + far * (local[0, 0] * nx + local[0, 1] * ny) + 0.5) / factor - 0.5 - left
            y = (v + far * (local[1, 0] * nx + local[1, 1] * ny) + 0.5) / factor - 0.5 - top
            change[k, a] = interpolate_or_nan(changes, x, y)
            depth[k, a] = interpolate_or_nan(depths, x, y)
    return change, depth


@njit(cache=True, error_model="numpy")
def _write_pose_derivatives(
    row: Float, force: tuple[float, float, float], at: tuple[Float, Float, float], slopes: Float
) -> None:
    """Write d change / d pose, in body axes, of one sample.

    force: slope of the picture along x, along y, and along the midline times the distance across.
    at: place from the reference (2,); bending basis (BEND_TERMS,); heading at the reference.
    """
    fx, fy, turned = force
    away, bend, heading = at
    c, s = math.cos(heading), math.sin(heading)
    row[0] = fx * c + fy * s
    row[1] = -fx * s + fy * c
    row[2] = -fx * away[1] + fy * away[0] - turned
    for j in range(len(bend)):
        row[3 + j] = fx * slopes[j, 0] + fy * slopes[j, 1] - turned * bend[j]


@njit(cache=True, error_model="numpy")
def _accumulate_score_vector(score: Float, side: Float, meat: Float) -> None:
    """Add a station's score to the side, its outer product to `meat`; the score is 0 again."""
    for i in range(len(score)):
        side[i] += score[i]
        for j in range(len(score)):
            meat[i, j] += score[i] * score[j]
    for i in range(len(score)):
        score[i] = 0.0


@njit(cache=True, error_model="numpy")
def _fisher_scoring_equations(
    seen: tuple[Float, Float],
    line: tuple[Float, Float, Float],
    tables: tuple[Float, Float, Float, Float],
    how: tuple[Float, float, float, float],
) -> tuple[Float, Float, Float, Float, float]:
    """Information, side and scores' outer product in body axes; support (8,); the gain found.

    seen: change and depth. line: `station_positions`. how: pose, half width, gain, tolerance.
    """
    change, depth = seen
    place, heading, slopes = line
    bend, cover, along_slope, across_slope = tables
    pose, half, gain, tolerance = how
    n, count = len(heading), 3 + bend.shape[1]
    row, score, side = np.zeros(count), np.zeros(count), np.zeros(count)
    information, meat = np.zeros((count, count)), np.zeros((count, count))
    lost, held, support = np.zeros(3), np.zeros(3), np.zeros(8)
    known, whole, product, square = np.zeros(3), np.zeros(3), 0.0, 1e-9
    for k in range(n):
        part = 3 * k // n
        hc, hs = math.cos(heading[k]), math.sin(heading[k])
        away = place[k] - pose[:2]
        if NOSE_STATION <= k < n - NOSE_STATION:
            whole[part] += 1.0
            known[part] += 1.0 if depth[k, STATIONS_ACROSS // 2] > tolerance else 0.0
        for a in range(STATIONS_ACROSS):
            if not math.isfinite(depth[k, a]):
                continue
            full = cover[k, a] * depth[k, a]
            residual = change[k, a] - gain * full
            weight = 1.0 / (1.0 + (residual / tolerance) ** 2) ** 2
            product += weight * change[k, a] * full
            square += weight * full * full
            lost[part] += min(residual * residual, 2.0 * tolerance * tolerance)
            held[part] += (gain * full) ** 2
            along = gain * depth[k, a] * along_slope[k, a]
            across = gain * depth[k, a] * across_slope[k, a]
            turned = along * half * (2.0 * a / (STATIONS_ACROSS - 1) - 1.0)
            force = (along * hc - across * hs, along * hs + across * hc, turned)
            _write_pose_derivatives(row, force, (away, bend[k], pose[2]), slopes[k])
            for i in range(count):
                score[i] += weight * residual * row[i]
                for j in range(i + 1):
                    information[i, j] += weight * row[i] * row[j]
        _accumulate_score_vector(score, side, meat)
    for i in range(count):
        for j in range(i):
            information[j, i] = information[i, j]
    for part in range(3):
        support[part] = 1.0 - lost[part] / max(held[part], 1e-9)
        support[5 + part] = known[part] / whole[part]
    support[3] = 1.0 - lost.sum() / max(held.sum(), 1e-9)
    support[4] = known.sum() / whole.sum()
    return information, side, meat, support, product / square


@njit(cache=True, error_model="numpy")
def _limited_fisher_scoring_step(information: Float, side: Float, pose: Float) -> Float:
    """Change of the pose in body axes; bending tied to none, the more the higher its order."""
    normal, right = information.copy(), side.copy()
    tie = BEND_PRIOR_INFORMATION_SHARE * information[2, 2]
    for i in range(len(pose)):
        normal[i, i] += 0.01 * information[i, i] + 1e-6
        if i > 2:
            normal[i, i] += tie * (i - 2) ** 2
            right[i] += tie * (i - 2) ** 2 * pose[i]
    step = -np.linalg.solve(normal, right)
    largest = max(math.hypot(step[0], step[1]) / MAX_MOVE_BL, np.abs(step[2:]).max() / MAX_TURN_RAD)
    return step / max(1.0, largest)


@njit(cache=True, error_model="numpy")
def fit_midline_pose(
    picture: tuple[Float32Image, Float32Image, PlaneToPixelMap],
    tables: tuple[Float, Float, Float, Float],
    size: Float,
    start: Float,
    tolerance: float,
) -> tuple[Float, Float, Float, Float]:
    """Pose; information (P, P) and scores' outer product (P, P) in body axes; support (8,).

    Support: of head, core and tail third and of all, 1 - squared residuals (clipped) over the
    squared model; and the share seen (in the picture, not hidden, not before a background as dark)
    of the body and its thirds. tolerance: residual [grey levels] from which it counts little.
    """
    pose, gain, settled = start.copy(), 1.0, False
    for turn in range(MAX_ITERATIONS + 1):
        line = station_positions(pose, size, tables[0])
        seen = straightened_image(picture, pose, line, size)
        how = (pose, size[1], gain, tolerance)
        information, side, meat, support, found = _fisher_scoring_equations(seen, line, tables, how)
        if settled or turn == MAX_ITERATIONS or support[4] < MIN_SEEN_SHARE:
            break
        step = _limited_fisher_scoring_step(information, side, pose)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        pose[0] += c * step[0] - s * step[1]
        pose[1] += s * step[0] + c * step[1]
        for i in range(2, len(pose)):
            pose[i] += step[i]
        gain = min(max(found, CONTRAST_GAIN_RANGE[0]), CONTRAST_GAIN_RANGE[1])
        settled = turn > 0 and np.abs(step).max() < CONVERGED_STEP
    return pose, information, meat, support
