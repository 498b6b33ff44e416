"""Keypoints of a bending body: its look learned, its midline followed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...data import Float, Frame, Keypoints
from ...study import Robot, Trial
from ..outline.plane import Plane
from .blobs import Arena, arena_of, blobs, cut
from .curve import Shape, basis
from .learning import learn
from .outcome import arcs_of, keypoints_of, total_length
from .tracking import follow

SAMPLES = 25
MIN_EXPLAINED_VARIANCE, MIN_SEEN, MIN_SHARE_OF_FRAMES = 0.9, 8, 0.8
BENT_RAD, BENT_QUANTILE = 0.12, 0.75
CORE = (0.35, 0.7)
SEVERAL_BODIES_SHARE = 0.2


@dataclass(frozen=True)
class Learned:
    """A learned body: the place, its look, its poses (n, 3 + JOINTS) and support (n,) in the
    pictures it was learned from, and whether several bodies are in some.
    """

    arena: Arena
    shape: Shape
    poses: Float
    support: Float
    several: bool

    @property
    def bends(self) -> bool:
        """Whether the core, rigid in a robot of two plates, bends from picture to picture."""
        ends = basis(np.array(CORE))
        turn = self.poses[self.support > MIN_EXPLAINED_VARIANCE, 3:] @ (ends[1] - ends[0])
        if len(turn) < max(MIN_SEEN, MIN_SHARE_OF_FRAMES * len(self.poses)):
            return False
        return float(np.quantile(np.abs(turn - np.median(turn)), BENT_QUANTILE)) > BENT_RAD


def learned(samples: Sequence[Frame], plane: Plane, robot: Robot, trial: Trial) -> Learned | None:
    """The body in a few frames spread over a recording; None without one."""
    images = [frame.luma for frame in samples]
    arena = arena_of(images, plane, total_length(robot, trial))
    found = learn(images, arena)
    if found is None:
        return None
    counts = np.array([len(blobs(cut(image, arena), arena)) for image in images])
    several = float(np.mean(counts > 1)) > SEVERAL_BODIES_SHARE
    return Learned(arena, *found, several)


def detect(film: Iterable[Frame], body: Learned, robot: Robot, trial: Trial) -> Keypoints:
    """Keypoints of every frame of a film."""
    start = trial.start_px
    start_px = None if start is None else np.array(start)
    times, track = follow(film, body.arena, body.shape, start_px, several=body.several)
    return keypoints_of(times, track, body.arena, body.shape, arcs_of(robot, trial))
