"""What the learning frames show of the outline: offsets, grey levels, blur, stations at odds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from ...data import Float, Frame
from .edges import MIN_CONTRAST_GREY_LEVELS, LumaPicture, interpolate_where
from .pose_fit import OutlineArrays, measure_edge_offsets
from .template import (
    CORE_STATION_COUNT,
    HEAD_PART,
    HEAD_STATION_COUNT,
    OutlineTemplate,
    nan_median,
    station_contrast,
)
from .tracking import DetectionScene, OutlineFit

GREY_LEVEL_SAMPLE_DEPTHS_PX = np.array([2.5, 4.5])
LEAST_BLUR_PX = 0.5
"""Least rms blur of what is read from a picture: variance 1/12 of a pixel's width, and 1/6, on
average, of linear interpolation between pixels."""
ACROSS_EDGE_PX, EDGE_END_SAMPLES = np.arange(-5.0, 5.5, 0.5), 4
"""Places across an edge, outwards, at which its blur is read, and how many of them at either end
show the body and the floor alone."""
MIN_LATERAL_NORMAL_COMPONENT = 0.95
"""Sides of the head: the normal's least share across its axis (18 degrees)."""
MAX_CONTRAST_LOSS_BY_SMEARING = 0.04
FLOOR_SAMPLING_STRIDE_PX = 16
MIN_BIAS_PX, MIN_BIAS_RATIO, MAX_BIASED_SHARE = 0.15, 6.0, 0.15


def measure_stations(
    fits: Sequence[tuple[Frame, OutlineFit]],
    scene: DetectionScene,
    template: OutlineTemplate,
    reach: int,
) -> tuple[Float, Float]:
    """Offsets [body lengths] and grey levels inside (frames, stations), NaN where not seen."""
    visible = template.visible_stations()
    shape = template.outline_arrays()
    count = 2 * (HEAD_STATION_COUNT + CORE_STATION_COUNT)
    offsets = np.full((len(fits), count), np.nan)
    greys = np.full((len(GREY_LEVEL_SAMPLE_DEPTHS_PX), len(fits), count), np.nan)
    for row, (frame, one) in enumerate(fits):
        pictures = (frame.luma, scene.floor)
        found, slope = measure_edge_offsets(
            pictures, scene.plane_to_pixel_map, shape, one.pose, reach
        )
        scale = np.hypot(slope[:, 0], slope[:, 1])
        offsets[row, visible] = found / scale
        greys[:, row, visible] = _sample_across_edge(
            frame.luma, scene, shape, (one.pose, found / scale), GREY_LEVEL_SAMPLE_DEPTHS_PX
        )
    return offsets, _body_grey_levels(
        greys, float(np.median(scene.floor[::FLOOR_SAMPLING_STRIDE_PX, ::FLOOR_SAMPLING_STRIDE_PX]))
    )


def _body_grey_levels(greys: Float, floor: float) -> Float:
    """Grey levels (frames, stations) of the body itself, of those at each depth inside its edge.

    Where a blunt end moves along itself during the exposure its edge is smeared over more than
    the least depth: deeper levels count where, over all frames and on both sides, they stand out
    more from the floor.
    """
    standing = [station_contrast(grey, floor) for grey in greys]
    smeared = standing[1] > (1 + MAX_CONTRAST_LOSS_BY_SMEARING) * standing[0]
    return np.where(smeared, greys[1], greys[0])


def picture_blur_px(
    fits: Sequence[tuple[Frame, OutlineFit]],
    scene: DetectionScene,
    template: OutlineTemplate,
    offsets_bl: Float,
) -> float:
    """Lateral blur (rms) at the sides of the head, interpolation between pixels included, px.

    Half the distance over which the median coverage of the edges falls from 0.84 to 0.16, which is
    the standard deviation of a Gaussian blur. Motion during the exposure blurs along the head too,
    but does not displace the edges.

    offsets_bl: (frames, stations) found by `measure_stations` with this template.
    """
    points, normals, part, skin = template.outline_arrays()
    side = (part == HEAD_PART) & (np.abs(normals[:, 1]) > MIN_LATERAL_NORMAL_COMPONENT)
    shape, skin = (points[side], normals[side], part[side], skin[side]), skin[side]
    covered = []
    for (frame, one), offset in zip(
        fits, offsets_bl[:, template.visible_stations()][:, side], strict=True
    ):
        at = one.pose, offset
        seen, clear = (
            _sample_across_edge(image, scene, shape, at, -ACROSS_EDGE_PX)
            for image in (frame.luma, scene.floor)
        )
        depth = np.where(np.abs(clear - skin) > MIN_CONTRAST_GREY_LEVELS, clear - skin, np.nan)
        covered.append((clear - seen) / depth)
    return float(np.fmax(LEAST_BLUR_PX, edge_blur_px(np.concatenate(covered, axis=1))))


def edge_blur_px(covered: Float) -> float:
    """Standard deviation [px] of the blur of edges, from their coverage (places, edges); NaN if no
    edge is visible.
    """
    profile = nan_median(covered.T)
    inside, outside = profile[:EDGE_END_SAMPLES].mean(), profile[-EDGE_END_SAMPLES:].mean()
    fall = np.minimum.accumulate((profile - outside) / (inside - outside))
    first, last = np.interp([-ndtr(1.0), -ndtr(-1.0)], -fall, ACROSS_EDGE_PX)
    return float(last - first) / 2


def _sample_across_edge(
    image: LumaPicture,
    scene: DetectionScene,
    shape: OutlineArrays,
    at: tuple[Float, Float],
    depths_px: Float,
) -> Float:
    """Grey levels (depths, n) at these depths inside the edge of each point, NaN without an edge.

    at: pose (4,), offsets (n,) [body lengths].
    """
    points, normals, part, _ = shape
    pose, offset_bl = at
    angle = np.where(part == HEAD_PART, pose[2] - pose[3], pose[2])
    depth = np.nan_to_num(offset_bl) - depths_px[:, None] / scene.plane.px_per_bl
    place = points + normals * depth[..., None]
    turned = (place[..., 0] + 1j * place[..., 1]) * np.exp(1j * angle) + complex(*pose[:2])
    uv = scene.plane.body_lengths_to_pixels(
        np.column_stack([turned.real.ravel(), turned.imag.ravel()])
    )
    height, width = image.shape
    ok = (uv > 1).all(axis=1) & (uv[:, 0] < width - 3) & (uv[:, 1] < height - 3)
    ok &= np.isfinite(np.tile(offset_bl, len(depths_px)))
    return interpolate_where(image, uv, ok).reshape(len(depths_px), -1)


def without_biased_stations(template: OutlineTemplate, offsets_px: Float) -> OutlineTemplate:
    """The template without the stations whose edge stays off the outline that was learned.

    A pale or dark mark close inside the outline does that, on one spot and in every frame.
    offsets_px: (frames, stations), NaN where not seen.
    """
    seen = np.isfinite(offsets_px).sum(axis=0) > 1
    usual = np.abs(nan_median(np.where(seen, offsets_px, 0.0)))
    limit = max(MIN_BIAS_PX, MIN_BIAS_RATIO * float(np.median(usual[template.visible_stations()])))
    biased = usual > limit
    return replace(template, biased=biased) if np.mean(biased) < MAX_BIASED_SHARE else template
