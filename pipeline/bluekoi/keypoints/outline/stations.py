"""What the learning frames show at each station of the outline: offsets, grey levels, odd ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...data import Float, Frame
from .edges import interpolate_where
from .pose_fit import OutlineArrays, measure_edge_offsets
from .template import (
    CORE_STATION_COUNT,
    HEAD_STATION_COUNT,
    OutlineTemplate,
    nan_median,
    station_contrast,
)
from .tracking import DetectionScene, OutlineFit

INSIDE_DEPTHS_PX = (2.5, 4.5)
MAX_SMEARING_SHARE = 0.04
MIN_SAMPLES = 16
MIN_BIAS_PX, MIN_BIAS_RATIO, MAX_BIASED_SHARE = 0.15, 6.0, 0.15


def measure_stations(
    fits: Sequence[tuple[Frame, OutlineFit]],
    scene: DetectionScene,
    template: OutlineTemplate,
    reach: int,
) -> tuple[Float, Float]:
    """Offsets [body lengths] and grey levels inside (frames, stations), NaN where not seen."""
    visible = template.visible_stations()
    shape = template.shape()
    count = 2 * (HEAD_STATION_COUNT + CORE_STATION_COUNT)
    offsets = np.full((len(fits), count), np.nan)
    greys = np.full((len(INSIDE_DEPTHS_PX), len(fits), count), np.nan)
    for row, (frame, one) in enumerate(fits):
        pictures = (frame.luma, scene.floor)
        found, slope = measure_edge_offsets(pictures, scene.maps, shape, one.pose, reach)
        scale = np.hypot(slope[:, 0], slope[:, 1])
        offsets[row, visible] = found / scale
        greys[:, row, visible] = _grey_levels_inside_edge(
            frame, scene, shape, (one.pose, found / scale)
        )
    return offsets, _body_grey_levels(
        greys, float(np.median(scene.floor[::MIN_SAMPLES, ::MIN_SAMPLES]))
    )


def _body_grey_levels(greys: Float, floor: float) -> Float:
    """Grey levels (frames, stations) of the body itself, of those at each depth inside its edge.

    Where a blunt end moves along itself during the exposure its edge is smeared over more than
    the least depth: deeper levels count where, over all frames and on both sides, they stand out
    more from the floor.
    """
    standing = [station_contrast(grey, floor) for grey in greys]
    smeared = standing[1] > (1 + MAX_SMEARING_SHARE) * standing[0]
    return np.where(smeared, greys[1], greys[0])


def _grey_levels_inside_edge(
    frame: Frame, scene: DetectionScene, shape: OutlineArrays, at: tuple[Float, Float]
) -> Float:
    """Grey levels (depths, n) inside the edge found at each point, NaN where none was found.

    at: pose (4,), offsets (n,) [body lengths].
    """
    points, normals, part, _ = shape
    pose, offset_bl = at
    angle = np.where(part == 0, pose[2] - pose[3], pose[2])
    depth = np.nan_to_num(offset_bl) - np.array(INSIDE_DEPTHS_PX)[:, None] / scene.plane.px_per_bl
    place = points + normals * depth[..., None]
    turned = (place[..., 0] + 1j * place[..., 1]) * np.exp(1j * angle) + complex(*pose[:2])
    uv = scene.plane.pixels(np.column_stack([turned.real.ravel(), turned.imag.ravel()]))
    height, width = frame.luma.shape
    ok = (uv > 1).all(axis=1) & (uv[:, 0] < width - 3) & (uv[:, 1] < height - 3)
    ok &= np.isfinite(np.tile(offset_bl, len(INSIDE_DEPTHS_PX)))
    return interpolate_where(frame.luma, uv, ok).reshape(len(INSIDE_DEPTHS_PX), -1)


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
