"""Corners of the pool from its edges in a frame, with their uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ..data import Float
from .boards import GreyPicture
from .homography_camera import homography_from_four_points
from .lens import Lens, project_to_pixels, ray_directions
from .pool_edges import (
    SAMPLES_PER_EDGE,
    EdgeLine,
    ExpectedEdge,
    FloatPicture,
    find_edge_lines,
    smooth_frame,
)
from .resection import pool_diagonal_px

EDGE_NAMES = ("(0,0) to (length,0)", "(length,0) to (length,width)", "(length,width) to (0,width)",
         "(0,width) to (0,0)")  # fmt: skip
"""Edges of the pool by the corners between which they run."""
WIDE_SEARCH_RANGE_SHARE_OF_WIDTH, NARROW_SEARCH_RANGE_SHARE_OF_WIDTH = 0.04, 0.012
"""Search reach over the picture's width: around the corners given, and around corners found."""
MAX_POOL_CORNER_FIT_ITERATIONS = 12
POOL_CORNER_CONVERGENCE_PX = 0.05
"""Movement of the corners, px, below which the fit has converged."""
CLICK_ERROR_SHARE_OF_POOL_DIAGONAL = 0.002
"""Usual error of a corner given by eye, over the pool's diagonal in the picture."""
MAX_CORNER_STD_SHARE_OF_POOL_DIAGONAL = 0.001
"""Corners less certain than this share of the diagonal are not confirmed."""
MIN_CROSSING_SINE = 0.2
"""Sine of the angle between two edges, below which their crossing is no corner."""
MAX_RIM_SPACING_SPREAD_SHARE = 0.3
"""Second lines beside all four edges are one rim where the largest difference of their distances is
a smaller share of the mean."""
RECTANGLE_MISFIT_STD, MAX_RECTANGLE_MISFIT_LOSS = 0.005, 30.0
"""Skew of a rectangle that the errors of a calibrated lens leave, and the most that it counts."""
UNKNOWN_LENS_CORNER_STD_PX = 0.4
"""Error of corners found without a camera matrix, where the distortion is assumed equidistant."""
BEND_PENALTY_PER_PX = 0.2
"""Share of an edge that a pixel of rms bend outweighs."""


@dataclass(frozen=True)
class CornerFit:
    """Corners of the pool where its edges meet.

    corners_px: (4, 2), NaN where an edge is missing. std_px: (4,) of each coordinate. curves,
    lines: each edge as expected by the corners found, and the line found there (None: no line).
    inner_rim_px: (4, 2) corners of a second rim inside, NaN without one; rim_px: how far inside.
    outer_px: how far outside another rim was seen, 0 without one. converged: whether
    another iteration would move no corner.
    """

    corners_px: Float
    std_px: Float
    curves: tuple[ExpectedEdge, ...]
    lines: tuple[EdgeLine | None, ...]
    inner_rim_px: Float
    rim_px: float
    outer_px: float
    iterations: int
    converged: bool

    @property
    def doubts(self) -> tuple[str, ...]:
        """Reasons why the corners found are not certain; empty where they are."""
        missing = [name for name, line in zip(EDGE_NAMES, self.lines, strict=True) if line is None]
        if missing:
            return tuple(f"edge {name}: no straight step in brightness found" for name in missing)
        reasons = []
        if not self.converged:
            reasons.append(f"the corners still move after {self.iterations} iterations")
        if np.max(self.std_px) > MAX_CORNER_STD_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(
            self.corners_px
        ):
            reasons.append(f"the corners found are uncertain by {np.max(self.std_px):.1f} px")
        if self.rim_px > 0:
            reasons.append(
                f"two rims: the corners given belong to the outer one, another lies "
                f"{self.rim_px:.0f} px further inside"
            )
        return tuple(reasons)


