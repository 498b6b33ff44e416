"""The robot's own outline, learned from a few frames spread over the recording."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...data import Float, Frame
from ...study import Robot, Trial
from .blob_detection import Blob, candidate_poses, find_blobs
from .outline_stations import measure_stations, picture_blur_px, without_biased_stations
from .template import OutlineTemplate, initial_template, robot_length_bl, with_learned_outline
from .tracking import (
    DetectionScene,
    OutlineFit,
    edge_search_ranges_px,
    fit_template_to_frame,
    is_plausible_blob,
)

LEARNING_EDGE_SEARCH_RANGES_BL = (0.048, 0.036, 0.030, 0.024, 0.024, 0.024)
RELEARNING_STEPS = 3
"""Number of these steps, from the last, for a template that was learned in a similar scene."""
AREA_PER_LENGTH_SQUARED = 0.16
SUFFICIENT_EDGE_SUPPORT = 0.9
MAX_LEARNED_HEAD_ANGLE_DEVIATION_RAD = 0.15
START_OFFSETS_ALONG_BODY_BL = ((0.0,), (-0.09, 0.0, 0.09), (-0.15, -0.075, 0.0, 0.075, 0.15))


@dataclass(frozen=True)
class LearnedTemplate:
    """A learned template, the frames it was learned from with their fits, how well it fits them."""

    template: OutlineTemplate
    samples: tuple[tuple[Frame, OutlineFit], ...]
    support: float

    @property
    def learning_frame_count(self) -> int:
        """How many frames it was learned from."""
        return len(self.samples)

    @property
    def support_score(self) -> float:
        """Support, less where it was learned from fewer than three frames."""
        return self.support * min(self.learning_frame_count, 3) / 3


def learn_template(
    samples: Sequence[Frame], scene: DetectionScene, robot: Robot, trial: Trial
) -> LearnedTemplate | None:
    """Template learned from the samples in which a robot-like blob is found; None without any.

    Fit, move each station by its median offset over frames and both sides, fit again; where that
    does not settle, look for the robot again with the width, grey level and core learned, all
    along each blob, and learn from the frames that agree best. The best outline counts.
    """
    length_bl = robot_length_bl(robot, trial)
    seen = [(f, robot_sized_blobs(f, scene, length_bl)) for f in samples]
    first = _template_from_blobs(seen, robot, trial)
    if first is None:
        return None
    candidates: list[LearnedTemplate] = []
    for slides in START_OFFSETS_ALONG_BODY_BL:
        known = generic_template(candidates[-1].template, robot, trial) if candidates else first
        starts = [
            (f, best)
            for f, found in seen
            if (best := _best_start_fit(f, found, scene, known, slides))
        ]
        if not starts:
            break
        candidates.append(
            _refine_template(
                _fits_with_above_median_support(starts) if candidates else starts, scene, known
            )
        )
        if candidates[-1].support > SUFFICIENT_EDGE_SUPPORT:
            break
    if not candidates:
        return None
    return max(candidates, key=lambda one: one.support_score)


def relearned_template(
    outline: LearnedTemplate,
    samples: Sequence[Frame],
    scene: DetectionScene,
    robot: Robot,
    trial: Trial,
) -> LearnedTemplate:
    """Template learned again, in a scene that changed little: from the fits that it has, where they
    are good; else from the samples. The old one where nothing is found.
    """
    if outline.support > SUFFICIENT_EDGE_SUPPORT:
        again = _refine_template(
            list(outline.samples),
            scene,
            outline.template,
            LEARNING_EDGE_SEARCH_RANGES_BL[-RELEARNING_STEPS:],
        )
        if again.support > SUFFICIENT_EDGE_SUPPORT:
            return again
    return learn_template(samples, scene, robot, trial) or outline


def robot_sized_blobs(frame: Frame, scene: DetectionScene, length_bl: float) -> list[Blob]:
    """What differs from the background in a frame, of the size of a robot of this length."""
    area = AREA_PER_LENGTH_SQUARED * length_bl**2
    return find_blobs((frame.luma, scene.floor), scene.plane, scene.noise, area)


def generic_template(template: OutlineTemplate, robot: Robot, trial: Trial) -> OutlineTemplate:
    """Generic template of a learned one's width and grey level, its core as learned."""
    generic = initial_template(robot, trial, float(template.half.max()), template.core_grey_level)
    return replace(generic, half=template.half, core_skin=template.core_skin)


def _fits_with_above_median_support(
    fits: list[tuple[Frame, OutlineFit]],
) -> list[tuple[Frame, OutlineFit]]:
    """Fits of no less than the median support: where two shapes compete, one of them."""
    support = [min(one.support[:2]) for _, one in fits]
    least = float(np.median(support))
    return [pair for pair, own in zip(fits, support, strict=True) if own >= least]


