"""Keypoints of a bending body: learn its template from a few frames, then track its midline."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...data import Float, Frame, Keypoints
from ...study import Robot, Trial
from ..outline.plane import SwimmingPlaneMap
from .blobs import BackgroundModel, background_difference_crop, background_model, find_blobs
from .learning import learn_template
from .midline_fit import BendingTemplate, bending_basis
from .to_keypoints import keypoint_arcs, keypoints_from_fits, total_length
from .tracking import track_body

SAMPLE_FRAMES = 25
MIN_SUPPORT, MIN_LEARNING_FRAMES, MIN_FRAMES_SHARE = 0.9, 8, 0.8
MIN_BEND_RAD, BEND_QUANTILE = 0.12, 0.75
CORE_ARC_RANGE = (0.35, 0.7)
MIN_SHARE_OF_MULTI_BODY_FRAMES = 0.2


@dataclass(frozen=True)
class LearnedBody:
    """A learned body: background, template, poses (n, 3 + BEND_TERMS) and support (n,) in the
    frames it was learned from, and whether some frames show several bodies.
    """

    arena: BackgroundModel
    shape: BendingTemplate
    poses: Float
    support: Float
    several: bool

    @property
    def is_core_bending(self) -> bool:
        """Whether the core, rigid in a robot of two plates, bends from picture to picture."""
        ends = bending_basis(np.array(CORE_ARC_RANGE))
        turn = self.poses[self.support > MIN_SUPPORT, 3:] @ (ends[1] - ends[0])
        if len(turn) < max(MIN_LEARNING_FRAMES, MIN_FRAMES_SHARE * len(self.poses)):
            return False
        return float(np.quantile(np.abs(turn - np.median(turn)), BEND_QUANTILE)) > MIN_BEND_RAD


def learn_body(
    samples: Sequence[Frame], plane: SwimmingPlaneMap, robot: Robot, trial: Trial
) -> LearnedBody | None:
    """The body in a few frames spread over a recording; None without one."""
    images = [frame.luma for frame in samples]
    arena = background_model(images, plane, total_length(robot, trial))
    found = learn_template(images, arena)
    if found is None:
        return None
    counts = np.array(
        [len(find_blobs(background_difference_crop(image, arena), arena)) for image in images]
    )
    several = float(np.mean(counts > 1)) > MIN_SHARE_OF_MULTI_BODY_FRAMES
    return LearnedBody(arena, *found, several)


def detect_keypoints(
    film: Iterable[Frame], body: LearnedBody, robot: Robot, trial: Trial
) -> Keypoints:
    """Keypoints of every frame of a film."""
    start = trial.start_px
    start_px = None if start is None else np.array(start)
    times, track = track_body(film, body.arena, body.shape, start_px, several=body.several)
    return keypoints_from_fits(times, track, body.arena, body.shape, keypoint_arcs(robot, trial))
