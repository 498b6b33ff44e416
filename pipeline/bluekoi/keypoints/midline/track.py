"""One body's fits from frame to frame, and its predicted pose in the next frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ...data import Float
from .midline_fit import MIN_SEEN_SHARE

LOST_AFTER_FRAMES, TYPICAL_SCORE_FRAMES = 8, 25


@dataclass(frozen=True)
class MidlineFit:
    """Fit of one frame.

    pose: (P,). information: (P, P), and meat: (P, P) sum of g g' over the stations' scores g, both
    in body axes (sandwich covariance: I^-1 meat I^-1). support: (8,) explained share of head, core,
    tail and whole body; share seen of the body, and of its head, core and tail.
    """

    pose: Float
    information: Float
    meat: Float
    support: Float

    @property
    def support_score(self) -> float:
        """Mean of the whole body's support and of its worst third's (at least -1); -1 if unseen."""
        if self.support[4] < MIN_SEEN_SHARE:
            return -1.0
        return 0.5 * float(self.support[3]) + 0.5 * max(float(self.support[:3].min()), -1.0)


@dataclass
class BodyFitHistory:
    """One body's fits so far.

    doubtful_s: time since which it may be another body. unsure: frames in which a body alone jumps.
    """

    times: list[float] = field(default_factory=list)
    fits: list[MidlineFit | None] = field(default_factory=list)
    doubtful_s: float = math.inf
    unsure: set[int] = field(default_factory=set)

    @property
    def recent_fits(self) -> list[tuple[float, MidlineFit]]:
        """The last two fits with their times, of the last frames."""
        recent = zip(self.times[-LOST_AFTER_FRAMES:], self.fits[-LOST_AFTER_FRAMES:], strict=True)
        return [(t, one) for t, one in recent if one is not None][-2:]

    @property
    def typical_score(self) -> float:
        """Upper quartile of the last fits' support scores."""
        scores = [one.support_score for one in self.fits[-TYPICAL_SCORE_FRAMES:] if one is not None]
        return float(np.quantile(scores, 0.75)) if scores else 1.0

    @property
    def frames_since_seen(self) -> int:
        """For how many frames it has not been seen."""
        for count, one in enumerate(reversed(self.fits)):
            if one is not None:
                return count
        return len(self.fits)

    def last_seen_pose(self) -> Float | None:
        """Pose seen last."""
        return next((one.pose for one in reversed(self.fits) if one is not None), None)

    def predicted_pose(self, time_s: float) -> Float | None:
        """Expected pose: position and heading extrapolated, the bending constant.

        Extrapolated by one interval at most: a body that is lost for longer may have turned, and
        the search grows around its place instead.
        """
        known = self.recent_fits
        if len(known) < 2:
            return self.last_seen_pose()
        (before_s, before), (last_s, last) = known
        steps = min((time_s - last_s) / (last_s - before_s), 1.0)
        pose = last.pose.copy()
        pose[:3] += steps * (last.pose - before.pose)[:3]
        return pose

    def append_frame(self, time_s: float, one: MidlineFit | None) -> None:
        """Append a frame."""
        self.times.append(time_s)
        self.fits.append(one)
