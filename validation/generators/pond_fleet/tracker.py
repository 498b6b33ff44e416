"""Errors of the tracker: wandering and independent errors of labels, outliers, gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .robots import Array, Robot

LABELS = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
COARSENESS = np.array([1.1, 0.9, 1.0, 1.2, 1.8])
"""Errors of each label over those of the core's."""


@dataclass(frozen=True)
class Tracker:
    """independent_px, wandering_px: standard deviations; memory_s: of the wandering error.

    outlier_share: of points. gap_share: of points that begin a gap of mean length gap_frames.
    jump_px: size of outliers. gap_mark: how unseen points are written.
    """

    independent_px: float
    wandering_px: float
    memory_s: float
    outlier_share: float
    gap_share: float
    gap_frames: float
    jump_px: float
    gap_mark: str

    def sample_error(self, metres_per_px: float, head_length: float) -> tuple[float, float]:
        """Error of place (m) and heading (rad) averaged over about a tail beat."""
        place = metres_per_px * float(np.hypot(0.7 * self.wandering_px, 0.3 * self.independent_px))
        return place, 1.4 * place / head_length


def draw_tracker(rng: np.random.Generator, robot: Robot, metres_per_px: float) -> Tracker:
    """A tracker whose wandering errors go with the robot's size or, if larger, with a pixel."""
    by_size = rng.uniform(0.0008, 0.003) * robot.body_length / metres_per_px
    return Tracker(
        independent_px=rng.uniform(0.15, 0.5), wandering_px=max(by_size, rng.uniform(0.15, 0.5)),
        memory_s=rng.uniform(0.06, 0.3), outlier_share=rng.uniform(0.0005, 0.006),
        gap_share=rng.uniform(0.0002, 0.003), gap_frames=rng.uniform(2, 9),
        jump_px=rng.uniform(0.08, 0.35) * robot.body_length / metres_per_px,
        gap_mark=str(rng.choice(["empty", "unlikely"])),
    )  # fmt: skip


def track(
    rng: np.random.Generator, tracker: Tracker, true: Array, fps: float
) -> tuple[Array, Array]:
    """Labels as tracked (frames, labels, 2) in px and likelihoods (frames, labels)."""
    frames, labels, _ = true.shape
    kept = float(np.exp(-1 / (tracker.memory_s * fps)))
    kicks = rng.normal(size=true.shape)
    kicks[1:] *= np.sqrt(1 - kept**2)
    wander = lfilter([1.0], [1.0, -kept], kicks, axis=0)
    error = tracker.wandering_px * wander + tracker.independent_px * rng.normal(size=true.shape)
    seen = true + error * COARSENESS[:, None]
    likelihood = 1 - 0.04 * rng.exponential(size=(frames, labels))
    wild = rng.random((frames, labels)) < tracker.outlier_share * COARSENESS
    seen[wild] += tracker.jump_px * rng.standard_t(3, size=(int(wild.sum()), 2))
    likelihood[wild] = rng.uniform(0.2, 0.98, int(wild.sum()))
    gone = _gaps(rng, tracker, frames, labels)
    likelihood = np.clip(likelihood, 0.11, 1.0)
    if tracker.gap_mark == "empty":
        seen[gone] = np.nan
        likelihood[gone] = np.nan
    else:
        seen[gone] += tracker.jump_px * rng.normal(size=(int(gone.sum()), 2))
        likelihood[gone] = rng.uniform(0.001, 0.09, int(gone.sum()))
    return seen, likelihood


def _gaps(rng: np.random.Generator, tracker: Tracker, frames: int, labels: int) -> Array:
    """Frames in which labels are not seen; one gap in five takes the whole robot."""
    gone = np.zeros((frames, labels), dtype=bool)
    begins = np.argwhere(rng.random((frames, labels)) < tracker.gap_share * COARSENESS)
    for frame, label in begins:
        until = frame + 1 + rng.geometric(1 / tracker.gap_frames)
        which = slice(None) if rng.random() < 0.2 else label
        gone[frame:until, which] = True
    return np.asarray(gone)
