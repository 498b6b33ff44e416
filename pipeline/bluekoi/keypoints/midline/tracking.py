"""Tracking of a bending body from frame to frame, together with all bodies near it.

Neighbouring bodies are tracked too, so that the target is not exchanged for one of them. Pixels
that one body covers are left out of the fit of another.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import cv2
import numpy as np

from ...data import Float, Frame
from ..outline.background import LumaPicture
from ..outline.target_body import START_TOLERANCE_LENGTHS, search_radius_lengths
from .blobs import (
    BackgroundDifferenceCrop,
    BackgroundModel,
    Blob,
    background_difference_crop,
    candidate_poses,
    find_blobs,
)
from .identity import (
    body_distance,
    record_doubtful_jump,
    record_possible_identity_swap,
)
from .learning import fit_to_image
from .midline_fit import BEND_TERMS, MIN_SEEN_SHARE, STATIONS_ACROSS, BendingTemplate, midline
from .track import LOST_AFTER_FRAMES, BodyFitHistory, MidlineFit

MIN_SUPPORT, MAX_SCORE_DROP = 0.5, 0.05
TURN_COST_PER_RAD, MOVE_COST_PER_LENGTH = 0.1, 0.1
TOUCHING_BODIES_DISTANCE_LENGTHS = 1.3
"""Distance within which two bodies may touch; each is fitted again with the other one masked."""
OTHER_BODIES_TRACKED_WITHIN_LENGTHS = 4.0
"""Distance from the target within which other bodies are followed too."""
INITIAL_HEADING_COUNT = 16
MIN_COVERAGE_TO_MASK = 0.15
MIN_NEW_TRACK_SCORE = 0.7


def track_body(
    film: Iterable[Frame],
    arena: BackgroundModel,
    shape: BendingTemplate,
    start_px: Float | None,
    *,
    several: bool,
) -> tuple[list[float], BodyFitHistory]:
    """Times (s) of all frames, and the track of the target body.

    start_px: (2,) position in the first frame; without it, the best-fitting body is the target.
    several: whether similar bodies may be in the picture.
    """
    target: BodyFitHistory = BodyFitHistory()
    others: list[BodyFitHistory] = []
    times: list[float] = []
    for frame in film:
        times.append(frame.time_s)
        if target.last_seen_pose() is None:
            target.append_frame(frame.time_s, _first_fit(frame.luma, arena, shape, start_px))
            if several and target.last_seen_pose() is None:
                target.doubtful_s = min(target.doubtful_s, frame.time_s)
        else:
            _track_next_frame(frame, [target, *others], arena, shape)
            if several:
                record_possible_identity_swap(target, others, shape)
            else:
                record_doubtful_jump(target, shape)
        if several and target.last_seen_pose() is not None:
            others = [
                body
                for body in others
                if body.frames_since_seen <= LOST_AFTER_FRAMES
                and body_distance(body, target, shape) < OTHER_BODIES_TRACKED_WITHIN_LENGTHS
            ]
            if not target.frames_since_seen:
                others += _new_tracks(frame, [target, *others], arena, shape)
    return times, target


def _first_fit(
    luma: LumaPicture, arena: BackgroundModel, shape: BendingTemplate, start_px: Float | None
) -> MidlineFit | None:
    """The body at `start_px`, or else the best-fitting one.

    At `start_px`, straight bodies with all headings are tried beside the poses of the blobs,
    because a blob may consist of two bodies that touch.
    """
    picture = background_difference_crop(luma, arena)
    found = [_best_fit_to_blob(picture, blob, arena, shape) for blob in find_blobs(picture, arena)]
    good = [one for one in found if one is not None and one.support_score > MIN_SUPPORT]
    if start_px is not None:
        place = arena.plane.pixels_to_body_lengths(start_px[None])[0]
        headings = np.linspace(-math.pi, math.pi, INITIAL_HEADING_COUNT, endpoint=False)
        straight = [np.concatenate([place, [angle], np.zeros(BEND_TERMS)]) for angle in headings]
        tried = [MidlineFit(*fit_to_image(picture, shape, arena, pose)) for pose in straight]
        good += [one for one in tried if one.support_score > MIN_SUPPORT]
        good = [
            one
            for one in good
            if _distance_to_midline_bl(one, place, shape)
            < START_TOLERANCE_LENGTHS * shape.length_bl
        ]
    return max(good, key=lambda one: one.support_score, default=None)


def _distance_to_midline_bl(one: MidlineFit, place: Float, shape: BendingTemplate) -> float:
    """Distance of a place from a body's midline, body lengths."""
    line, _ = midline(one.pose, shape.length_bl, np.linspace(0, 1, 21))
    return float(np.hypot(*(line - place).T).min())


def _best_fit_to_blob(
    picture: BackgroundDifferenceCrop, blob: Blob, arena: BackgroundModel, shape: BendingTemplate
) -> MidlineFit | None:
    fits = [MidlineFit(*fit_to_image(picture, shape, arena, pose))
            for pose in candidate_poses(blob, arena.plane, shape.length_bl)]  # fmt: skip
    return max(fits, key=lambda one: one.support_score, default=None)


def _track_next_frame(
    frame: Frame, bodies: Sequence[BodyFitHistory], arena: BackgroundModel, shape: BendingTemplate
) -> None:
    """Fit all bodies to the next frame; a second time if bodies are near each other."""
    expected = [body.predicted_pose(frame.time_s) for body in bodies]
    found = [
        _fit_body(frame.luma, k, bodies, expected, arena=arena, shape=shape)
        for k in range(len(bodies))
    ]
    if len(bodies) > 1:
        places = [one.pose if one else where for one, where in zip(found, expected, strict=True)]
        near = [_neighbour_poses(k, places, shape) for k in range(len(bodies))]
        found = [
            _fit_body(frame.luma, k, bodies, places, arena=arena, shape=shape)
            if near[k]
            else found[k]
            for k in range(len(bodies))
        ]
    for body, one in zip(bodies, found, strict=True):
        body.append_frame(frame.time_s, one)


