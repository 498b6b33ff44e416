"""A bending body followed from frame to frame, and the bodies around it, so that none is mistaken.

Every body near the followed one is followed too. What one covers says nothing of the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import cv2
import numpy as np

from ...data import Float, Frame
from ..outline.background import Image
from .blobs import Arena, Blob, Cut, blobs, cut, poses_of
from .curve import ACROSS, JOINTS, MIN_SEEN, Shape, midline
from .learning import fitted
from .track import LOST_FRAMES, Fit, Track

MIN_SUPPORT, SCORE_DROP = 0.5, 0.05
TURN_COST, MOVE_COST = 0.1, 0.1
REACH, REACH_LOST, MAX_REACH = 0.8, 0.25, 2.5
NEIGHBOUR_DISTANCE, SAME_BODY_DISTANCE = 1.3, 0.12
BESIDE_DISTANCE = 1.5
MIN_VISIBLE, MIN_SAME_SCORE, MAX_TURN, MAX_MOVE = 0.5, 0.55, 0.8, 0.4
"""Among several bodies one is the same where a share of more than `MIN_VISIBLE` is seen, its score
is above `MIN_SAME_SCORE`, and it turns and moves less than this between frames [rad, lengths].
"""
NEIGHBOUR_RADIUS = 4.0
HEADINGS, AT_START = 16, 0.12
MIN_COVERAGE = 0.15
NEW_TRACK_SCORE = 0.7


def follow(
    film: Iterable[Frame], arena: Arena, shape: Shape, start_px: Float | None, *, several: bool
) -> tuple[list[float], Track]:
    """Times of all frames and the track of the intended body.

    start_px: (2,) where it is in the first frame; else the body that stands out most is followed.
    several: whether other bodies like it may be in the picture.
    """
    target: Track = Track()
    others: list[Track] = []
    times: list[float] = []
    for frame in film:
        times.append(frame.time_s)
        if target.last() is None:
            target.add(frame.time_s, _first(frame.luma, arena, shape, start_px))
            if several and target.last() is None:
                target.doubtful_s = min(target.doubtful_s, frame.time_s)
        else:
            _step(frame, [target, *others], arena, shape)
            if several:
                _watch(target, others, shape)
        if several and target.last() is not None:
            others = [
                body
                for body in others
                if body.frames_since_seen <= LOST_FRAMES
                and _distance(body, target, shape) < NEIGHBOUR_RADIUS
            ]
            if not target.frames_since_seen:
                others += _born(frame, [target, *others], arena, shape)
    return times, target


def _first(luma: Image, arena: Arena, shape: Shape, start_px: Float | None) -> Fit | None:
    """The body at a place, or the best-fitting one.

    At a place, bodies in all directions are tried beside those of the blobs: it may touch another.
    """
    picture = cut(luma, arena)
    found = [_best(picture, blob, arena, shape) for blob in blobs(picture, arena)]
    good = [one for one in found if one is not None and one.support_score > MIN_SUPPORT]
    if start_px is not None:
        place = arena.plane.body_lengths(start_px[None])[0]
        headings = np.linspace(-math.pi, math.pi, HEADINGS, endpoint=False)
        straight = [np.concatenate([place, [angle], np.zeros(JOINTS)]) for angle in headings]
        tried = [Fit(*fitted(picture, shape, arena, pose)) for pose in straight]
        good += [one for one in tried if one.support_score > MIN_SUPPORT]
        good = [one for one in good if _off_midline(one, place, shape) < AT_START * shape.length_bl]
    return max(good, key=lambda one: one.support_score, default=None)


def _off_midline(one: Fit, place: Float, shape: Shape) -> float:
    """Distance of a place from a body's midline, body lengths."""
    line, _ = midline(one.pose, shape.length_bl, np.linspace(0, 1, 21))
    return float(np.hypot(*(line - place).T).min())


def _best(picture: Cut, blob: Blob, arena: Arena, shape: Shape) -> Fit | None:
    fits = [Fit(*fitted(picture, shape, arena, pose))
            for pose in poses_of(blob, arena.plane, shape.length_bl)]  # fmt: skip
    return max(fits, key=lambda one: one.support_score, default=None)


def _step(frame: Frame, bodies: Sequence[Track], arena: Arena, shape: Shape) -> None:
    """One frame more for each body; twice where bodies are near each other."""
    expected = [body.predicted(frame.time_s) for body in bodies]
    found = [
        _fit(frame.luma, k, bodies, expected, arena=arena, shape=shape) for k in range(len(bodies))
    ]
    if len(bodies) > 1:
        places = [one.pose if one else where for one, where in zip(found, expected, strict=True)]
        near = [_neighbours(k, places, shape) for k in range(len(bodies))]
        found = [
            _fit(frame.luma, k, bodies, places, arena=arena, shape=shape) if near[k] else found[k]
            for k in range(len(bodies))
        ]
    for body, one in zip(bodies, found, strict=True):
        body.add(frame.time_s, one)


def _neighbours(k: int, places: Sequence[Float | None], shape: Shape) -> list[Float]:
    """Poses of the bodies near the k-th."""
    own = places[k]
    return [
        one
        for j, one in enumerate(places)
        if j != k
        and one is not None
        and own is not None
        and np.hypot(*(one - own)[:2]) < NEIGHBOUR_DISTANCE * shape.length_bl
    ]


