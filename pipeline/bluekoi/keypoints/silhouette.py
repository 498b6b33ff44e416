"""Keypoints from a template of the robot fitted to its outline: a rigid head and core, a tail.

A background from a few pictures; the outline's half-widths learned from the same pictures; then,
frame by frame, the template fitted to the edges from where the robot is expected.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from ..data import BODY_PART_NAMES, Frame, Keypoints, SeekableFilm, is_confident
from ..errors import input_error
from ..study import StudySettings, Trial
from . import NO_ROBOT_REMARK
from .midline import detection as midline
from .outline.background import median_image, noise_level, sample_frames, without_static_robot
from .outline.camera_motion import camera_motion_remarks
from .outline.ghost_removal import background_without_robot
from .outline.learning import LearnedTemplate, learn_template, relearned_template
from .outline.movement_check import frames_change_where_body_moved
from .outline.plane import SwimmingPlaneMap, metres_to_body_lengths, swimming_plane_map
from .outline.robot_not_found import robot_not_found_reason
from .outline.second_body import second_body_remark
from .outline.template import robot_length_bl
from .outline.to_keypoints import keypoints_from_fits
from .outline.tracking import DetectionScene, OutlineFit, track_robot

USES_STATED_LENGTHS = True
"""Keypoints lie at the robot's lengths of study.yaml: their distances measure nothing. What is
measured is the whole length (`Keypoints.length_seen`)."""
SCENE_SAMPLE_FRAME_COUNTS, MAX_KEY_FRAMES_SAMPLED = (5, 15), 8
"""Frames from which background and outline are learned: at least 5, up to 8 where the video has so
many key frames; 15 where these do not do. The outline's error is that of a mean over them."""
SUFFICIENT_TEMPLATE_SUPPORT = 0.9
MIN_TEMPLATE_SUPPORT_SCORE = 0.6
MIN_SUPPORT_FOR_GHOST_REMOVAL = 0.4
GHOST_REMOVAL_ROUNDS = 2
MIN_RIGID_FRAMES_SHARE = 0.9
"""A body counts as bending only if the rigid template fits a smaller share of the frames."""


def detect_keypoints(
    frames: Callable[[], Iterable[Frame]], setup: StudySettings, trial: Trial
) -> Keypoints:
    """Keypoints head_tip, hinge, core_center, tail_base, tail_tip of every frame, in pixels.

    Likelihood is the share of the outline found where the template has it, graded; covariances
    come from how neighbouring stretches of outline disagree. Where the robot is not found: NaN
    and likelihood 0.

    Raises: InputError where the footage holds no frame.
    """
    plane = swimming_plane_map(setup)
    again = _repeatable_frame_source(frames)
    samples = sample_frames(again(), SCENE_SAMPLE_FRAME_COUNTS[0], MAX_KEY_FRAMES_SAMPLED)
    if not samples:
        raise input_error(trial.source, "", "no frames", "footage with frames")
    if setup.detection.body == "bending":
        return _detect_bending_body(again, plane, setup, trial) or _empty_keypoints(
            [frame.time_s for frame in again()], (_no_robot_remark(samples, plane, setup, trial),)
        )
    found = _detect_rigid_body(again, samples, plane, setup=setup, trial=trial)
    if setup.detection.body == "auto" and _confident_frames_share(found) < MIN_RIGID_FRAMES_SHARE:
        bending = _detect_bending_body(again, plane, setup, trial)
        return (
            found
            if bending is None or _confident_frames_share(bending) < _confident_frames_share(found)
            else bending
        )
    return found


def _detect_rigid_body(
    frames: Callable[[], Iterable[Frame]],
    samples: Sequence[Frame],
    plane: SwimmingPlaneMap,
    *,
    setup: StudySettings,
    trial: Trial,
) -> Keypoints:
    """Keypoints of a rigid head and core with a tail."""
    with _decode_in_background(frames()) as film:
        scene, outline, remarks = learn_scene_and_template(frames, samples, plane, setup, trial)
        if outline is None:
            times = [frame.time_s for frame in film]
            return _empty_keypoints(
                times, (*remarks, _no_robot_remark(samples, plane, setup, trial))
            )
        second = second_body_remark(  # while the film is decoded
            outline,
            scene,
            robot_length_bl(setup.robot, trial),
            start_is_known=trial.start_px is not None,
        )
        times, fits = track_robot(film, scene, outline.template, trial.start_px)
    if not times:
        raise input_error(trial.source, "", "no frames", "frames between start_s and end_s")
    remarks = (
        *remarks,
        *second,
        *_missing_frames_remark(times, fits),
        *_no_robot_at_start_remark(fits, trial),
    )
    return keypoints_from_fits(times, fits, scene, outline.template, remarks)


def _no_robot_remark(
    samples: Sequence[Frame], plane: SwimmingPlaneMap, setup: StudySettings, trial: Trial
) -> str:
    """The remark where nothing was found."""
    images = [frame.luma for frame in samples]
    reason = robot_not_found_reason(
        images,
        plane,
        robot_length_bl(setup.robot, trial),
        bending=setup.detection.body == "bending",
    )
    return NO_ROBOT_REMARK + reason


def _confident_frames_share(found: Keypoints) -> float:
    """Share of the frames in which all points are likely."""
    return float(np.mean(is_confident(found.likelihood).all(axis=1)))


