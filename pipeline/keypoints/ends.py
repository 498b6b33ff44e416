"""Nose and tail base of a body that is not rigid: the ends of its outline, told apart by the tail.

The body is what is nearly as dark (or bright) as its middle; a thin, fainter thing that leaves it
is the tail, and where it leaves is the tail base. The nose is the body's far end from there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from ..data import Frame, Keypoints
from ..faults import fault
from ..study import Setup, Trial
from .outline.background import Image, noise_level, ranked, sample
from .outline.leaving import tail_exit
from .outline.turns import turned_round

NAMES = ("head_tip", "core_center", "tail_base")
Float = npt.NDArray[np.float64]
SAMPLES = 25
SOLID, STRONG = 0.72, 0.5
SPREAD = (0.115, 0.08, 0.08)
ROI_GROWTH = 2.2
SELDOM = 0.1
LEAST_CHANGE = 20.0
UNTOLD = 0.5


@dataclass(frozen=True)
class Arena:
    """The place without the body: its picture, where to look (mask), least change that counts.

    sign: 1 where the body is darker than the floor, -1 where it is brighter.
    """

    floor: Image
    region: Image
    level: float
    sign: float


@dataclass(frozen=True)
class Body:
    """One frame's body: nose, centre, tail base (3, 2) px; largest inscribed radius; area [px^2].

    tailed: whether the tail was seen, which tells the ends apart.
    """

    points: Float
    radius: float
    area: float
    tailed: bool


def detect(frames: Callable[[], Iterable[Frame]], setup: Setup, trial: Trial) -> Keypoints:
    """Keypoints head_tip, core_center (centre of the body's area) and tail_base of every frame.

    Likelihood falls where no tail tells the ends apart, where they were the wrong way round or the
    frames before and after do not agree on it, and where the body's area is unusual; covariances
    are a tenth of the body's half-width, as measured on labelled footage.

    Raises: Fault where the footage holds no frame.
    """
    samples = [frame.luma for frame in sample(frames(), SAMPLES)]
    if not samples:
        raise fault(trial.source, "", "no frames", "footage with frames")
    arena = arena_of(samples, setup)
    times: list[float] = []
    bodies: list[Body | None] = []
    for frame in frames():
        before = bodies[-1] if bodies else None
        times.append(frame.time_s)
        bodies.append(body_of(frame.luma, arena, before))
    return _keypoints(np.array(times), bodies)


def _region(shape: tuple[int, ...], setup: Setup) -> Image:
    """Mask of the pool (or arena) and a little around it."""
    corners = np.array(setup.camera.pool_corners_px, dtype=float)
    middle = corners.mean(axis=0)
    mask = np.zeros(shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, (middle + 1.08 * (corners - middle)).round().astype(np.int32), 1)
    return mask


def arena_of(samples: Sequence[Image], setup: Setup) -> Arena:
    """The place without its body, from pictures spread over the film.

    Where something passed, a pixel's usual grey level is the floor's; only where the body rests
    for long it is the body's. So most of the swept pixels tell whether the body is the darker or
    the brighter one, and the floor is what each pixel is like without it, be that seldom.
    """
    least, low, usual, high, most = ranked(samples, 0.0, SELDOM, 0.5, 1 - SELDOM, 1.0)
    region = _region(usual.shape, setup)
    level = max(LEAST_CHANGE, 6.0 * noise_level(samples, usual))
    brighter, darker = (_swept(away, region, level) for away in (most - usual, usual - least))
    sign, rare = (1.0, high) if darker >= brighter else (-1.0, low)
    floor = np.where(cv2.absdiff(rare, usual) > level, rare, usual)
    return Arena(floor, region, level, sign)


def _swept(away: Image, region: Image, level: float) -> float:
    """How much changes at some time, summed over the region, grey levels."""
    return float(away[(region > 0) & (away > level)].sum(dtype=float))


def body_of(luma: Image, arena: Arena, before: Body | None) -> Body | None:
    """Body of one frame; None without one. before: the body in the frame before."""
    change = arena.sign * cv2.subtract(arena.floor, luma, dtype=cv2.CV_16S).astype(np.float32)
    box = _strongest(change, arena.region, arena.level)
    if box is None:
        return None
    change, luma = change[box], luma[box]
    ground = arena.sign * arena.floor[box].astype(np.float32)
    most = float(np.percentile(change[change > arena.level], 95))
    skin = float(np.median(arena.sign * luma[change > STRONG * most].astype(float)))
    cover = change / np.maximum(ground - skin, 25.0)
    cover[ground - skin < 30] = 0.0
    outline = _outline(cover > SOLID, change)
    if outline is None:
        return None
    return _ends(outline, cover, (box[1].start, box[0].start), before)


def _strongest(change: Float, region: Image, level: float) -> tuple[slice, slice] | None:
    """Box about the blob that changed most, with room for the tail."""
    size = max(3, change.shape[1] // 70)
    mask = (change > level).astype(np.uint8) & region
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((size, size), np.uint8))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    if not contours:
        return None
    strongest = max(contours, key=lambda contour: _amount(contour, mask, change))
    x, y, w, h = cv2.boundingRect(strongest)
    reach = int(0.5 * ROI_GROWTH * max(w, h))
    top, left = max(0, y + h // 2 - reach), max(0, x + w // 2 - reach)
    return slice(top, y + h // 2 + reach), slice(left, x + w // 2 + reach)


def _outline(solid: npt.NDArray[np.bool_], change: Float) -> npt.NDArray[np.int32] | None:
    """Contour (n, 2) of the solid part that changed most in all; a reflection changes less."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
    mask = cv2.morphologyEx(solid.astype(np.uint8), cv2.MORPH_OPEN, disc)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    strongest = max(contours, key=lambda contour: _amount(contour, mask, change))[:, 0]
    return strongest if len(strongest) > 20 else None


def _amount(contour: npt.NDArray[np.int32], mask: Image, change: Float) -> float:
    """Change summed over the part of a mask in a contour's box."""
    x, y, w, h = cv2.boundingRect(contour)
    cut = slice(y, y + h), slice(x, x + w)
    return float(change[cut][mask[cut] > 0].sum())


def _ends(
    outline: npt.NDArray[np.int32], cover: Float, corner: tuple[int, int], before: Body | None
) -> Body:
    mask = np.zeros(cover.shape, np.uint8)
    cv2.drawContours(mask, [outline[:, None]], -1, 1, -1)
    radius = float(cv2.distanceTransform(mask, cv2.DIST_L2, 5).max())
    line = outline.astype(float)
    moments = cv2.moments(outline[:, None])
    centre = np.array([moments["m10"], moments["m01"]]) / max(moments["m00"], 1.0)
    exit_px = tail_exit(cover, mask, radius)
    tailed = exit_px is not None
    if exit_px is None:
        exit_px = _far_end(line, centre, before, corner)
    base = line[np.argmin(np.hypot(*(line - exit_px).T))]
    nose = line[np.argmax(np.hypot(*(line - base).T))]
    points = np.stack([nose, centre, base]) + np.array(corner, dtype=float)
    return Body(points, radius, float(moments["m00"]), tailed)


def _far_end(line: Float, centre: Float, before: Body | None, corner: tuple[int, int]) -> Float:
    """Rear end of a body without a visible tail: where it was before, else its blunter end."""
    axis = np.linalg.svd(line - centre, full_matrices=False)[2][0]
    along = (line - centre) @ axis
    ends = (line[np.argmax(along)], line[np.argmin(along)])
    if before is not None:
        last = before.points[2] - np.array(corner, dtype=float)
        return min(ends, key=lambda end: float(np.hypot(*(end - last))))
    reach = 0.25 * np.ptp(along)
    near = [np.hypot(*(line - end).T) < reach for end in ends]
    across = np.array([-axis[1], axis[0]])
    widths = [float(np.ptp((line[part] - centre) @ across)) for part in near]
    return ends[int(np.argmax(widths))]


def _keypoints(times: Float, bodies: list[Body | None]) -> Keypoints:
    n, p = len(times), len(NAMES)
    xy, likelihood = np.full((n, p, 2), np.nan), np.zeros((n, p))
    cov = np.full((n, p, 2, 2), np.nan)
    usual = float(np.median([b.area for b in bodies if b is not None] or [1.0]))
    wrong, doubt = _ways_round(bodies)
    for i, body in enumerate(bodies):
        if body is None:
            continue
        xy[i] = body.points[::-1] if wrong[i] else body.points
        share = min(body.area, usual) / max(body.area, usual)
        certain = min(1.0, max(0.0, 2.0 * share - 0.4))
        untold = doubt[i] or wrong[i] or not body.tailed
        likelihood[i] = certain * np.array([UNTOLD, 1.0, UNTOLD] if untold else [1.0] * 3)
        cov[i] = np.array([(s * body.radius) ** 2 * np.eye(2) for s in SPREAD])
    lost = sum(body is None for body in bodies)
    remarks = (f"{lost} of {n} frames without a body",) if lost else ()
    return Keypoints(times, NAMES, xy, likelihood, cov, remarks)


def _ways_round(bodies: list[Body | None]) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Frames whose ends are the wrong way round, and those where that is in doubt."""
    points = np.full((len(bodies), 3, 2), np.nan)
    reach, weight = np.zeros((2, len(bodies)))
    for i, body in enumerate(bodies):
        if body is not None:
            points[i], reach[i] = body.points, 2.0 * body.radius
            weight[i] = 1.0 if body.tailed else 0.1
    return turned_round(points[:, 0], points[:, 2], reach, weight)
