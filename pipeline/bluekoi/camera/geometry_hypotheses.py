"""Errors of camera, pool and keypoints that rigid distances can show, each fitted alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from ..data import Float
from .rigid_distances import RigidDistances


@dataclass(frozen=True)
class GeometryHypothesis:
    """One possible error: name, parameters with their prior std and unit, and its statement.

    largest: magnitudes beyond which the error is implausible; `MAX_VALUE_IN_PRIOR_STDS` deviations
    unless given.
    """

    name: str
    parameters: tuple[str, ...]
    prior_std: tuple[float, ...]
    units: tuple[str, ...]
    sentence: str
    largest: tuple[float, ...] = ()


MAX_VALUE_IN_PRIOR_STDS = 4.0
SYSTEMATIC_LENGTH_ERROR_SHARE = 0.0005
"""Detection errs by 0.05 to 0.1 px in the same place in every trial (docs/measuring.md), over parts
that are 70 to 150 px long: length errors of 0.05 % show nothing, however many frames agree.
"""
GEOMETRY_HYPOTHESES = (
    GeometryHypothesis(
        "scale_error",
        ("scale",),
        (0.02,),
        ("-",),
        "the pool is larger than stated by",
        largest=(1.0,),
    ),  # a side read from the wrong end of a tape has any size
    GeometryHypothesis(
        "lens_error", ("focal", "k1"), (0.02, 0.05), ("-", "-"), "the lens differs from its matrix"
    ),
    GeometryHypothesis(
        "camera_shift",
        ("tilt_x_rad", "tilt_y_rad"),
        (0.02, 0.02),
        ("rad", "rad"),
        "the camera has turned since the corners were taken by",
    ),
    GeometryHypothesis(
        "keypoint_depth", ("depth_m",), (0.02,), ("m",), "the keypoints lie deeper by"
    ),
    GeometryHypothesis(
        "sinking", ("sinks_m_s",), (0.01,), ("m/s",), "the robot sinks during each trial by"
    ),
    GeometryHypothesis(
        "uncorrected_refraction",
        ("refractive_index",),
        (0.33,),
        ("-",),
        "light is bent more at the surface than assumed, by an index of",
    ),
    *(
        GeometryHypothesis(
            "keypoint_bias", (f"{part}_m",), (0.005,), ("m",), f"{part} is marked off by"
        )
        for part in ("head_tip", "hinge", "core_center", "tail_base")
    ),
)


@dataclass(frozen=True)
class HypothesisFit:
    """One hypothesis fitted alone: its parameters' values and std, and how much it explains.

    gain: fall of the misfit (chi-squared of independent frames, less the penalty of the prior).
    p_value: chance of such a pattern with nothing wrong, trials as clusters. share: root mean
    square of the relative change of length that the values make; min_share: share that a detector's
    systematic errors may reach.
    """

    hypothesis: GeometryHypothesis
    values: tuple[float, ...]
    stds: tuple[float, ...]
    gain: float
    p_value: float
    share: float
    min_share: float = SYSTEMATIC_LENGTH_ERROR_SHARE

    @property
    def plausible(self) -> bool:
        """Whether no value is larger than its hypothesis allows."""
        stds = self.hypothesis.prior_std
        largest = self.hypothesis.largest or tuple(MAX_VALUE_IN_PRIOR_STDS * std for std in stds)
        return bool(np.all(np.abs(self.values) <= np.array(largest)))

    @property
    def detectable(self) -> bool:
        """Whether it changes lengths by more than a detector's systematic errors may."""
        return self.share > self.min_share

    @property
    def label(self) -> str:
        """Name of the hypothesis, with the keypoint of a keypoint bias."""
        part = self.hypothesis.parameters[0].removesuffix("_m")
        name = self.hypothesis.name
        return f"{name} of {part}" if name == "keypoint_bias" else name

    @property
    def text(self) -> str:
        """The statement with its numbers."""
        h = self.hypothesis
        terms = [
            f"{name} {value:+.3g} +- {std:.1g}" + ("" if unit == "-" else f" {unit}")
            for name, value, std, unit in zip(
                h.parameters, self.values, self.stds, h.units, strict=True
            )
        ]
        return f"{h.sentence}: {', '.join(terms)}"


def fit_hypothesis(
    hypothesis: GeometryHypothesis, patterns: dict[str, Float], distances: RigidDistances,
    min_share: float = SYSTEMATIC_LENGTH_ERROR_SHARE,
) -> HypothesisFit:  # fmt: skip
    """One hypothesis fitted alone by weighted least squares with its prior.

    patterns: d(distance)/d(parameter), (n,) of each.
    """
    design = np.column_stack([patterns[name] for name in hypothesis.parameters])
    weight = 1 / distances.std_m**2
    prior = np.diag(1 / np.array(hypothesis.prior_std) ** 2)
    normal = design.T @ (design * weight[:, None]) + prior
    rhs = design.T @ (weight * distances.excess_m)
    values = np.asarray(np.linalg.solve(normal, rhs), dtype=np.float64)
    cov, trials = _covariance_and_trial_count(design, values, distances, normal)
    k = len(values)
    wald = float(values @ np.linalg.solve(cov, values)) / k
    return HypothesisFit(
        hypothesis=hypothesis,
        values=tuple(map(float, values)),
        stds=tuple(map(float, np.sqrt(np.diag(cov)))),
        gain=float(rhs @ values),
        p_value=float(fdtrc(k, max(1, trials - k), wald)),
        share=float(np.sqrt(np.mean((design @ values / distances.known_m) ** 2))),
        min_share=min_share,
    )


def _covariance_and_trial_count(
    design: Float, values: Float, distances: RigidDistances, normal: Float
) -> tuple[Float, int]:
    """Covariance of the fitted values, and the number of trials. Each standard deviation is the
    larger of two: that of independent frames, and the robust one with trials as clusters.
    """
    bread = np.linalg.inv(normal)
    weighted = (distances.excess_m - design @ values) / distances.std_m**2
    labels = np.unique(distances.trial)
    scores = np.array(
        [design[distances.trial == t].T @ weighted[distances.trial == t] for t in labels]
    )
    meat = scores.T @ scores * len(labels) / max(1, len(labels) - 1)
    ratio = np.sqrt(np.maximum(np.diag(bread @ meat @ bread) / np.diag(bread), 1.0))
    return bread * np.outer(ratio, ratio), len(labels)