def fit_corners(
    grey: GreyPicture, given_px: Float, lens: Lens | None, corners_m: Float | None = None
) -> CornerFit:
    """Corners where the pool's edges meet, starting from corners given (4, 2), iterated.

    Each edge is straight through the lens; without one, through the equidistant fisheye lens under
    which the most of the edges is straight. Where several lines run along
    an edge, the four that fit the corners given best are selected, with little weight on a corner
    far off: three good corners correct a bad one, and a rim is not exchanged for another. With a
    lens and the pool's corners (4, 3) m, lines that no camera could see together are passed over.
    """
    picture = smooth_frame(grey)
    model_std_px = 0.0 if lens else UNKNOWN_LENS_CORNER_STD_PX
    view = (lens, corners_m) if lens and corners_m is not None else None
    width, assumed = grey.shape[1], lens is None
    lens = lens or lens_from_straight_edges(picture, given_px, WIDE_SEARCH_RANGE_SHARE_OF_WIDTH)
    click = CLICK_ERROR_SHARE_OF_POOL_DIAGONAL * pool_diagonal_px(given_px)
    corners, reach, iteration = given_px, WIDE_SEARCH_RANGE_SHARE_OF_WIDTH * width, 0
    lines: tuple[EdgeLine | None, ...] = (None,) * 4
    curves, converged = _expected_edge_curves(given_px, lens), False
    for iteration in range(1, MAX_POOL_CORNER_FIT_ITERATIONS + 1):
        near = given_px if iteration == 1 else corners
        found = [find_edge_lines(picture, curve, reach) for curve in curves]
        lines = _select_edge_lines(curves, found, (near, click), view)
        if None in lines:
            break
        moved = _intersect_neighbouring_edges(curves, lines)
        converged = bool(np.max(np.abs(moved - corners)) < POOL_CORNER_CONVERGENCE_PX)
        corners, reach = moved, NARROW_SEARCH_RANGE_SHARE_OF_WIDTH * width
        if assumed and iteration == 1:  # the lens of corners some pixels off is not yet right
            lens = lens_from_straight_edges(picture, corners, NARROW_SEARCH_RANGE_SHARE_OF_WIDTH)
        curves = _expected_edge_curves(corners, lens)
        if converged:
            break
    complete = None not in lines
    inner = _find_second_rim(picture, curves, inside=True) if complete else None
    outer = _find_second_rim(picture, curves, inside=False) if complete else None
    nowhere = np.full((4, 2), np.nan)
    return CornerFit(
        corners_px=corners if complete else _intersect_neighbouring_edges(curves, lines),
        std_px=np.hypot(_corner_std_px(curves, lines), model_std_px),
        curves=curves,
        lines=lines,
        inner_rim_px=_intersect_neighbouring_edges(curves, inner) if inner else nowhere,
        rim_px=_mean_rim_offset_px(inner),
        outer_px=_mean_rim_offset_px(outer),
        iterations=iteration,
        converged=converged,
    )


def lens_from_straight_edges(picture: FloatPicture, corners_px: Float, reach_share: float) -> Lens:
    """Equidistant fisheye lens, r = f theta, under which the most of the edges is straight.

    reach_share: how far from the corners' edges lines are searched, over the picture's width.
    A calibration by plumb lines (Brown 1971) with one parameter; the longest f is a pinhole.
    """
    height, width = picture.shape

    def lens_of_focal(share: float) -> Lens:
        matrix = np.array([[share * width, 0, (width - 1) / 2],
                           [0, share * width, (height - 1) / 2], [0, 0, 1]])  # fmt: skip
        return Lens("fisheye", matrix, np.zeros(4), (width, height))

    def straightness(share: float) -> float:
        curves = _expected_edge_curves(corners_px, lens_of_focal(share))
        lines = [find_edge_lines(picture, curve, reach_share * width)[:1] for curve in curves]
        return sum(
            line.share - BEND_PENALTY_PER_PX * line.bend_px for some in lines for line in some
        )

    inverse = np.linspace(0.02, 2.8, 15)
    scores = [straightness(1 / value) for value in inverse]
    best = inverse[int(np.argmax(scores))]
    finer = np.linspace(best - 0.18, best + 0.18, 9).clip(0.02)
    return lens_of_focal(1 / max(finer, key=lambda value: straightness(1 / value)))


def _expected_edge_curves(corners_px: Float, lens: Lens) -> tuple[ExpectedEdge, ...]:
    """Images of straight lines from each corner (4, 2) to the next."""
    share = np.linspace(0, 1, SAMPLES_PER_EDGE)[:, None]
    curves = []
    for start, end in zip(corners_px, np.roll(corners_px, -1, axis=0), strict=True):
        first, last = ray_directions(lens, np.array([start, end]))
        points = project_to_pixels(lens, first + share * (last - first))
        if not np.isfinite(points).all():
            points = start + share * (end - start)
        tangent = np.gradient(points, axis=0)
        normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
        curves.append(ExpectedEdge(points, normal / np.linalg.norm(normal, axis=1)[:, None]))
    return tuple(curves)


def _select_edge_lines(
    curves: tuple[ExpectedEdge, ...], found: Sequence[Sequence[EdgeLine]],
    near: tuple[Float, float],
    view: tuple[Lens, Float] | None,
) -> tuple[EdgeLine | None, ...]:  # fmt: skip
    """One line of each edge, so that the corners lie nearest to those of `near`: (4, 2) and their
    usual error, px, by Cauchy's robust loss, and so that a camera could see them.
    """
    if not all(found):
        return tuple(
            min(some, key=lambda e: abs(e.middle_offset_px), default=None) for some in found
        )
    choices = list(product(*found))
    corners = np.array([_intersect_neighbouring_edges(curves, lines) for lines in choices])
    off = np.sum((corners - near[0]) ** 2, axis=2) / near[1] ** 2
    missing = np.array([sum(1 - line.share for line in lines) for lines in choices])
    loss = np.sum(np.log1p(off), axis=1) + missing
    if view is not None:
        loss += np.minimum(
            (_rectangle_misfit(corners, *view) / RECTANGLE_MISFIT_STD) ** 2,
            MAX_RECTANGLE_MISFIT_LOSS,
        )
    return choices[int(np.argmin(np.nan_to_num(loss, nan=np.inf)))]


