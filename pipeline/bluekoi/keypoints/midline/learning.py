"""Template of a bending body, learned from a few frames spread over the recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...data import Float
from ..outline.background import LumaPicture
from ..outline.template import nan_median
from .blobs import (
    BackgroundDifferenceCrop,
    BackgroundModel,
    Blob,
    background_difference_crop,
    candidate_poses,
    find_blobs,
    pose_from_midline,
)
from .midline_fit import (
    ARC_MARGIN,
    STATIONS_ACROSS,
    STATIONS_ALONG,
    BendingTemplate,
    fit_midline_pose,
    midline,
    station_arcs,
    station_positions,
    straightened_image,
)

LEARNING_ROUNDS = 4
MAX_TRAINING_BLOBS = 40
TYPICAL_BLOB_LENGTH_RATIO_RANGE = (0.7, 1.3)
MIN_LEARNING_SUPPORT_SHARE = 0.5
TAIL_ARC_RANGE = (0.75, 0.9)


def learn_template(
    samples: Sequence[LumaPicture], arena: BackgroundModel
) -> tuple[BendingTemplate, Float, Float] | None:
    """Template learned from the bodies in some frames, with their poses and support; else None.

    All similar bodies of a frame are used, as they have the same shape.
    """
    seen = [
        (picture, blob)
        for luma in samples
        for picture in [background_difference_crop(luma, arena)]
        for blob in find_blobs(picture, arena)
    ]
    seen = _typical_blobs(seen)[:MAX_TRAINING_BLOBS]
    if len(seen) < 2:
        return None
    px_per_bl = arena.plane.px_per_bl
    length = float(np.median([blob.length for _, blob in seen])) / px_per_bl
    area = float(np.median([blob.area for _, blob in seen])) / px_per_bl**2
    half = 1.1 * area / length + 1.5 * arena.factor / px_per_bl
    shape = BendingTemplate(length, half, np.zeros((STATIONS_ALONG, STATIONS_ACROSS)), arena.skin)
    pairs = [(p, poses[0]) for p, b in seen if (poses := candidate_poses(b, arena.plane, length))]
    shape = _template_with_median_coverage(shape, pairs, arena)
    for turn in range(LEARNING_ROUNDS):
        fits = [(p, *_best_fit(p, shape, arena, pose, turned=turn == 0)) for p, pose in pairs]
        pairs = [(p, pose) for p, pose, support in fits if support > MIN_LEARNING_SUPPORT_SHARE]
        if len(pairs) < 2:
            return None
        shape = _template_with_median_coverage(shape, pairs, arena)
        if turn < LEARNING_ROUNDS - 1:
            shape, pairs = _rescale_to_body_ends(shape, pairs, arena)
    last = [fit_to_image(picture, shape, arena, pose) for picture, pose in pairs]
    return shape, np.array([one[0] for one in last]), np.array([one[3][3] for one in last])


def _best_fit(
    picture: BackgroundDifferenceCrop,
    shape: BendingTemplate,
    arena: BackgroundModel,
    pose: Float,
    *,
    turned: bool,
) -> tuple[Float, float]:
    """Pose and support of the best fit from a pose, either way round if `turned`."""
    starts = [pose, reversed_pose(pose, shape)] if turned else [pose]
    found = [fit_to_image(picture, shape, arena, start) for start in starts]
    best = max(found, key=lambda one: float(one[3][3]) + 0.5 * max(float(one[3][:3].min()), -1.0))
    return best[0], float(best[3][3])


def reversed_pose(pose: Float, shape: BendingTemplate) -> Float:
    """The pose with nose and tail exchanged."""
    line, _ = midline(pose, shape.length_bl, np.linspace(1, 0, STATIONS_ALONG))
    return pose_from_midline(line, shape.length_bl)


def _rescale_to_body_ends(
    shape: BendingTemplate,
    pairs: Sequence[tuple[BackgroundDifferenceCrop, Float]],
    arena: BackgroundModel,
) -> tuple[BendingTemplate, list[tuple[BackgroundDifferenceCrop, Float]]]:
    """The shape with nose and tail tip at arcs 0 and 1, and the poses that go with it."""
    nose, tip = _nose_and_tail_arcs(shape.cover)
    length = shape.length_bl * (tip - nose)
    arc = np.linspace(nose, tip, STATIONS_ALONG)
    poses = [pose_from_midline(midline(pose, shape.length_bl, arc)[0], length) for _, pose in pairs]
    renewed = [(picture, pose) for (picture, _), pose in zip(pairs, poses, strict=True)]
    return _template_with_median_coverage(replace(shape, length_bl=length), renewed, arena), renewed


def _typical_blobs(
    seen: list[tuple[BackgroundDifferenceCrop, Blob]],
) -> list[tuple[BackgroundDifferenceCrop, Blob]]:
    """Those of the usual length and thickness, spread over the pictures."""
    if not seen:
        return []
    length, area = (float(np.median([getattr(b, name) for _, b in seen]))
                    for name in ("length", "area"))  # fmt: skip
    kept = [
        (p, b)
        for p, b in seen
        if TYPICAL_BLOB_LENGTH_RATIO_RANGE[0]
        < b.length / length
        < TYPICAL_BLOB_LENGTH_RATIO_RANGE[1]
        and 0.6 < b.area / area < 1.5
    ]
    step = max(1, -(-len(kept) // MAX_TRAINING_BLOBS))
    return kept[::step]


def fit_to_image(
    picture: BackgroundDifferenceCrop, shape: BendingTemplate, arena: BackgroundModel, pose: Float
) -> tuple[Float, Float, Float, Float]:
    """`fit_midline_pose` of a template to a reduced image."""
    plane = arena.plane
    seen = (picture.change, picture.depth, (plane.to_px, plane.scale_bl, picture.place))
    tolerance = max(3.0 * arena.noise, 0.3 * arena.median_contrast)
    return fit_midline_pose(
        seen, shape.basis_coverage_and_slopes, shape.length_and_half_width, pose, tolerance
    )


def _template_with_median_coverage(
    shape: BendingTemplate,
    fits: Sequence[tuple[BackgroundDifferenceCrop, Float]],
    arena: BackgroundModel,
) -> BendingTemplate:
    """Shape whose coverage is the median over fits and both sides."""
    bend, *_ = shape.basis_coverage_and_slopes
    plane, covers = arena.plane, []
    for picture, pose in fits:
        seen = (picture.change, picture.depth, (plane.to_px, plane.scale_bl, picture.place))
        line = station_positions(pose, shape.length_and_half_width, bend)
        change, depth = straightened_image(seen, pose, line, shape.length_and_half_width)
        cover = np.where(depth > arena.level, change / np.maximum(depth, arena.level), np.nan)
        covers += [cover, cover[:, ::-1]]
    cover = np.nan_to_num(nan_median(np.array(covers)))
    cover = np.clip(cover - np.median(cover[[0, -1]]), 0.0, 1.2)
    edge = np.abs(np.linspace(-1, 1, STATIONS_ACROSS))
    return replace(shape, cover=cover * np.clip(6 * (1 - edge), 0, 1))


def _nose_and_tail_arcs(cover: Float) -> tuple[float, float]:
    """Arcs of nose and tail tip: half the coverage on the axis of the head, of the tail."""
    arc, middle = station_arcs(), STATIONS_ACROSS // 2
    axis = cover[:, middle - 1 : middle + 2].mean(axis=1)
    head = 0.5 * float(axis[: STATIONS_ALONG // 2].max())
    tail = 0.5 * float(axis[(arc > TAIL_ARC_RANGE[0]) & (arc < TAIL_ARC_RANGE[1])].mean())
    front = int(np.argmax(axis > head))
    rear = STATIONS_ALONG - 1 - int(np.argmax(axis[::-1] > tail))
    nose = _level_crossing_arc(arc, axis, front - 1, head) if front else -ARC_MARGIN
    tip = (
        _level_crossing_arc(arc, axis, rear, tail) if rear < STATIONS_ALONG - 1 else 1 + ARC_MARGIN
    )
    return nose, tip


def _level_crossing_arc(arc: Float, values: Float, k: int, level: float) -> float:
    share = (level - values[k]) / (values[k + 1] - values[k])
    return float(arc[k] + share * (arc[k + 1] - arc[k]))
