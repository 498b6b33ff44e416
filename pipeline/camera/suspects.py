"""Errors of camera, pool and keypoints that rigid distances can show, each fitted alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from ..data import Float
from .distances import Distances


@dataclass(frozen=True)
class Suspect:
    """One possible error: its name, parameters, how large each may plausibly be, its statement."""

    name: str
    parameters: tuple[str, ...]
    widths: tuple[float, ...]
    units: tuple[str, ...]
    sentence: str


MOST_WIDTHS = 4.0
SYSTEMATIC = 0.0005
"""Detection is off by 0.05 to 0.1 px in the same place in every trial (docs/measuring.md), over
parts that are 70 to 150 px long: lengths wrong by some 0.05 % tell of nothing, however many frames
agree.
"""
SUSPECTS = (
    Suspect("scale_error", ("scale",), (0.02,), ("-",), "the pool is larger than stated by"),
    Suspect(
        "lens_error", ("focal", "k1"), (0.02, 0.05), ("-", "-"), "the lens differs from its matrix"
    ),
    Suspect(
        "camera_shift",
        ("tilt_x_rad", "tilt_y_rad"),
        (0.02, 0.02),
        ("rad", "rad"),
        "the camera has turned since the corners were taken by",
    ),
    Suspect("keypoint_depth", ("depth_m",), (0.02,), ("m",), "the keypoints lie deeper by"),
    Suspect("sinking", ("sinks_m_s",), (0.01,), ("m/s",), "the robot sinks during each trial by"),
    Suspect(
        "uncorrected_refraction",
        ("refractive_index",),
        (0.33,),
        ("-",),
        "light is bent more at the surface than assumed, by an index of",
    ),
    *(
        Suspect("keypoint_bias", (f"{part}_m",), (0.005,), ("m",), f"{part} is marked off by")
        for part in ("head_tip", "hinge", "core_center", "tail_base")
    ),
)


@dataclass(frozen=True)
class Estimate:
    """One suspect fitted alone: its parameters' values and std, and how much it explains.

    gain: fall of the misfit (chi-squared of independent frames, less the price of implausibly
    large values). p_value: chance of such a pattern with nothing wrong, trials as clusters.
    share: root mean square of the relative change of length that the values make; least: share that
    a detector's lasting errors may reach.
    """

    suspect: Suspect
    values: tuple[float, ...]
    stds: tuple[float, ...]
    gain: float
    p_value: float
    share: float
    least: float = SYSTEMATIC

    @property
    def plausible(self) -> bool:
        """Whether all values lie within `MOST_WIDTHS` of what is usual for such an error."""
        widths = np.array(self.suspect.widths)
        return bool(np.all(np.abs(self.values) <= MOST_WIDTHS * widths))

    @property
    def seen(self) -> bool:
        """Whether it changes lengths by more than a detector may, always in the same place."""
        return self.share > self.least

    @property
    def text(self) -> str:
        """The statement with its numbers."""
        terms = [
            f"{name} {value:+.3g} +- {std:.1g}" + ("" if unit == "-" else f" {unit}")
            for name, value, std, unit in zip(
                self.suspect.parameters, self.values, self.stds, self.suspect.units, strict=True
            )
        ]
        return f"{self.suspect.sentence}: {', '.join(terms)}"


def estimate(
    suspect: Suspect, patterns: dict[str, Float], distances: Distances, least: float = SYSTEMATIC
) -> Estimate:
    """One suspect fitted to the distances alone; least: see `Estimate`."""
    design = np.column_stack([patterns[name] for name in suspect.parameters])
    weight = 1 / distances.std_m**2
    prior = np.diag(1 / np.array(suspect.widths) ** 2)
    normal = design.T @ (design * weight[:, None]) + prior
    pull = design.T @ (weight * distances.excess_m)
    values = np.asarray(np.linalg.solve(normal, pull), dtype=np.float64)
    cov, trials = _clustered(design, values, distances, normal)
    k = len(values)
    wald = float(values @ np.linalg.solve(cov, values)) / k
    return Estimate(
        suspect=suspect,
        values=tuple(map(float, values)),
        stds=tuple(map(float, np.sqrt(np.diag(cov)))),
        gain=float(pull @ values),
        p_value=float(fdtrc(k, max(1, trials - k), wald)),
        share=float(np.sqrt(np.mean((design @ values / distances.known_m) ** 2))),
        least=least,
    )


def _clustered(
    design: Float, values: Float, distances: Distances, normal: Float
) -> tuple[Float, int]:
    """Covariance of the values: the larger of independent frames and trials as clusters."""
    bread = np.linalg.inv(normal)
    miss = (distances.excess_m - design @ values) / distances.std_m**2
    labels = np.unique(distances.trial)
    pulls = np.array([design[distances.trial == t].T @ miss[distances.trial == t] for t in labels])
    meat = pulls.T @ pulls * len(labels) / max(1, len(labels) - 1)
    sandwich = bread @ meat @ bread
    spread = np.sqrt(np.maximum(np.diag(sandwich) / np.diag(bread), 1.0))
    return bread * np.outer(spread, spread), len(labels)