def _neighbour_poses(k: int, places: Sequence[Float | None], shape: BendingTemplate) -> list[Float]:
    """Poses of the bodies near the k-th."""
    own = places[k]
    return [
        one
        for j, one in enumerate(places)
        if j != k
        and one is not None
        and own is not None
        and np.hypot(*(one - own)[:2]) < TOUCHING_BODIES_DISTANCE_LENGTHS * shape.length_bl
    ]


def _fit_body(
    luma: LumaPicture,
    k: int,
    bodies: Sequence[BodyFitHistory],
    places: Sequence[Float | None],
    *,
    arena: BackgroundModel,
    shape: BendingTemplate,
) -> MidlineFit | None:
    """The k-th body's best fit, without the pixels that other bodies cover."""
    body, expected, last = bodies[k], places[k], bodies[k].last_seen_pose()
    if expected is None or last is None:
        return None
    reach = search_radius_lengths(body.frames_since_seen) * arena.length_px
    middle = arena.plane.body_lengths_to_pixels(expected[None, :2])[0]
    picture = background_difference_crop(luma, arena, middle, reach + 0.5 * arena.length_px)
    near = _neighbour_poses(k, places, shape)
    if near:
        picture = _mask_other_bodies(picture, near, arena, shape)
    tried = [MidlineFit(*fit_to_image(picture, shape, arena, expected))]
    if (
        tried[0].support_score < body.typical_score - MAX_SCORE_DROP
        or _distance_from_expected_bl(tried[0], expected) > 0.15 * shape.length_bl
    ):
        starts = [last, *_starting_poses(picture, arena, shape)]
        tried += [MidlineFit(*fit_to_image(picture, shape, arena, pose)) for pose in starts]
    best = max(tried, key=lambda one: _penalised_score(one, expected, shape))
    far = _distance_from_expected_bl(best, expected) > reach / arena.length_px * shape.length_bl
    if far or best.support[3] < MIN_SUPPORT or best.support[4] < MIN_SEEN_SHARE:
        return None
    best.pose[2] += 2 * math.pi * round((expected[2] - best.pose[2]) / (2 * math.pi))
    return best


def _starting_poses(
    picture: BackgroundDifferenceCrop, arena: BackgroundModel, shape: BendingTemplate
) -> list[Float]:
    """Starting poses from the blobs of a body's size."""
    return [
        pose
        for blob in find_blobs(picture, arena)
        for pose in candidate_poses(blob, arena.plane, shape.length_bl)
    ]


def _distance_from_expected_bl(one: MidlineFit, expected: Float) -> float:
    return math.hypot(*(one.pose - expected)[:2])


def _penalised_score(one: MidlineFit, expected: Float, shape: BendingTemplate) -> float:
    """Support score minus penalties for a turn and a move away from the expected pose."""
    turn = abs(math.remainder(one.pose[2] - expected[2], 2 * math.pi))
    return (
        one.support_score
        - TURN_COST_PER_RAD * turn
        - MOVE_COST_PER_LENGTH * _distance_from_expected_bl(one, expected) / shape.length_bl
    )


def _mask_other_bodies(
    picture: BackgroundDifferenceCrop,
    poses: Sequence[Float],
    arena: BackgroundModel,
    shape: BendingTemplate,
) -> BackgroundDifferenceCrop:
    """The reduced image; pixels that other bodies cover get depth NaN."""
    depth = picture.depth.copy()
    row = (
        (shape.cover > MIN_COVERAGE_TO_MASK).sum(axis=1) / (STATIONS_ACROSS - 1) * 2 * shape.half_bl
    )
    radius = 0.5 * row * arena.plane.px_per_bl / arena.factor
    kept = np.flatnonzero(radius > 0)
    arc = np.linspace(0, 1, len(row))[kept]
    for pose in poses:
        line, _ = midline(pose, shape.length_bl, arc * 1.28 - 0.14)
        uv = (
            (arena.plane.body_lengths_to_pixels(line) + 0.5) / picture.place[0]
            - 0.5
            - picture.place[1:]
        )
        for (u, v), size in zip(uv, radius[kept], strict=True):
            cv2.circle(depth, (round(u), round(v)), max(1, round(size)), math.nan, -1)
    return BackgroundDifferenceCrop(picture.change, depth, picture.place)


def _new_tracks(
    frame: Frame, bodies: Sequence[BodyFitHistory], arena: BackgroundModel, shape: BendingTemplate
) -> list[BodyFitHistory]:
    """Bodies near the first one, which is seen, that are not followed yet."""
    around = bodies[0].last_seen_pose()
    if around is None:
        return []
    middle = arena.plane.body_lengths_to_pixels(around[None, :2])[0]
    picture = background_difference_crop(
        frame.luma, arena, middle, OTHER_BODIES_TRACKED_WITHIN_LENGTHS * arena.length_px
    )
    poses = [pose for body in bodies if (pose := body.last_seen_pose()) is not None]
    free = _mask_other_bodies(picture, poses, arena, shape)
    free.change[np.isnan(free.depth)] = 0.0
    new = []
    for blob in find_blobs(BackgroundDifferenceCrop(free.change, picture.depth, free.place), arena):
        one = _best_fit_to_blob(picture, blob, arena, shape)
        if one is not None and one.support_score > MIN_NEW_TRACK_SCORE:
            track = BodyFitHistory()
            track.append_frame(frame.time_s, one)
            new.append(track)
    return new