def _refine_template(
    starts: list[tuple[Frame, OutlineFit]],
    scene: DetectionScene,
    template: OutlineTemplate,
    lengths_bl: Sequence[float] = LEARNING_EDGE_SEARCH_RANGES_BL,
) -> LearnedTemplate:
    """LearnedTemplate of fits that start where the robot is, to the greatest of the lengths."""
    fits = starts
    for size in lengths_bl:
        shape = template.outline_arrays()
        reach = edge_search_ranges_px(scene, size, size, size)
        bend = _common_head_angle_rad(fits, scene)
        fits = [
            (
                f,
                fit_template_to_frame(
                    f.luma,
                    scene,
                    shape,
                    with_head_angle(one.pose, bend),
                    reach,
                    width_px=0.4 * reach[-1],
                ),
            )
            for f, one in fits
        ]
        kept = fits_with_near_best_support(fits)
        seen = measure_stations(kept, scene, template, int(reach[-1]))
        blur_bl = picture_blur_px(kept, scene, template, seen[0]) / scene.plane.px_per_bl
        template = with_learned_outline(template, *seen, blur_bl=blur_bl)
    shape = template.outline_arrays()
    last = [
        fit_template_to_frame(
            f.luma, scene, shape, one.pose, edge_search_ranges_px(scene, 0.024, 0.024)
        )
        for f, one in fits
    ]
    pairs = tuple((frame, one) for (frame, _), one in zip(fits, last, strict=True))
    offsets, _ = measure_stations(
        fits_with_near_best_support(pairs),
        scene,
        template,
        int(edge_search_ranges_px(scene, 0.024)[0]),
    )
    template = without_biased_stations(template, offsets * scene.plane.px_per_bl)
    return LearnedTemplate(template, pairs, float(np.median([one.support[2] for one in last])))


def fits_with_near_best_support(
    fits: Sequence[tuple[Frame, OutlineFit]],
) -> list[tuple[Frame, OutlineFit]]:
    """Fits not much worse than the best: a hand's blob must not enter the robot's shape."""
    best = max(one.support[2] for _, one in fits)
    return [(frame, one) for frame, one in fits if one.support[2] > best - 0.3]


def _template_from_blobs(
    seen: Sequence[tuple[Frame, list[Blob]]], robot: Robot, trial: Trial
) -> OutlineTemplate | None:
    """Generic template of the width of the blobs that could be the robot by length and area."""
    length = robot_length_bl(robot, trial)
    sides = [_strongest_blobs(seen, length, sign) for sign in (1.0, -1.0)]
    likely = max(sides, key=_same_body_score)
    if not likely:
        return None
    half = float(np.median([b.half_width_bl for b in likely]))
    return initial_template(robot, trial, half, float(np.median([b.skin for b in likely])))


def _strongest_blobs(
    seen: Sequence[tuple[Frame, list[Blob]]], length_bl: float, sign: float
) -> list[Blob]:
    """From each frame the strongest blob of a sign and of the robot's size."""
    likely = []
    for _, found in seen:
        fitting = [b for b in found if b.contrast * sign > 0 and _has_robot_size(b, length_bl)]
        likely += sorted(fitting, key=lambda b: -abs(b.contrast) * b.area_bl2)[:1]
    return likely


def _has_robot_size(blob: Blob, length_bl: float) -> bool:
    return (
        0.05 * length_bl**2 < blob.area_bl2 < 0.5 * length_bl**2
        and 0.03 * length_bl < blob.half_width_bl < 0.25 * length_bl
        and 0.6 * length_bl < _longest_extent_bl(blob) < 1.7 * length_bl
    )


def _same_body_score(likely: Sequence[Blob]) -> float:
    """How much blobs of several frames look like one body: many, strong, of one grey level."""
    if not likely:
        return 0.0
    skins = [blob.skin for blob in likely]
    strength = float(np.median([abs(blob.contrast) * blob.area_bl2 for blob in likely]))
    return len(likely) * strength / (5.0 + float(np.std(skins)))


def _longest_extent_bl(blob: Blob) -> float:
    """Longest way across a blob, body lengths."""
    angles = np.linspace(0, math.pi, 24, endpoint=False)
    across = blob.outline_bl @ np.stack([np.cos(angles), np.sin(angles)])
    return float(np.ptp(across, axis=0).max())


def _best_start_fit(
    frame: Frame,
    found: list[Blob],
    scene: DetectionScene,
    template: OutlineTemplate,
    slides_bl: Sequence[float],
) -> OutlineFit | None:
    """Best coarse fit of the generic template to any likely blob of a frame.

    Begun at the blob's poses, each moved along its heading by `slides_bl`: a part of a body lies
    anywhere along it.
    """
    shape = template.outline_arrays()
    reach = edge_search_ranges_px(scene, 0.078, 0.066, 0.054, 0.042, 0.036)
    tried = [
        fit_template_to_frame(
            frame.luma,
            scene,
            shape,
            moved_along_heading(pose, slide),
            reach,
            width_px=0.3 * reach[-1],
        )
        for blob in found
        if is_plausible_blob(blob, template)
        for pose in candidate_poses(blob, template, scene.head_angle_rad)
        for slide in slides_bl
    ]
    tried = [one for one in tried if abs(one.pose[3] - scene.head_angle_rad) < 0.6]
    return max(tried, key=lambda one: one.nearness, default=None)


def _common_head_angle_rad(
    fits: Sequence[tuple[Frame, OutlineFit]], scene: DetectionScene
) -> float:
    """Head angle of all frames: the servo holds it, so that no single frame may bend the head."""
    bend = float(np.median([one.pose[3] for _, one in fits]))
    return (
        bend
        if abs(bend - scene.head_angle_rad) < MAX_LEARNED_HEAD_ANGLE_DEVIATION_RAD
        else scene.head_angle_rad
    )


def with_head_angle(pose: Float, bend: float) -> Float:
    """A pose with another head angle."""
    return np.append(pose[:3], bend)


def moved_along_heading(pose: Float, along_bl: float) -> Float:
    """A pose moved along its core's heading."""
    return pose + along_bl * np.array([math.cos(pose[2]), math.sin(pose[2]), 0.0, 0.0])
