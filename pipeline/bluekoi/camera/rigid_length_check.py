"""Remaining geometry error from the pattern of rigid keypoint distances over the pool.

Needs no ground truth: the head's and the core's lengths are known and must come out the same
everywhere. The pattern over the pool identifies the error that changes them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float, KeypointPositions
from ..errors import InputError
from ..study import Robot
from .geometry_hypotheses import (
    GEOMETRY_HYPOTHESES,
    SYSTEMATIC_LENGTH_ERROR_SHARE,
    GeometryHypothesis,
    HypothesisFit,
    fit_hypothesis,
)
from .length_error_map import LengthErrorMap, length_error_map
from .pool_projection import PoolCamera
from .rigid_distances import (
    CameraGeometry,
    RigidDistances,
    length_sensitivity_to_camera_errors,
    length_sensitivity_to_keypoint_shift,
    remove_camera_errors,
    rigid_distances,
)
from .rigid_length_windows import window_means

GEOMETRY_FALSE_ALARM_PROBABILITY = 0.001
RIVAL_LOG_LIKELIHOOD_MARGIN = 6.0
MAX_LENS_ERROR_ITERATIONS = 4
"""Gauss-Newton steps for a large error of the lens; the gain is that of the one before last."""


@dataclass(frozen=True)
class GeometryCheck:
    """Outcome `nothing`, or the name of the error that explains the rigid distances.

    best: the fit behind it; rivals: names that explain them as well; fits: all, best first;
    mean_excess, mean_excess_std: overall relative error of length, trials as clusters.
    by_trial: number of each trial -> mean of its relative errors that `best` leaves, and its std.
    windows: means of the distances over short windows.
    """

    outcome: str
    sentence: str
    best: HypothesisFit | None
    rivals: tuple[str, ...]
    fits: tuple[HypothesisFit, ...]
    mean_excess: float
    mean_excess_std: float
    map: LengthErrorMap
    by_trial: Mapping[int, tuple[float, float]]
    windows: RigidDistances


def check_rigid_distances(
    geometry: CameraGeometry,
    distances: RigidDistances,
    *,
    subject: str = "rigid lengths come out",
    min_share: float = SYSTEMATIC_LENGTH_ERROR_SHARE,
    given: Sequence[str] = (),
) -> GeometryCheck:
    """Outcome of the rigid distances of one campaign, mapped with the camera and depth of
    `geometry`.

    An error is named when its F test, with trials as independent clusters, would pass by chance
    once in 1000 over all hypotheses, and when it changes lengths by more than a detector's
    systematic errors may. One that would have to be implausibly large (a focal length off by a
    third) is named only where no other is certain; a lens error is first refined beyond small ones.

    subject: start of the sentence; min_share: of `HypothesisFit`. given: hypotheses about a value
    stated in study.yaml; a wrong scale is preferred where it explains the distances as well.
    Hypotheses that change none of the distances are left out.
    """
    patterns = {
        **length_sensitivity_to_camera_errors(geometry, distances),
        **length_sensitivity_to_keypoint_shift(distances),
    }
    patterns = {name: pattern for name, pattern in patterns.items() if pattern.any()}
    fits = [
        _refine_lens_error(fit_hypothesis(one, patterns, distances, min_share), geometry, distances)
        for one in GEOMETRY_HYPOTHESES
        if set(one.parameters) <= set(patterns)
    ]
    fits.sort(key=lambda fit: -fit.gain)
    best, rivals = _best_hypothesis(fits, given)
    mean, std = _mean_excess(distances)
    predicted = np.zeros(len(distances.excess_m))
    if best is not None:
        design = np.array([patterns[name] for name in best.hypothesis.parameters])
        predicted = np.array(best.values) @ design
    return GeometryCheck(
        outcome=best.hypothesis.name if best else "nothing",
        sentence=_geometry_sentence(subject, best, rivals, (mean, std, min_share)),
        best=best,
        rivals=rivals,
        fits=tuple(fits),
        mean_excess=mean,
        mean_excess_std=std,
        map=length_error_map(geometry.camera, distances, predicted),
        by_trial=_mean_excess_by_trial(distances, predicted),
        windows=window_means(distances),
    )


def _best_hypothesis(
    fits: list[HypothesisFit], given: Sequence[str]
) -> tuple[HypothesisFit | None, tuple[str, ...]]:
    """The fit to name, if any, and the names that explain the distances as well."""
    significant = [
        f for f in fits if f.detectable and f.p_value < GEOMETRY_FALSE_ALARM_PROBABILITY / len(fits)
    ]
    best = next(iter([f for f in significant if f.plausible] or significant), None)
    if best is None:
        return None, ()
    first = best
    near = [f for f in fits if f.gain > first.gain - RIVAL_LOG_LIKELIHOOD_MARGIN
            and (f.plausible or not first.plausible)]  # fmt: skip
    if first.hypothesis.name in given:
        best = next((f for f in near if f.hypothesis.name == "scale_error"), first)
    return best, tuple(f.label for f in near if f is not best)


def _refine_lens_error(
    first: HypothesisFit, geometry: CameraGeometry, distances: RigidDistances
) -> HypothesisFit:
    """The fit of a lens error by Gauss-Newton, where the first step is implausibly large: patterns
    of first order hold for small errors only.
    """
    if first.plausible or first.hypothesis.name != "lens_error":
        return first
    found, names = first, first.hypothesis.parameters
    for _ in range(MAX_LENS_ERROR_ITERATIONS):
        errors = dict(zip(names, found.values, strict=True))
        try:
            corrected, rest = remove_camera_errors(geometry, distances, errors)
            patterns = length_sensitivity_to_camera_errors(corrected, rest, names)
        except InputError:  # the corners fit no pose under such a lens
            return first
        design = np.column_stack([patterns[name] for name in names])
        whole = replace(rest, excess_m=rest.excess_m + design @ np.array(found.values))
        gain = float(np.sum((distances.excess_m**2 - rest.excess_m**2) / distances.std_m**2))
        refit = fit_hypothesis(first.hypothesis, patterns, whole, first.min_share)
        found = replace(refit, gain=gain)
    return found if found.gain > first.gain else first


def estimate_keypoint_depth(
    camera: PoolCamera,
    trials: Sequence[KeypointPositions],
    *,
    depth_m: float,
    head_lengths_m: Sequence[float],
    robot: Robot,
) -> tuple[float, float]:
    """Depth of the keypoints, m, and its std, for trials mapped with `camera` at a guess `depth_m`.

    The depth at which the rigid distances come out right, everything else being right: 1 mm of
    depth is worth about 0.04 % of length from 2 m up, so it needs lengths and pool known well.
    """
    distances = rigid_distances(trials, head_lengths_m, robot)
    deeper = GeometryHypothesis("keypoint_depth", ("depth_m",), (1.0,), ("m",), "")
    patterns = length_sensitivity_to_camera_errors(
        CameraGeometry(camera, depth_m), distances, deeper.parameters
    )
    found = fit_hypothesis(deeper, patterns, distances)
    return depth_m + found.values[0], found.stds[0]


def _mean_excess(distances: RigidDistances) -> tuple[float, float]:
    """Weighted mean of the relative excess and its std, trials as clusters."""
    relative = distances.excess_m / distances.known_m
    weight = (distances.known_m / distances.std_m) ** 2
    mean = float(np.average(relative, weights=weight))
    labels = np.unique(distances.trial)
    scores = [np.sum((weight * (relative - mean))[distances.trial == trial]) for trial in labels]
    return mean, float(np.linalg.norm(scores)) / float(np.sum(weight))


def _mean_excess_by_trial(
    distances: RigidDistances, predicted: Float
) -> dict[int, tuple[float, float]]:
    """Weighted mean of each trial's relative errors, less those `predicted` (n,) m; its std."""
    relative = (distances.excess_m - predicted) / distances.known_m
    weight = (distances.known_m / distances.std_m) ** 2
    chosen = {int(trial): distances.trial == trial for trial in np.unique(distances.trial)}
    return {
        trial: (
            float(np.average(relative[these], weights=weight[these])),
            float(weight[these].sum() ** -0.5),
        )
        for trial, these in chosen.items()
    }


def _geometry_sentence(
    subject: str, best: HypothesisFit | None, rivals: tuple[str, ...],
    excess: tuple[float, float, float],
) -> str:  # fmt: skip
    mean, std, min_share = excess
    length = f"{subject} {100 * mean:+.2f} +- {100 * std:.2f} % over the pool"
    if best is None and abs(mean) > max(2 * min_share, 4 * std):
        return f"{length}; too few trials to say why"
    if best is None:
        return f"{length}; no geometry error shows"
    also = f"; as well explained by {', '.join(rivals)}" if rivals else ""
    return f"{length}; {best.text}{also}"