def _detect_bending_body(
    frames: Callable[[], Iterable[Frame]],
    plane: SwimmingPlaneMap,
    setup: StudySettings,
    trial: Trial,
) -> Keypoints | None:
    """Keypoints of a bending body; None without one, or where it is not seen to bend."""
    samples = sample_frames(frames(), midline.SAMPLE_FRAMES)
    body = midline.learn_body(samples, plane, setup.robot, trial)
    if body is None or not (body.is_core_bending or setup.detection.body == "bending"):
        return None
    found = midline.detect_keypoints(frames(), body, setup.robot, trial)
    return replace(found, remarks=(*camera_motion_remarks(samples, plane), *found.remarks))


@contextmanager
def _decode_in_background(film: Iterable[Frame]) -> Iterator[Iterable[Frame]]:
    """The film, decoded in the background where it can be, while the template is learned."""
    if isinstance(film, SeekableFilm):
        with film.prefetched() as frames:
            yield frames
    else:
        yield film


def _repeatable_frame_source(
    frames: Callable[[], Iterable[Frame]],
) -> Callable[[], Iterable[Frame]]:
    """`frames`, called once only if what it gives can be run through again and again."""
    first = frames()
    return (lambda: first) if isinstance(first, SeekableFilm) else frames


def learn_scene_and_template(
    frames: Callable[[], Iterable[Frame]],
    samples: Sequence[Frame],
    plane: SwimmingPlaneMap,
    setup: StudySettings,
    trial: Trial,
) -> tuple[DetectionScene, LearnedTemplate | None, tuple[str, ...]]:
    """Scene and learned template: from the first few samples, from more where these do not do.

    At last from a background bridged at the robot's resting place.
    """
    found: list[tuple[DetectionScene, LearnedTemplate | None]] = []
    notes: tuple[str, ...] = ()
    for count in SCENE_SAMPLE_FRAME_COUNTS:
        samples = (
            samples if count == SCENE_SAMPLE_FRAME_COUNTS[0] else sample_frames(frames(), count)
        )
        found.append(_scene_and_template(samples, plane, setup, trial))
        notes = camera_motion_remarks(samples, plane)
        outline = found[-1][1]
        if (
            outline is not None
            and outline.support > SUFFICIENT_TEMPLATE_SUPPORT
            and 2 * outline.learning_frame_count > len(samples)
        ):
            return *found[-1], notes
    best = max(found, key=lambda one: _support_score(one[1]))
    if _support_score(best[1]) < MIN_TEMPLATE_SUPPORT_SCORE:
        size = metres_to_body_lengths(setup.robot, setup.robot.head_span_m) * plane.px_per_bl
        bridged = replace(found[-1][0], floor=without_static_robot(found[-1][0].floor, size))
        second = learn_template(samples, bridged, setup.robot, trial)
        if (
            second is not None
            and second.support_score > MIN_TEMPLATE_SUPPORT_SCORE
            and frames_change_where_body_moved(second, bridged)
        ):
            remark = "the robot hardly left its place: its background was bridged from around it"
            return bridged, second, (*notes, remark)
        return best[0], None, notes
    return *best, notes


def _scene_and_template(
    samples: Sequence[Frame], plane: SwimmingPlaneMap, setup: StudySettings, trial: Trial
) -> tuple[DetectionScene, LearnedTemplate | None]:
    """Scene of a few frames' median and the template learned from them."""
    images = [frame.luma for frame in samples]
    floor = median_image(images)
    scene = DetectionScene(floor, plane, noise_level(images, floor), trial.head_angle_rad)
    outline = learn_template(samples, scene, setup.robot, trial)
    for _ in range(GHOST_REMOVAL_ROUNDS):
        if outline is None or outline.support <= MIN_SUPPORT_FOR_GHOST_REMOVAL:
            break
        free = background_without_robot(outline, scene)
        if free is None:
            break
        scene = replace(scene, floor=free)
        outline = relearned_template(outline, samples, scene, setup.robot, trial)
    return scene, outline


def _support_score(outline: LearnedTemplate | None) -> float:
    return 0.0 if outline is None else outline.support_score


def _no_robot_at_start_remark(fits: Sequence[OutlineFit | None], trial: Trial) -> tuple[str, ...]:
    """A remark if no robot was found at the stated start."""
    if trial.start_px is None or any(fits):
        return ()
    u, v = trial.start_px
    text = f"none at start_x_px {u:g}, start_y_px {v:g} in the first frames"
    return (NO_ROBOT_REMARK + text,)


def _missing_frames_remark(
    times: Sequence[float], fits: Sequence[OutlineFit | None]
) -> tuple[str, ...]:
    """A remark on the frames without a robot."""
    gone = [time for time, one in zip(times, fits, strict=True) if one is None]
    if not gone:
        return ()
    text = f"{len(gone)} of {len(times)} frames without the robot (first at {gone[0]:.2f} s)"
    return (text,)


def _empty_keypoints(times: Sequence[float], remarks: tuple[str, ...]) -> Keypoints:
    n, p = len(times), len(BODY_PART_NAMES)
    return Keypoints(
        np.array(times),
        BODY_PART_NAMES,
        np.full((n, p, 2), np.nan),
        np.zeros((n, p)),
        np.full((n, p, 2, 2), np.nan),
        remarks,
    )
