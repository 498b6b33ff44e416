"""Where a dot is: the centre of its coverage, its colour unmixed from those around it."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...data import Float

INSIDE_RADII, OUTSIDE_RADII, BACKGROUND_RING_RADII = 0.5, 1.7, (1.8, 2.6)
UNMIXING_ITERATIONS = 3
NOISE_STD_GREY_LEVELS = 3.0
MIN_DOT_COVERAGE_SHARE = 0.3


def coverage_centroid(
    image: npt.NDArray[np.uint8], centre: Float, radius: float
) -> tuple[Float, float]:
    """Centre (2,) px of a dot's coverage near a first centre, and the area covered, px^2.

    Colours mix linearly, so coverage is the colour (3,) projected on S^-1 (dot - around), 0 around
    and 1 in the dot; S, the covariance of the colours around, makes it blind to what those differ
    by, as water and skin do (Fisher's discriminant). Unlike a hue it does not bend where they mix.
    image: (height, width, 3). The first centre is kept, and the area NaN, where too little of the
    dot is inside.
    """
    low = np.maximum(np.floor(centre - BACKGROUND_RING_RADII[1] * radius).astype(int), 0)
    high = np.ceil(centre + BACKGROUND_RING_RADII[1] * radius).astype(int) + 1
    patch = image[low[1] : high[1], low[0] : high[0]].astype(float)
    v, u = np.indices(patch.shape[:2])
    here = centre - low
    for _ in range(UNMIXING_ITERATIONS):
        away = np.hypot(u - here[0], v - here[1])
        cover = _dot_coverage_of_pixels(patch, away / radius)
        if cover is None:
            return centre, math.nan
        near = np.where(away < OUTSIDE_RADII * radius, cover, 0.0)
        here = np.array([np.sum(near * u), np.sum(near * v)]) / near.sum()
        if np.hypot(*(here + low - centre)) > radius:
            return centre, math.nan
    return here + low, float(near.sum())


def _dot_coverage_of_pixels(patch: Float, away: Float) -> Float | None:
    """How much of each pixel the dot covers; away: distance from its centre in radii."""
    inside, around = (
        patch[away < INSIDE_RADII],
        patch[(away > BACKGROUND_RING_RADII[0]) & (away < BACKGROUND_RING_RADII[1])],
    )
    if len(inside) < 3 or len(around) < 20:
        return None
    rest = around.mean(axis=0)
    apart = inside.mean(axis=0) - rest
    blind = np.linalg.solve(np.cov(around.T) + NOISE_STD_GREY_LEVELS**2 * np.eye(3), apart)
    cover = (patch - rest) @ blind / (apart @ blind)
    return (
        cover
        if cover[away < OUTSIDE_RADII].sum() > MIN_DOT_COVERAGE_SHARE * np.sum(away < 1.0)
        else None
    )
