"""Keypoints of the robot from its outline against the pool: a rigid head, a rigid core, a tail.

A background from a few pictures; the outline's half-widths learned from the same pictures; then,
frame by frame, the template fitted to the edges from where the robot is expected.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from ..data import PARTS, Frame, Keypoints
from ..faults import fault
from ..study import Setup, Trial
from .outline.alike import alike_remark
from .outline.background import median, noise_level, sample, without_resident
from .outline.clearing import cleared
from .outline.learning import Lesson, learn
from .outline.outcome import keypoints_of
from .outline.plane import Plane, plane_of
from .outline.steadiness import camera_remarks
from .outline.tracking import Fit, Scene, follow

LENGTHS_STATED = True
"""Keypoints lie at the robot's lengths of study.yaml: their distances measure nothing. What is
measured is the whole length (`Keypoints.length_seen`)."""
SAMPLES = (5, 15)
WELL = 0.9
TAUGHT = 0.6
HALF_TAUGHT = 0.4
CLEARINGS = 2


def detect(frames: Callable[[], Iterable[Frame]], setup: Setup, trial: Trial) -> Keypoints:
    """Keypoints head_tip, hinge, core_center, tail_base, tail_tip of every frame, in pixels.

    Likelihood is the share of the outline found where the template has it, graded; covariances
    come from how neighbouring stretches of outline disagree. Where the robot is not found: NaN
    and likelihood 0.

    Raises: Fault where the footage holds no frame.
    """
    plane = plane_of(setup)
    again = _kept(frames)
    samples = sample(again(), SAMPLES[0])
    if not samples:
        raise fault(trial.source, "", "no frames", "footage with frames")
    with _begun(again()) as film:
        scene, lesson, remarks = taught(again, samples, plane, setup, trial)
        if lesson is None:
            times = [frame.time_s for frame in film]
            return _nothing(times, (*remarks, "no robot was found against the background"))
        times, fits = follow(film, scene, lesson.template)
    if not times:
        raise fault(trial.source, "", "no frames", "frames between start_s and end_s")
    remarks = (*remarks, *alike_remark(lesson, scene), *_lost(times, fits))
    return keypoints_of(times, fits, scene, lesson.template, remarks)


@contextmanager
def _begun(film: Iterable[Frame]) -> Iterator[Iterable[Frame]]:
    """The film, its decoding begun where it can be: it goes on while the template is learned."""
    ahead = getattr(film, "ahead", None)
    if ahead is None:
        yield film
    else:
        with ahead() as begun:
            yield begun


def _kept(frames: Callable[[], Iterable[Frame]]) -> Callable[[], Iterable[Frame]]:
    """`frames`, called once only if what it gives can be run through again and again."""
    first = frames()
    return (lambda: first) if hasattr(first, "spread") else frames


def taught(
    frames: Callable[[], Iterable[Frame]],
    samples: Sequence[Frame],
    plane: Plane,
    setup: Setup,
    trial: Trial,
) -> tuple[Scene, Lesson | None, tuple[str, ...]]:
    """Scene and learned template: from the first few samples, from more where these do not do.

    At last from a background bridged at the robot's resting place.
    """
    found: list[tuple[Scene, Lesson | None]] = []
    notes: tuple[str, ...] = ()
    for count in SAMPLES:
        samples = samples if count == SAMPLES[0] else sample(frames(), count)
        found.append(_lesson(samples, plane, setup, trial))
        notes = camera_remarks(samples, plane)
        lesson = found[-1][1]
        if lesson is not None and lesson.support > WELL and 2 * lesson.frames > len(samples):
            return *found[-1], notes
    best = max(found, key=lambda one: _worth(one[1]))
    if _worth(best[1]) < TAUGHT:
        size = setup.robot.head_span_m * plane.px_per_m
        bridged = replace(found[-1][0], floor=without_resident(found[-1][0].floor, size))
        second = learn(samples, bridged, setup.robot, trial)
        if _worth(second) > TAUGHT:
            remark = "the robot hardly left its place: its background was bridged from around it"
            return bridged, second, (*notes, remark)
        return best[0], None, notes
    return *best, notes


def _lesson(
    samples: Sequence[Frame], plane: Plane, setup: Setup, trial: Trial
) -> tuple[Scene, Lesson | None]:
    """Scene of a few frames' median and the template that they teach."""
    images = [frame.luma for frame in samples]
    floor = median(images)
    scene = Scene(floor, plane, noise_level(images, floor), trial.head_angle_rad)
    lesson = learn(samples, scene, setup.robot, trial)
    for _ in range(CLEARINGS):
        free = cleared(lesson, scene) if lesson and lesson.support > HALF_TAUGHT else None
        if free is None:
            break
        scene = replace(scene, floor=free)
        lesson = learn(samples, scene, setup.robot, trial) or lesson
    return scene, lesson


def _worth(lesson: Lesson | None) -> float:
    return 0.0 if lesson is None else lesson.worth


def _lost(times: Sequence[float], fits: Sequence[Fit | None]) -> tuple[str, ...]:
    """A remark on the frames without a robot."""
    gone = [time for time, one in zip(times, fits, strict=True) if one is None]
    if not gone:
        return ()
    text = f"{len(gone)} of {len(times)} frames without the robot (first at {gone[0]:.2f} s)"
    return (text,)


def _nothing(times: Sequence[float], remarks: tuple[str, ...]) -> Keypoints:
    n, p = len(times), len(PARTS)
    return Keypoints(
        np.array(times),
        PARTS,
        np.full((n, p, 2), np.nan),
        np.zeros((n, p)),
        np.full((n, p, 2, 2), np.nan),
        remarks,
    )