def _fit(
    luma: Image, k: int, bodies: Sequence[Track], places: Sequence[Float | None], *, arena: Arena,
    shape: Shape,
) -> Fit | None:  # fmt: skip
    """The k-th body's best fit, what the others cover left out."""
    body, expected, last = bodies[k], places[k], bodies[k].last()
    if expected is None or last is None:
        return None
    reach = min(REACH + REACH_LOST * body.frames_since_seen, MAX_REACH) * arena.length_px
    middle = arena.plane.pixels(expected[None, :2])[0]
    picture = cut(luma, arena, middle, reach + 0.5 * arena.length_px)
    near = _neighbours(k, places, shape)
    if near:
        picture = _without(picture, near, arena, shape)
    tried = [Fit(*fitted(picture, shape, arena, expected))]
    if (
        tried[0].support_score < body.typical_score - SCORE_DROP
        or _moved(tried[0], expected) > 0.15 * shape.length_bl
    ):
        starts = [last, *_starts(picture, arena, shape)]
        tried += [Fit(*fitted(picture, shape, arena, pose)) for pose in starts]
    best = max(tried, key=lambda one: _score(one, expected, shape))
    far = _moved(best, expected) > reach / arena.length_px * shape.length_bl
    if far or best.support[3] < MIN_SUPPORT or best.support[4] < MIN_SEEN:
        return None
    best.pose[2] += 2 * math.pi * round((expected[2] - best.pose[2]) / (2 * math.pi))
    return best


def _starts(picture: Cut, arena: Arena, shape: Shape) -> list[Float]:
    """Poses of the blobs that are not two bodies in one."""
    return [
        pose
        for blob in blobs(picture, arena)
        for pose in poses_of(blob, arena.plane, shape.length_bl)
    ]


def _moved(one: Fit, expected: Float) -> float:
    return math.hypot(*(one.pose - expected)[:2])


def _score(one: Fit, expected: Float, shape: Shape) -> float:
    """Support, less for a turn or a move from where it was expected."""
    turn = abs(math.remainder(one.pose[2] - expected[2], 2 * math.pi))
    return (
        one.support_score - TURN_COST * turn - MOVE_COST * _moved(one, expected) / shape.length_bl
    )


def _without(picture: Cut, poses: Sequence[Float], arena: Arena, shape: Shape) -> Cut:
    """The cut with what other bodies cover unknown (NaN depth)."""
    depth = picture.depth.copy()
    row = (shape.cover > MIN_COVERAGE).sum(axis=1) / (ACROSS - 1) * 2 * shape.half_bl
    radius = 0.5 * row * arena.plane.px_per_bl / arena.factor
    kept = np.flatnonzero(radius > 0)
    arc = np.linspace(0, 1, len(row))[kept]
    for pose in poses:
        line, _ = midline(pose, shape.length_bl, arc * 1.28 - 0.14)
        uv = (arena.plane.pixels(line) + 0.5) / picture.place[0] - 0.5 - picture.place[1:]
        for (u, v), size in zip(uv, radius[kept], strict=True):
            cv2.circle(depth, (round(u), round(v)), max(1, round(size)), math.nan, -1)
    return Cut(picture.change, depth, picture.place)


def _distance(one: Track, other: Track, shape: Shape) -> float:
    """Distance of two bodies in whole lengths."""
    a, b = one.last(), other.last()
    if a is None or b is None:
        return math.inf
    return float(np.hypot(*(a - b)[:2])) / shape.length_bl


def _watch(target: Track, others: Sequence[Track], shape: Shape) -> None:
    """Note when the target may have been exchanged for another body.

    That is where, beside another one, it is not surely seen or jumps, or where another body's
    midline lies on its own.
    """
    reach = MAX_REACH if target.frames_since_seen else BESIDE_DISTANCE
    others = [body for body in others if _distance(body, target, shape) < reach]
    if not others:
        return
    one, known = target.fits[-1], [fit for fit in target.fits[-3:-1] if fit is not None]
    sure = (
        one is not None
        and known
        and one.support[4] > MIN_VISIBLE
        and one.support_score > MIN_SAME_SCORE
    )
    if sure and one is not None:
        turn = abs(math.remainder(one.pose[2] - known[-1].pose[2], 2 * math.pi))
        jumped = turn > MAX_TURN or _moved(one, known[-1].pose) > MAX_MOVE * shape.length_bl
        sure = not jumped and not any(_same(one, body, shape) for body in others)
    if not sure:
        target.doubtful_s = min(target.doubtful_s, target.times[-1])


def _same(one: Fit, body: Track, shape: Shape) -> bool:
    """Whether another body's midline lies on this one's."""
    other = body.last()
    if other is None:
        return False
    arc = np.linspace(0.1, 0.7, 5)
    a, _ = midline(one.pose, shape.length_bl, arc)
    b, _ = midline(other, shape.length_bl, arc)
    apart = min(float(np.hypot(*(a - c).T).mean()) for c in (b, b[::-1]))
    return apart < SAME_BODY_DISTANCE * shape.length_bl


def _born(frame: Frame, bodies: Sequence[Track], arena: Arena, shape: Shape) -> list[Track]:
    """Bodies near the first one, which is seen, that are not followed yet."""
    around = bodies[0].last()
    if around is None:
        return []
    middle = arena.plane.pixels(around[None, :2])[0]
    picture = cut(frame.luma, arena, middle, NEIGHBOUR_RADIUS * arena.length_px)
    poses = [pose for body in bodies if (pose := body.last()) is not None]
    free = _without(picture, poses, arena, shape)
    free.change[np.isnan(free.depth)] = 0.0
    new = []
    for blob in blobs(Cut(free.change, picture.depth, free.place), arena):
        one = _best(picture, blob, arena, shape)
        if one is not None and one.support_score > NEW_TRACK_SCORE:
            track = Track()
            track.add(frame.time_s, one)
            new.append(track)
    return new