def _rectangle_misfit(corners_px: Float, lens: Lens, corners_m: Float) -> Float:
    """How far each set of corners (n, 4, 2) is from a rectangle seen by the lens: (n,).

    In rays of the lens the homography from the pool's plane is s [r1 r2 t], r1 and r2 orthonormal:
    the root of (r1.r2 / |r1||r2|)^2 + log^2(|r1| / |r2|).
    """
    rays = ray_directions(lens, corners_px.reshape(-1, 2))
    plane = (rays[:, :2] / rays[:, 2:]).reshape(-1, 4, 2)
    skew = np.full(len(plane), np.nan)
    for i in np.flatnonzero(np.isfinite(plane).all(axis=(1, 2))):
        first, second = homography_from_four_points(corners_m[:, :2], plane[i]).T[:2]
        lengths = np.linalg.norm(first), np.linalg.norm(second)
        cosine = float(first @ second) / (lengths[0] * lengths[1])
        skew[i] = np.hypot(cosine, np.log(lengths[0] / lengths[1]))
    return skew


def _intersect_neighbouring_edges(
    curves: tuple[ExpectedEdge, ...], lines: Sequence[EdgeLine | None]
) -> Float:
    """Corners (4, 2) where neighbouring lines meet; NaN where one is missing.

    The shift d solves n_1 . d = o_1 and n_2 . d = o_2 for the two edges' normals and offsets.
    """
    corners = np.full((4, 2), np.nan)
    for k in range(4):
        before, after = lines[k - 1], lines[k]
        normals = _edge_normals_at_corner(curves, k)
        if before and after and abs(np.linalg.det(normals)) > MIN_CROSSING_SINE:
            offsets = np.array([before.ends_px[1], after.ends_px[0]])
            corners[k] = curves[k].points_px[0] + np.linalg.solve(normals, offsets)
    return corners


def _edge_normals_at_corner(curves: tuple[ExpectedEdge, ...], k: int) -> Float:
    """Normals (2, 2) of the two edges at corner k."""
    return np.array([curves[k - 1].normal_px[-1], curves[k].normal_px[0]])


def _corner_std_px(curves: tuple[ExpectedEdge, ...], lines: Sequence[EdgeLine | None]) -> Float:
    """Standard deviation (4,) of a corner's coordinates, mean of the two, from its two lines."""
    std = np.full(4, np.nan)
    for k in range(4):
        before, after = lines[k - 1], lines[k]
        normals = _edge_normals_at_corner(curves, k)
        if before and after and abs(np.linalg.det(normals)) > MIN_CROSSING_SINE:
            spread = np.array([before.ends_std_px[1], after.ends_std_px[0]])
            std[k] = np.linalg.norm(np.linalg.inv(normals) * spread) / np.sqrt(2)
    return std


def _find_second_rim(
    picture: FloatPicture, curves: tuple[ExpectedEdge, ...], *, inside: bool
) -> tuple[EdgeLine, ...] | None:
    """Second rim: a line along every edge, all on one side and about equally far away."""
    middle = np.mean([curve.points_px.mean(axis=0) for curve in curves], axis=0)
    candidates = []
    for curve in curves:
        toward = curve.normal_px * (middle - curve.points_px)
        side = np.sign(np.sum(toward)) * (1 if inside else -1)
        lines = find_edge_lines(picture, curve, WIDE_SEARCH_RANGE_SHARE_OF_WIDTH * picture.shape[1])
        candidates.append([e for e in lines if np.all(side * e.ends_px > 2.0)])
    best = min(
        product(*candidates), default=None,
        key=lambda lines: float(np.ptp([abs(e.middle_offset_px) for e in lines])),
    )  # fmt: skip
    if best is None:
        return None
    spacing = [abs(line.middle_offset_px) for line in best]
    return (
        best
        if np.ptp(spacing) < max(2.0, MAX_RIM_SPACING_SPREAD_SHARE * float(np.mean(spacing)))
        else None
    )


def _mean_rim_offset_px(rim: tuple[EdgeLine, ...] | None) -> float:
    return float(np.mean([abs(line.middle_offset_px) for line in rim])) if rim else 0.0
