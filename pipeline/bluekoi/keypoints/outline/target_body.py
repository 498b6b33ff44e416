"""The target among several similar bodies: first the body at a stated position, then the body
within reach of the last position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...data import Float
from .template import OutlineTemplate

START_TOLERANCE_LENGTHS = 0.12
"""Largest distance of the stated position from the axis of the body."""
SEARCH_RADIUS_LENGTHS, SEARCH_RADIUS_GROWTH_LENGTHS = 0.8, 0.25
MAX_SEARCH_RADIUS_LENGTHS = 2.5
"""Search radius for a body that was lost, its growth with each frame, and its maximum."""


@dataclass
class TargetBody:
    """The body to track. start_bl: (2,) stated position [body lengths]; None accepts any body.

    last: pose in which it was seen last; frames_since: how many frames ago.
    """

    template: OutlineTemplate
    start_bl: Float | None
    last: Float | None = None
    frames_since: int = 0

    def record_pose(self, pose: Float | None) -> None:
        """Record the pose (4,) of the next frame; None if the body was not found."""
        if pose is None:
            self.frames_since += 1
        else:
            self.last, self.frames_since = pose, 0

    def is_candidate(self, pose: Float) -> bool:
        """Whether a body with this pose (4,) can be the target."""
        if self.start_bl is None:
            return True
        length = self.template.head_bl + self.template.core_bl + self.template.tail_bl
        if self.last is None:
            return _distance_to_axis(self.template, pose, self.start_bl) < (
                START_TOLERANCE_LENGTHS * length
            )
        distance = float(np.hypot(*(pose[:2] - self.last[:2])))
        return distance < search_radius_lengths(self.frames_since) * length


def search_radius_lengths(frames_since: int) -> float:
    """Search radius, in lengths of the body, after this number of frames without it."""
    grown = SEARCH_RADIUS_LENGTHS + SEARCH_RADIUS_GROWTH_LENGTHS * frames_since
    return min(grown, MAX_SEARCH_RADIUS_LENGTHS)


def _distance_to_axis(template: OutlineTemplate, pose: Float, place: Float) -> float:
    """Distance [body lengths] of a place (2,) from the body's axis, nose to tail tip."""
    head = np.exp(1j * (pose[2] - pose[3]))
    core = np.exp(1j * pose[2])
    back = template.core_bl + template.tail_bl
    axis = np.concatenate(
        [np.linspace(0, template.head_bl, 9) * head, -np.linspace(0, back, 17) * core]
    )
    return float(np.abs(axis + complex(pose[0], pose[1]) - complex(*place)).min())
