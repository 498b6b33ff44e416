"""Which of several bodies is meant: the one at a stated place in the first frame, then the one that
can have come from where it was seen last.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...data import Float
from .template import OutlineTemplate

START_TOLERANCE_LENGTHS = 0.12
"""How far the stated place may lie from the body's axis."""
SEARCH_RADIUS_LENGTHS, SEARCH_RADIUS_GROWTH_LENGTHS = 0.8, 0.25
MAX_SEARCH_RADIUS_LENGTHS = 2.5
"""Distance within which a body is looked for that was lost, its growth with each frame, its end."""


@dataclass
class IntendedBody:
    """A body to be followed. start_bl: (2,) the stated place [body lengths]; None: any body is.

    last: pose in which it was seen last; frames_since: how many frames ago.
    """

    template: OutlineTemplate
    start_bl: Float | None
    last: Float | None = None
    frames_since: int = 0

    def record(self, pose: Float | None) -> None:
        """Take note of the next frame's pose (4,); None where the body was not found."""
        if pose is None:
            self.frames_since += 1
        else:
            self.last, self.frames_since = pose, 0

    def may_be(self, pose: Float) -> bool:
        """Whether a body with this pose (4,) can be the intended one."""
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
    """Distance, in lengths of the body, within which it is looked for so many frames later."""
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
